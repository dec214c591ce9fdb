"""Short ways at regular postures, without a singular value decomposition.

To the rows that give the quick tangent map come as many of what drives the robot as there are actuators.  The system
is then square, and one LU gives a step of Newton's method.  Where its pivots or the change of its determinant show that
the way is not plainly on one branch, the answer is None, and the caller walks (`cutjoint.chain.closing.continuation`).
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.drivers import Driver
from cutjoint.chain.closing.equations import SMALL, Equations, System
from cutjoint.chain.closing.newton import newton
from cutjoint.chain.factoring import LU, pivots_of
from cutjoint.chain.kinematics import Placed
from cutjoint.chain.tangent import QuickTangents, are_trusted

LARGEST_CHANGE = 2.0
"""Largest change of the determinant, up or down, over a way: a singular posture within it would change more."""

STEPS = 6


def short_way(quick: QuickTangents, start: Placed, driver: Driver) -> Placed | None:
    """The closed configuration next to a closed one that meets the driver at the end of its way."""
    system = System(quick.kinematics, driver)
    extra = _rows_of(quick, system, driver)
    if extra is None:
        return None
    here = system.at(start)
    if here.is_closed(motion=0.0) and not here.driven.any():
        return start
    steps = _ChosenSteps(np.concatenate([quick.rows, quick.kinematics.closure.rows + extra]))
    return newton(here, steps, most=STEPS) or steps.best


def _rows_of(quick: QuickTangents, system: System, driver: Driver) -> npt.NDArray[np.intp] | None:
    """As many independent rows of a driver as there are actuators, or None where it has not as many."""
    wanted, regular = quick.n, quick.regular
    if len(driver.is_length) <= wanted:
        return np.arange(wanted) if len(driver.is_length) == wanted else None
    tangent = quick.at(regular)
    if tangent is None:
        return None
    driven = system.scales.driven * driver.jacobian(regular) / system.k.column_scale
    order = pivots_of((driven @ tangent.map).T)
    return np.sort(order[:wanted])


class _ChosenSteps:
    """Steps of chosen rows, given up where they grow or the determinant changes much; `best` is closed, if not well."""

    def __init__(self, rows: npt.NDArray[np.intp]) -> None:
        self._rows, self._size, self._start = rows, inf, 0.0
        self._factors: LU | None = None
        self.best: Placed | None = None

    def next(self, here: Equations) -> Array | None:
        error = here.error.take(self._rows)
        if self._factors is None or self._size > SMALL:
            self._factors = LU(here.matrix.take(self._rows, 0))
            determinant = self._factors.determinant
            self._start = self._start or determinant
            within = determinant / self._start if self._start else 0.0
            trusted = are_trusted(self._factors.pivots) and 1.0 / LARGEST_CHANGE < within < LARGEST_CHANGE
            if not trusted:
                self.best = None
                return None
        # so near the end the last factors are as good as new ones
        solved = self._factors.solve(error)
        last, self._size = self._size, sqrt(solved.dot(solved))
        return None if self._size > min(tolerances.STRIDE.value, 0.3 * last) else -solved

    def done(self, here: Equations) -> bool:
        """After a small step only: what a large one does to the determinant is to be seen at its end."""
        self.best = here.placed if here.openness < 1.0 else None
        return self._size < SMALL and here.is_closed(motion=self._size)
