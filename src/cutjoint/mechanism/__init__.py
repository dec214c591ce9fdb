"""What every model of a closed robot offers, whoever wrote it: the interface that controllers, simulator and
cross-check are written against.  No Pinocchio and no numbers of any robot here."""

from cutjoint.mechanism.interface import JointLimits, Mechanism, is_mechanism, kinetic_energy
from cutjoint.mechanism.loads import NO_LOADS, Load, Loads
from cutjoint.mechanism.names import ActuatedCoordinates, Actuator, Layout, Stored, actuated_values, in_order
from cutjoint.mechanism.physics import Bushing, JointPhysics
from cutjoint.mechanism.pose import Pose
from cutjoint.mechanism.task import Target, TargetLike, Task
from cutjoint.mechanism.types import Posture, Terms, Tool

__all__ = [
    "NO_LOADS",
    "ActuatedCoordinates",
    "Actuator",
    "Bushing",
    "JointLimits",
    "JointPhysics",
    "Layout",
    "Load",
    "Loads",
    "Mechanism",
    "Pose",
    "Posture",
    "Stored",
    "Target",
    "TargetLike",
    "Task",
    "Terms",
    "Tool",
    "actuated_values",
    "in_order",
    "is_mechanism",
    "kinetic_energy",
]
