"""Newton's method on closure and driver, and the equations at one configuration by their singular values.

One loop serves both ways to make a step: the least one that meets all rows with the rank cut off (`LeastSteps`, here),
and that of chosen rows by an LU factorisation (`cutjoint.chain.closing.short_steps`).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite
from typing import Protocol

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.drivers import Driver
from cutjoint.chain.closing.equations import Equations, System
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.rank import threshold

MOST = 12
"""Steps at most."""


class Steps(Protocol):
    """A way to make steps; one for each use."""

    def next(self, here: Equations) -> Array | None:
        """Dimensionless motion (nv,) that removes the error to first order; None where it cannot be trusted."""
        ...

    def done(self, here: Equations) -> bool:
        """Whether a step led to a closed configuration."""
        ...


def newton(here: Equations, steps: Steps, fraction: float = 1.0, most: int = MOST) -> Placed | None:
    """The configuration near by that meets the equations at a fraction of the driver's way, after one step at least (so
    that what is prescribed itself is met exactly); None where none is found."""
    system, k = here.system, here.system.k
    for _ in range(most):
        motion = steps.next(here)
        if motion is None:
            return None
        q = k.after(here.placed.q, motion)
        if system.driver is not None:
            system.driver.put(q, fraction)
        here = system.at(k.at(q), fraction)
        if steps.done(here):
            return here.placed
    return None


class LeastSteps:
    """Least steps for all rows, given up where they do not converge or lead further than `reach` (scaled)."""

    def __init__(self, reach: float) -> None:
        self._left, self._last = reach, inf

    def next(self, here: Equations) -> Array | None:
        worst = here.openness
        if not isfinite(worst) or (worst > 0.5 * self._last and worst > 1.0):
            return None
        self._last = worst
        motion = Linearised.of(here.matrix).solve(here.error)
        self._left -= float(np.abs(motion).max(initial=0.0))
        return motion if self._left >= 0.0 else None

    def done(self, here: Equations) -> bool:
        return here.is_closed(last=self._last)


def settled(here: Equations, reach: float, fraction: float = 1.0) -> Placed | None:
    """The closed configuration at or next to one, or None where Newton's method does not find one within `reach`
    (radians or characteristic lengths)."""
    return here.placed if here.is_closed() else newton(here, LeastSteps(reach), fraction)


def settle(
    kinematics: Kinematics, q: Array, driver: Driver | None, reach: float = tolerances.STRIDE.value
) -> Placed | None:
    """As `settled`, from a configuration (nq,)."""
    return settled(System(kinematics, driver).at(kinematics.at(q)), reach)


@dataclass(frozen=True, eq=False)
class Linearised:
    """Dimensionless equations at one configuration by their singular values: left (m, k), values (k,), right (k, nv).

    Attributes:
        free: motions that the equations leave free at nearly every posture.
    """

    left: Array
    values: Array
    right: Array
    free: int = 0

    @staticmethod
    def of(matrix: Array, free: int = 0) -> Linearised:
        return Linearised(*np.linalg.svd(matrix, full_matrices=False), free)

    def solve(self, error: Array) -> Array:
        """Minimum-norm step that removes the error to first order, shape (nv,)."""
        kept = self.values > threshold(self.values)
        return np.asarray(-self.right[kept].T @ ((self.left[:, kept].T @ error) / self.values[kept]))

    @property
    def count(self) -> int:
        """Rank where the equations leave no motions but the usual ones free."""
        return int(self.right.shape[1]) - self.free

    @property
    def least(self) -> float:
        """The singular value that vanishes at a singular posture; infinite where there are no equations."""
        if self.count == 0:
            return float("inf")
        return float(self.values[self.count - 1]) if len(self.values) >= self.count else 0.0

    @property
    def regular(self) -> bool:
        """Whether the equations leave no more motions free than usual."""
        return self.least > threshold(self.values)

    def flips(self, other: Linearised) -> bool:
        """Whether the determinants here and at `other`, a step further on, differ in sign."""
        r = self.count
        turned = other.right[:r] @ self.right[:r].T
        between = (self.left[:, :r].T @ other.left[:, :r]) @ (other.values[:r, None] * turned)
        return bool(np.linalg.det(between / self.values[:r, None]) <= 0.0)
