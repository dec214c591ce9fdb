"""Retiming: the quickest motion along a path, or from point to point, within limits of speed, acceleration, jerk,
effort and power."""

from cutjoint.retiming.answer import Retimed
from cutjoint.retiming.finding import retime
from cutjoint.retiming.limit_peaks import LimitPeak
from cutjoint.retiming.limits import MotionLimits, limits_of
from cutjoint.retiming.moved import Moved
from cutjoint.retiming.moves import quickest_moves

__all__ = ["LimitPeak", "MotionLimits", "Moved", "Retimed", "limits_of", "quickest_moves", "retime"]
