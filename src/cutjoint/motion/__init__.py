"""Trajectories of the tool, and the motion of the actuators that follows them through a mechanism."""

from cutjoint.motion.catalogue import TRAJECTORIES
from cutjoint.motion.paths import Circle, Hold, Lissajous, PointToPoint, ToolMotion, Trajectory
from cutjoint.motion.reference import Desired, Reference

__all__ = [
    "TRAJECTORIES",
    "Circle",
    "Desired",
    "Hold",
    "Lissajous",
    "PointToPoint",
    "Reference",
    "ToolMotion",
    "Trajectory",
]
