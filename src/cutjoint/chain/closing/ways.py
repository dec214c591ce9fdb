"""What closing by the actuators and by the tool have in common: where a way starts, short ways, and what ends one."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.build import rough_home
from cutjoint.chain.closing.assembling import assembled
from cutjoint.chain.closing.continuation import Stopped
from cutjoint.chain.closing.drivers import Driver
from cutjoint.chain.closing.joint_limits import LimitCheck
from cutjoint.chain.closing.short_steps import short_way
from cutjoint.chain.closing.walking import Walker
from cutjoint.chain.kinematics import Placed
from cutjoint.chain.mobility import Mobility
from cutjoint.errors import LimitError, SingularError
from cutjoint.mechanism import Posture

Near = Posture | str | None


class Way(NamedTuple):
    """A straight way of a robot.

    Attributes:
        start: where it stands.
        origin, goal: places at both ends, as `driver` takes them.
        driver: leads the robot from one place to another.
        lengths: which coordinates of a place are lengths; default all.
    """

    start: Placed
    origin: Array
    goal: Array
    driver: Callable[[Array, Array], Driver]
    lengths: npt.NDArray[np.bool_] | None = None


class Ways:
    """Ways of one robot from one closed configuration to another.

    Attributes:
        walker: walks them.
        limits: of the joints.
    """

    def __init__(self, mobility: Mobility) -> None:
        self._mobility, self._postures, self.walker = mobility, mobility.postures, Walker(mobility)
        self._k, self._actuated, self.limits = (
            mobility.postures.k,
            mobility.postures.actuated,
            LimitCheck(self._postures.k),
        )
        self._homes: dict[str, Placed] = {}

    def start(self, near: Near) -> Placed:
        """The configuration of a posture, or of a home by its name; default home.

        Raises:
            UnknownNameError, ClosureError: no such home, or it cannot be closed.
        """
        if not isinstance(near, str):
            return self._postures.placed(near)
        if near not in self._homes:
            k, own = self._k, self._actuated
            rough, keep = rough_home(k.model, k.description, near)
            start = k.tree.normalised(rough)
            self._homes[near] = assembled(k, start, own.hold(start) if keep else None)
        return self._homes[near]

    def short(self, start: Placed, driver: Driver) -> Placed | None:
        """A short way in one go, where that is plainly on the same branch."""
        quick = self._mobility.quick
        return short_way(quick, start, driver) if quick is not None else None

    def beyond_limits(self, way: Way, found: Placed, what: str, target: Array) -> LimitError:
        """What to raise for a joint that is beyond its limits at the end of a way."""

        def go(fraction: float) -> Placed | None:
            goal = way.origin + fraction * (way.goal - way.origin)
            there = self.walker.walk(way.start, way.origin, goal, way.driver, way.lengths)
            return None if isinstance(there, Stopped) else there

        return self.limits.error(way.start, found, go, what, target)

    def crossing(self, what: str, stopped: Stopped, kind: str) -> SingularError:
        return SingularError(
            f"{self._k.name} cannot {what} without leaving its branch: {stopped.fraction:.1%} of the way, at "
            f"{self._actuated.show(self._actuated.of(stopped.placed.q))}, {stopped.why} (distance to a {kind} "
            f"singularity {stopped.measure:.2g}); start from a posture beyond it",
            kind=kind,
            measure=stopped.measure,
            limit=tolerances.SINGULAR.value,
        )
