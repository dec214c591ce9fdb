"""Tangent maps at regular postures without a singular value decomposition.

As many independent rows of the constraint Jacobian as there are passive velocities are chosen once, at a regular
posture, by a pivoted QR factorisation; one LU then gives the tangent map.  The choice is watched: where a pivot becomes
small or a row that was not chosen is not met, the answer is None, and the caller goes the way that takes all rows and
cuts off the rank.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr
from scipy.linalg.lapack import dgesv

from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Kinematics
from cutjoint.chain.placed import Placed

SMALLEST_PIVOT = 1e-3
"""Smallest to largest pivot; below it the chosen rows are not trusted."""

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


class QuickTangents:
    """Quick tangent maps of one robot whose actuators determine its motion, all of it.

    Attributes:
        kinematics: of the robot.
        n: number of actuated velocities.
        regular: a closed posture at which the actuators determine the motion.
        rows: the rows that are chosen there, as many as there are passive velocities.
    """

    def __init__(self, kinematics: Kinematics, actuated: Array, passive: Array, regular: Placed) -> None:
        self.kinematics, self.n, self.regular = kinematics, len(actuated), regular
        self._actuated, self._passive = actuated, passive
        order = qr(regular.scaled[:, passive].T, mode="r", pivoting=True)[1]
        self.rows = np.sort(order[: len(passive)])

    def at(self, placed: Placed) -> QuickTangent | None:
        """T (nv, n) at a closed configuration."""
        k, matrix = self.kinematics, placed.scaled
        actuated, passive = matrix[:, self._actuated], matrix[:, self._passive]
        chosen = passive[self.rows]
        n = self.n
        right = np.concatenate([actuated[self.rows], np.eye(len(chosen))], axis=1)
        factors, _, solved, failed = dgesv(chosen, right)
        if (
            failed
            or not are_trusted(factors.diagonal().tolist())
            or np.abs(actuated - passive @ solved[:, :n]).max(initial=0.0) > MET
        ):
            return None
        scale = k.column_scale
        tangent = np.zeros((len(scale), n))
        tangent[self._actuated, np.arange(n)] = 1.0
        tangent[self._passive] = -scale[self._passive, None] * solved[:, :n] / scale[self._actuated]
        back = -scale[self._passive, None] * solved[:, n:] * k.row_scale[self.rows]
        return QuickTangent(tangent, self.rows, back)


def are_trusted(pivots: list[float]) -> bool:
    """Whether none of the pivots of a factorisation is small beside the others."""
    sizes = list(map(abs, pivots))
    return min(sizes, default=1.0) > SMALLEST_PIVOT * max(sizes, default=0.0)
