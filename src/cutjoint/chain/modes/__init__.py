"""Modes of a closed robot: all solutions of its inverse kinematics, and of its forward kinematics."""

from cutjoint.chain.modes.finding import MOST_STARTS, ModeSeeker
from cutjoint.chain.modes.result import Modes
from cutjoint.chain.modes.task import Held

__all__ = ["MOST_STARTS", "Held", "ModeSeeker", "Modes"]
