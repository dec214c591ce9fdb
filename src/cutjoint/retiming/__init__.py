"""Retiming: the quickest motion along a path within limits of speed, acceleration, jerk, effort and power."""

from cutjoint.retiming.answer import LimitPeak, Retimed
from cutjoint.retiming.limits import MotionLimits, limits_of
from cutjoint.retiming.retime import retime

__all__ = ["LimitPeak", "MotionLimits", "Retimed", "limits_of", "retime"]
