"""Closed chains in Pinocchio: the tree's model, the cut joints as constraints, and all that follows from them."""

from cutjoint.chain.actuation import ActuatorEfforts
from cutjoint.chain.closed_chain import ClosedChain
from cutjoint.chain.dynamics import FullMotion
from cutjoint.chain.mobility_report import MobilityReport
from cutjoint.chain.modes import Modes
from cutjoint.chain.reactions import GearForce, Reaction, Reactions, Stiffness

__all__ = [
    "ActuatorEfforts",
    "ClosedChain",
    "FullMotion",
    "GearForce",
    "MobilityReport",
    "Modes",
    "Reaction",
    "Reactions",
    "Stiffness",
]
