"""Forces and moments in every joint, cut and coupling of a chain, and which of them equilibrium alone tells."""

from cutjoint.chain.reactions.finding import ReactionFinder
from cutjoint.chain.reactions.stiffness import Stiffness
from cutjoint.chain.reactions.values import GearForce, Reaction, Reactions

__all__ = ["GearForce", "Reaction", "ReactionFinder", "Reactions", "Stiffness"]
