"""Joint limits on the way to a posture: which joint is beyond them, and where on the way it met them.

A joint that starts beyond its limits may come back, but not go further.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.continuation import Stopped, follow
from cutjoint.chain.closing.drivers import Driver
from cutjoint.chain.joints import type_of
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.errors import LimitError

HALVINGS = 16
"""How finely the place on the way is found at which a joint meets its limit."""


class Way(NamedTuple):
    """A straight way of a robot.

    Attributes:
        start: where it stands.
        origin, goal: places at both ends, as `driver` takes them.
        driver: leads the robot from one place to another.
    """

    start: Placed
    origin: Array
    goal: Array
    driver: Callable[[Array, Array], Driver]


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
        slack = tolerances.CLOSURE.value * np.array(
            [kinematics.reach if type_of(model, joint).slides else 1.0 for joint in self._joints]
        )
        self._least, self._most = self._lower - slack, self._upper + slack

    def beyond(self, start: Array, q: Array) -> int | None:
        """Number of the joint that is furthest beyond its limits at `q` (nq,), having started at `start`; or None."""
        index = self._index
        if not index.size:
            return None
        at = q[index]
        if (at >= self._least).all() and (at <= self._most).all():
            return None
        began = start[index]
        over = np.maximum(np.minimum(self._least, began) - at, at - np.maximum(self._most, began))
        worst = int(over.argmax())
        return worst if over[worst] > 0.0 else None

    def error(self, number: int, way: Way, what: str, target: Array | None = None) -> LimitError:
        """What to raise for a joint beyond its limits at the end of a way.

        Args:
            number: of the joint, as `beyond` gives it.
            way: that was gone.
            what: the robot cannot do.
            target: of the tool, where there is one.
        """
        k, name = self._k, self._k.model.names[self._joints[number]]
        unit = "m" if type_of(k.model, self._joints[number]).slides else "rad"
        lower, upper = float(self._lower[number]), float(self._upper[number])
        low, high, value = 0.0, 1.0, float("nan")
        for fraction in [1.0, *[0.0] * HALVINGS]:
            middle = fraction or 0.5 * (low + high)
            found = follow(k, way.start, way.driver(way.origin, way.origin + middle * (way.goal - way.origin)))
            inside = not isinstance(found, Stopped) and self.beyond(way.start.q, found.q) is None
            if fraction and not isinstance(found, Stopped):
                value = float(found.q[self._index[number]])
            low, high = (middle, high) if inside else (low, middle)
        side = "lower" if value < lower else "upper"
        return LimitError(
            f"{k.name} cannot {what} within its joint limits: '{name}' would be at {value:.6g} {unit}, its limits are "
            f"{lower:.6g} to {upper:.6g} {unit}, and it meets the {side} one after {low:.1%} of the way; choose a "
            'nearer target, or ignore them (limits="ignore")',
            joint=name,
            value=value,
            bounds=(lower, upper),
            target=way.goal if target is None else target,
            progress=low,
        )
