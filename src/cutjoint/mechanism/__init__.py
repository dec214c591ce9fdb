"""What every model of a closed robot offers, whoever wrote it: the interface that controllers, simulator and
cross-check are written against.  No Pinocchio and no numbers of any robot here."""

from cutjoint.mechanism.interface import Actuator, Mechanism, kinetic_energy
from cutjoint.mechanism.types import Posture, Terms, Tool

__all__ = [
    "Actuator",
    "Mechanism",
    "Posture",
    "Terms",
    "Tool",
    "kinetic_energy",
]
