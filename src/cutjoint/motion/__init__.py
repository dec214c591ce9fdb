"""Trajectories of the tool, and the motion of the actuators that follows them through a mechanism."""

from cutjoint.motion.catalogue import TRAJECTORIES
from cutjoint.motion.paths import Circle, Hold, Lissajous, PointToPoint
from cutjoint.motion.reference import Desired, Reference
from cutjoint.motion.values import JointMotion, ToolMotion, Trajectory

__all__ = [
    "TRAJECTORIES",
    "Circle",
    "Desired",
    "Hold",
    "JointMotion",
    "Lissajous",
    "PointToPoint",
    "Reference",
    "ToolMotion",
    "Trajectory",
]
