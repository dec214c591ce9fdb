"""Retiming: the quickest motion along a path within limits of speed, acceleration, jerk, effort and power."""

from cutjoint.retiming.answer import LimitPeak, Retimed
from cutjoint.retiming.finding import retime
from cutjoint.retiming.limits import MotionLimits, limits_of

__all__ = ["LimitPeak", "MotionLimits", "Retimed", "limits_of", "retime"]
