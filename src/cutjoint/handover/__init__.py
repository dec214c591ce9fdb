"""Hand-over of runs to other programs: ROS 2 messages of all joints, passive ones too, as JSON lines or as a rosbag."""

from cutjoint.handover.joint_states import CarriedChild, JointStates, joint_states
from cutjoint.handover.writing import check_target, write

__all__ = ["CarriedChild", "JointStates", "check_target", "joint_states", "write"]
