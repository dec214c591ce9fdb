"""What the same motion asks of the limits when it is gone slower: times longer by k make speeds smaller by k,
accelerations by k^2 and jerks by k^3, so

    effort(k) = holding + (effort(1) - holding - friction(1)) / k^2 + friction(k),

friction(k) that of the joints at speeds smaller by k."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cutjoint.arrays import Array
from cutjoint.mechanism import NO_LOADS, Loads, Mechanism, Posture
from cutjoint.retiming import peaks
from cutjoint.retiming.limits import MotionLimits

POWERS = {"speed": 1, "acceleration": 2, "jerk": 3, "tool_speed": 1, "tool_acceleration": 2}


class Slowed:
    """A motion at k instants, and what it asks when it is slower.

    Args:
        robot: that moves.
        postures: then.
        v, a: velocities and accelerations then, shape (k, n).
        used: parts of the limits that it asks as it is.
        limits: of which these are parts.
        loads: that act from outside.
    """

    def __init__(
        self,
        robot: Mechanism,
        postures: Sequence[Posture],
        v: Array,
        a: Array,
        used: peaks.Used,
        limits: MotionLimits,
        loads: Loads = NO_LOADS,
    ) -> None:
        self._robot, self._postures, self._v, self._used, self._limits = robot, postures, v, used, limits
        self._holding = self._moving = np.zeros_like(v)
        if "effort" in used or "power" in used:
            still = np.zeros(robot.n)
            self._holding = np.array([robot.inverse_dynamics(one, still, still, loads) for one in postures])
            now = [robot.inverse_dynamics(*one, loads) for one in zip(postures, v, a, strict=True)]
            self._moving = np.array(now) - self._holding - self._friction(1.0)

    def by(self, longer: float) -> peaks.Used:
        """Parts of the limits where it takes longer by a factor."""
        found = {one: part / longer ** POWERS[one] for one, part in self._used.items() if one in POWERS}
        if "effort" in self._used or "power" in self._used:
            effort = self._holding + self._moving / longer**2 + self._friction(longer)
            for quantity, value in (("effort", effort), ("power", effort * self._v / longer)):
                if quantity in self._used:
                    found[quantity] = value / self._limits.of(quantity)
        return found

    def _friction(self, longer: float) -> Array:
        if not self._robot.dissipates:
            return np.zeros_like(self._v)
        rows = zip(self._postures, self._v / longer, strict=True)
        return np.array([self._robot.terms(*one).friction for one in rows])
