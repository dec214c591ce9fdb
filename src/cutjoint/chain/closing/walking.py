"""Ways to a target that keep to one branch: along a line, by a detour, or along what the tool can reach at all.

A tool that can move in space is led along the straight line to its target.  A tool that can only move on a curve or a
surface (one or two actuators, as a rule) leaves it on the straight way; it is led along the curve or over the surface.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.assembling import assemble
from cutjoint.chain.closing.continuation import UNBOUND, Stopped, follow
from cutjoint.chain.closing.drivers import Driver, ToolDriver
from cutjoint.chain.closing.equations import System
from cutjoint.chain.closing.newton import settled
from cutjoint.chain.kinematics import Placed
from cutjoint.chain.mobility import Mobility
from cutjoint.chain.rank import Split, rank_of

FURTHEST_DETOUR = 2.0 * np.pi
"""Ways longer than this (in radians or link lengths) are walked straight or not at all."""

CURVE_STEP = 0.2
"""How finely a robot with one actuator is searched along its curve, in radians or link lengths."""

SURFACE_STEPS = 100
COMPASS = np.array([[x, y] for x in (1.0, 0.0, -1.0) for y in (1.0, 0.0, -1.0) if x or y])
FEET = 12
"""From how many of the configurations next to a target on a surface it is tried."""
ALONG = 0.7
"""Part of the way to a target that goes along a surface, below which the surface is taken to bend away from it."""


class Walker:
    """Walks of one robot."""

    def __init__(self, mobility: Mobility) -> None:
        self._mobility, self._k, self._actuated = mobility, mobility.postures.k, mobility.postures.actuated
        # what makes steps of the actuators dimensionless, shape (n,)
        self._scale = np.where(self._actuated.lengths, self._k.length, 1.0)

    def walk(
        self,
        start: Placed,
        origin: Array,
        target: Array,
        driver: Callable[[Array, Array], Driver],
        lengths: npt.NDArray[np.bool_] | None = None,
    ) -> Placed | Stopped:
        """Follow the straight line from `origin` to `target`, or where it leaves the workspace, a detour of two lines.

        A detour is tried only where the robot can be closed at the target at all, and only for short ways.

        Args:
            lengths: which coordinates of the line are lengths; default all.
        """
        line = driver(origin, target)
        free = self._free(start, line)
        straight = follow(self._k, start, line, free)
        if not isinstance(straight, Stopped) or straight.far or (straight.fraction == 0.0 and straight.singular):
            return straight
        if assemble(self._k, straight.placed.q, driver(target, target)) is None:
            return replace(straight, why=UNBOUND, singular=False) if straight.singular else straight
        length = self._k.length
        scale = length if lengths is None else np.where(lengths, length, 1.0)
        if np.abs((target - origin) / scale).max(initial=0.0) > FURTHEST_DETOUR:
            return straight
        for corner in _detours(origin, target, length):
            there = follow(self._k, start, driver(origin, corner), free)
            if isinstance(there, Stopped):
                continue
            found = follow(self._k, there, driver(corner, target), free)
            if not isinstance(found, Stopped):
                return found
        return straight

    def along_curve(self, start: Placed, driver: ToolDriver) -> Placed | None:
        """Configuration of a robot with one actuator that meets the driver, within half a turn either way."""
        for nearest in self._nearest(self._passed(start, np.array([[1.0], [-1.0]])), driver)[:3]:
            found = assemble(self._k, nearest.q, driver)
            if found is None and self._k.rounded:
                # the target lies beside the curve by its own rounding, and the loops must not give way to it
                found = self._downhill(nearest, driver)
            if found is not None and np.abs(self._k.tree.difference(nearest.q, found.q)).max() < 2.0 * CURVE_STEP:
                return found
        return None

    def over_surface(self, start: Placed, driver: ToolDriver) -> Placed | None:
        """Configuration of a robot whose tool is on a surface that meets the driver, and is not beyond a fold of it.

        The actuators go downhill on the distance to it, from where they are, else from where they come in one of eight
        directions within half a turn.
        """
        found = self._downhill(start, driver)
        if found is not None or self._actuated.n != 2:
            return found
        for nearest in self._nearest(self._passed(start, COMPASS), driver)[:FEET]:
            found = self._downhill(nearest, driver)
            if found is not None:
                return found
        return None

    def _passed(self, start: Placed, directions: Array) -> list[Placed]:
        """Configurations that the actuators pass in some directions, shape (k, n), as far as half a turn each."""
        passed = [start]
        for direction in directions:
            here = start
            for _ in range(int(np.pi / CURVE_STEP) + 1):
                there = self._step(here, CURVE_STEP * direction * self._scale)
                if isinstance(there, Stopped) or self._folds(here, there):
                    break
                passed.append(there)
                here = there
        return passed

    def _nearest(self, passed: list[Placed], driver: ToolDriver) -> list[Placed]:
        return sorted(passed, key=lambda placed: float(np.linalg.norm(driver.error(placed, 1.0))))

    def _downhill(self, start: Placed, driver: ToolDriver) -> Placed | None:
        placed, last, system = start, np.inf, System(self._k, driver)
        for _ in range(SURFACE_STEPS):
            here = system.at(placed)
            if here.openness <= 1.0:
                return settled(here, tolerances.STRIDE.value) or placed
            miss = float(np.linalg.norm(here.error))
            if miss > 0.999 * last:
                return None
            last = miss
            slope = self._slope(placed)
            step = -Split.of(slope).solve(here.driven)
            longest = tolerances.STRIDE.value / float(np.abs(step).max(initial=1e-300))
            # where the surface bends away, far from the target, how far off it is says nothing about how far to go
            bends = float(np.linalg.norm(slope @ step)) < ALONG * miss
            step *= longest if bends else min(1.0, longest)
            for _ in range(8):
                found = self._step(placed, self._scale * step)
                if not isinstance(found, Stopped) and not self._folds(placed, found):
                    there = system.at(found)
                    if float(np.linalg.norm(there.error)) < miss or there.openness <= 1.0:
                        placed = found
                        break
                step *= 0.5
            else:
                return None
        return None

    def _slope(self, placed: Placed) -> Array:
        """Motion of the tool point by the actuators, dimensionless, shape (3, n)."""
        return np.asarray(placed.tool_jacobian[:3] @ self._mobility.tangent(placed).map * self._scale / self._k.length)

    def _folds(self, here: Placed, there: Placed) -> bool:
        """Whether a surface turns its other side up within a step: the tool could not move in some direction there."""
        if self._actuated.n != 2:
            return False
        before, after = (np.cross(*self._slope(placed).T) for placed in (here, there))
        return bool(before @ after <= 0.0)

    def _step(self, start: Placed, step: Array) -> Placed | Stopped:
        now = self._actuated.of(start.q)
        driver = self._actuated.lead(now, now + step)
        return follow(self._k, start, driver, self._free(start, driver))

    def _free(self, start: Placed, driver: Driver) -> int:
        """Motions that closure and driver leave free as a rule."""
        system = System(self._k, driver)

        def free(placed: Placed) -> int:
            matrix = system.at(placed, 0.0).matrix
            return int(matrix.shape[1]) - rank_of(matrix)

        return free(start) and min(map(free, self._mobility.regular))


def _detours(origin: Array, target: Array, length: float) -> Iterator[Array]:
    """Points beside the middle of a line, by half and by the whole of its length, in all directions across it."""
    line = target - origin
    size = max(float(np.linalg.norm(line)), 0.5 * length)
    across = np.linalg.svd(line[None, :])[2][1:]
    for reach in (0.5, 1.0):
        for direction in across:
            for sign in (1.0, -1.0):
                yield 0.5 * (origin + target) + sign * reach * size * direction
