"""Tangent map and short closing steps at regular postures, without a singular value decomposition.

As many independent rows of the constraint Jacobian as there are passive velocities are chosen once, at a regular
posture, by a pivoted QR factorisation; what drives the robot adds as many rows as there are actuators.  The system is
then square, and one LU gives the tangent map or a Newton step.  The choice is watched: where a pivot becomes small or a
row that was not chosen is not met, the answer is None, and the caller goes the way that takes all rows and cuts off the
rank.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count
from math import prod, sqrt
from operator import ne

import numpy as np
import numpy.typing as npt
from scipy.linalg import qr
from scipy.linalg.lapack import dgesv, dgetrs

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.continuation import Driver, System
from cutjoint.chain.kinematics import Kinematics, Placed

SMALLEST_PIVOT = 1e-3
"""Smallest to largest pivot; below it the chosen rows are not trusted."""

LARGEST_CHANGE = 2.0
"""Largest change of the determinant, up or down, over a step: a singular posture within it would change more."""

NEWTON_STEPS = 6
SMALL = 1e-4
"""Steps smaller than this (in radians or characteristic lengths) change the determinant too little to look at."""
MET = 1e-9
"""What the rows that were not chosen may leave of a velocity."""


@dataclass(frozen=True, eq=False)
class QuickTangent:
    """Tangent map at one posture, and what makes drifts quick there.

    Attributes:
        map: T, shape (nv, n).
        rows: chosen rows.
        back: passive accelerations from the drift of the chosen rows, shape (passive, passive).
    """

    map: Array
    rows: Array
    back: Array


class Nearby:
    """Quick answers for one robot whose actuators determine its motion, all of it.

    Args:
        regular: a closed posture at which the actuators determine the motion.
    """

    def __init__(self, kinematics: Kinematics, actuated: Array, passive: Array, regular: Placed) -> None:
        self._k = kinematics
        self._actuated, self._passive = actuated, passive
        self._regular = regular
        order = qr(regular.scaled[:, passive].T, mode="r", pivoting=True)[1]
        self._rows = np.sort(order[: len(passive)])

    def tangent(self, placed: Placed) -> QuickTangent | None:
        """T (nv, n) at a closed configuration."""
        k, matrix = self._k, placed.scaled
        actuated, passive = matrix[:, self._actuated], matrix[:, self._passive]
        chosen = passive[self._rows]
        n = len(self._actuated)
        right = np.concatenate([actuated[self._rows], np.eye(len(chosen))], axis=1)
        factors, _, solved, failed = dgesv(chosen, right)
        if (
            failed
            or not _trusted(factors.diagonal().tolist())
            or np.abs(actuated - passive @ solved[:, :n]).max(initial=0.0) > MET
        ):
            return None
        scale = k.column_scale
        tangent = np.zeros((len(scale), n))
        tangent[self._actuated, np.arange(n)] = 1.0
        tangent[self._passive] = -scale[self._passive, None] * solved[:, :n] / scale[self._actuated]
        back = -scale[self._passive, None] * solved[:, n:] * k.row_scale[self._rows]
        return QuickTangent(tangent, self._rows, back)

    def follow(self, placed: Placed, driver: Driver) -> Placed | None:
        """The closed configuration next to the closed one `placed` that meets the driver at the end of its way."""
        k, system = self._k, System(self._k, driver)
        extra = self._rows_of(system)
        if extra is None:
            return None
        rows = np.concatenate([self._rows, k.closure.rows + extra])
        here = system.at(placed)
        last, start, factors, pivots = np.inf, 0.0, None, None
        for step in range(NEWTON_STEPS):
            if here.openness < 1e-2 and (last < SMALL if step else not here.error[k.closure.rows :].any()):
                return here.placed
            if factors is None or last > SMALL:
                factors, pivots, solved, failed = dgesv(here.matrix.take(rows, 0), here.error.take(rows))
                diagonal = factors.diagonal().tolist()
                if failed or not _trusted(diagonal):
                    return None
                determinant = _determinant(diagonal, pivots)
                start = determinant if step == 0 else start
                if not 1.0 / LARGEST_CHANGE < determinant / start < LARGEST_CHANGE:
                    return None
            else:  # so near the end the last factors are as good as new ones
                solved, failed = dgetrs(factors, pivots, here.error.take(rows))
            size = sqrt(solved.dot(solved))
            if size > min(tolerances.STRIDE.value, 0.3 * last):
                return here.placed if here.openness < 1.0 else None
            last = size
            q = k.integrate(here.placed.q, -k.column_scale * solved)
            driver.put(q, 1.0)
            here = system.at(k.at(q))
        return here.placed if here.openness < 1.0 else None

    def _rows_of(self, system: System) -> npt.NDArray[np.intp] | None:
        """As many independent rows of a driver as there are actuators, or None where it has not as many."""
        driver, wanted = system.driver, len(self._actuated)
        assert driver is not None
        if len(driver.is_length) <= wanted:
            return np.arange(wanted) if len(driver.is_length) == wanted else None
        tangent = self.tangent(self._regular)
        if tangent is None:
            return None
        driven = system.scales.driven * driver.jacobian(self._regular) / self._k.column_scale
        order = qr((driven @ tangent.map).T, mode="r", pivoting=True)[1]
        return np.sort(order[:wanted])


def _trusted(diagonal: list[float]) -> bool:
    pivots = list(map(abs, diagonal))
    return min(pivots, default=1.0) > SMALLEST_PIVOT * max(pivots, default=0.0)


def _determinant(diagonal: list[float], pivots: Array) -> float:
    product: float = prod(diagonal)
    return -product if sum(map(ne, pivots.tolist(), count())) % 2 else product
