"""Modes of a closed robot: all solutions of its inverse kinematics, and of its forward kinematics."""

from cutjoint.chain.modes.finding import MOST_STARTS, Held, Modes, ModeSeeker

__all__ = ["MOST_STARTS", "Held", "ModeSeeker", "Modes"]
