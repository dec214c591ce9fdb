"""Joint limits on the way to a posture: which joint is beyond them, and where on the way it met them.

A joint that starts beyond its limits may come back, but not go further.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.joints import type_of
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.errors import LimitError

HALVINGS = 16
"""How finely the place on the way is found at which a joint meets its limit."""


Go = Callable[[float], Placed | None]


class LimitCheck:
    """Finds the joints of one robot that are beyond their limits."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._k, model = kinematics, kinematics.model
        joints = [joint for joint in range(1, model.njoints) if model.nqs[joint] == 1]
        index = np.array([model.idx_qs[joint] for joint in joints], dtype=int)
        lower, upper = model.lowerPositionLimit[index], model.upperPositionLimit[index]
        bounded = np.isfinite(lower) | np.isfinite(upper)
        self._joints = [joint for joint, one in zip(joints, bounded.tolist(), strict=True) if one]
        self._index, self._lower, self._upper = index[bounded], lower[bounded], upper[bounded]
        slack = self._slack = tolerances.CLOSURE.value * np.array(
            [kinematics.reach if type_of(model, joint).slides else 1.0 for joint in self._joints]
        )
        self._least, self._most = self._lower - slack, self._upper + slack

    def _beyond(self, start: Array, q: Array) -> int | None:
        """Number of the joint that is furthest beyond its limits at `q` (nq,), having started at `start`; or None."""
        index = self._index
        if not index.size:
            return None
        at = q[index]
        if (at >= self._least).all() and (at <= self._most).all():
            return None
        began = start[index]
        over = np.maximum(
            np.minimum(self._least, began - self._slack) - at, at - np.maximum(self._most, began + self._slack)
        )
        worst = int(over.argmax())
        return worst if over[worst] > 0.0 else None

    def exceeded(self, start: Array, q: Array) -> bool:
        """Whether a joint is beyond its limits at `q` (nq,), further than at `start`."""
        return self._beyond(start, q) is not None

    def error(self, start: Placed, found: Placed, go: Go, what: str, target: Array) -> LimitError:
        """What to raise for the joint that is furthest beyond its limits at the end of a way.

        Args:
            start, found: both ends of the way.
            go: goes a fraction of the way.
            what: the robot cannot do.
            target: what was asked for.
        """
        number = self._beyond(start.q, found.q)
        assert number is not None
        k, name, index = self._k, self._k.model.names[self._joints[number]], self._index[number]
        unit = "m" if type_of(k.model, self._joints[number]).slides else "rad"
        lower, upper = float(self._lower[number]), float(self._upper[number])
        value, began = float(found.q[index]), float(start.q[index])
        side, bound = ("lower", lower) if value < lower else ("upper", upper)
        low, high = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            there = go(middle)
            if there is None:  # it came there by a detour, of which the joint tells the part
                low = min(max((bound - began) / (value - began), 0.0), 1.0)
                break
            low, high = (middle, high) if self._beyond(start.q, there.q) is None else (low, middle)
        return LimitError(
            f"{k.name} cannot {what} within its joint limits: '{name}' would be at {value:.6g} {unit}, its limits are "
            f"{lower:.6g} to {upper:.6g} {unit}, and it meets the {side} one after {low:.1%} of the way; choose a "
            'nearer target, or ignore them (limits="ignore")',
            joint=name,
            value=value,
            bounds=(lower, upper),
            target=target,
            progress=low,
        )
