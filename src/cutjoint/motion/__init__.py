"""Trajectories of the tool and of the actuators, and the motion of the actuators that follows them through a
mechanism."""

from cutjoint.motion.catalogue import TRAJECTORIES
from cutjoint.motion.from_file import motion_from_file
from cutjoint.motion.joint_space import JointChirp, JointSine
from cutjoint.motion.paths import Circle, Hold, Lissajous, PointToPoint, Trapezoidal
from cutjoint.motion.pick_and_place import PickAndPlace
from cutjoint.motion.pose_moves import PoseMove
from cutjoint.motion.reference import Desired, Reference
from cutjoint.motion.splines import JointSpline, PointSpline, PoseSpline
from cutjoint.motion.swings import JointSwing, ToolSwing, about_home
from cutjoint.motion.timing import Corners
from cutjoint.motion.values import JointMotion, ToolMotion, Trajectory
from cutjoint.motion.waypoints import JointWaypoints, Waypoints
from cutjoint.motion.winding import Spiral

__all__ = [
    "TRAJECTORIES",
    "Circle",
    "Corners",
    "Desired",
    "Hold",
    "JointChirp",
    "JointMotion",
    "JointSine",
    "JointSpline",
    "JointSwing",
    "JointWaypoints",
    "Lissajous",
    "PickAndPlace",
    "PointSpline",
    "PointToPoint",
    "PoseMove",
    "PoseSpline",
    "Reference",
    "Spiral",
    "ToolMotion",
    "ToolSwing",
    "Trajectory",
    "Trapezoidal",
    "Waypoints",
    "about_home",
    "motion_from_file",
]
