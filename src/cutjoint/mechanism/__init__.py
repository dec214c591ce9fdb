"""What every model of a closed robot offers, whoever wrote it: the interface that controllers, simulator and
cross-check are written against.  No Pinocchio and no numbers of any robot here."""

from cutjoint.mechanism.interface import Actuator, JointLimits, Mechanism, kinetic_energy
from cutjoint.mechanism.pose import Pose
from cutjoint.mechanism.task import Target, Task
from cutjoint.mechanism.types import Posture, Terms, Tool

__all__ = [
    "Actuator",
    "JointLimits",
    "Mechanism",
    "Pose",
    "Posture",
    "Target",
    "Task",
    "Terms",
    "Tool",
    "kinetic_energy",
]
