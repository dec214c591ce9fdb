"""Tangent map and short closing steps at regular postures, without a singular value decomposition.

As many independent rows of Pinocchio's constraint Jacobian as there are passive velocities are chosen once, at home, by
a pivoted QR factorisation.  There the passive block is square, and one LU gives the tangent map or a Newton step.  The
choice is watched: where a pivot becomes small or a row that was not chosen is not met, the answer is None, and the
caller goes the way that takes all rows and cuts off the rank.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import qr
from scipy.linalg.lapack import dgesv

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Kinematics
from cutjoint.chain.rigid import RigidConstraints

SMALLEST_PIVOT = 1e-3
"""Smallest to largest pivot; below it the chosen rows are not trusted."""

LARGEST_CHANGE = 2.0
"""Largest change of the determinant, up or down, over a step: a singular posture within it would change more."""

NEWTON_STEPS = 5


class Nearby:
    """Quick answers for one robot whose actuators determine its motion and whose cuts Pinocchio has models for."""

    def __init__(
        self, kinematics: Kinematics, rigid: RigidConstraints, actuated: Array, passive: Array, home: Array
    ) -> None:
        self._k, self._rigid = kinematics, rigid
        self._actuated, self._passive = actuated, passive
        self._row_scale = np.where(rigid.is_length, 1.0 / kinematics.length, 1.0)
        self._scale = self._row_scale[:, None] * kinematics.column_scale
        self._back = -kinematics.column_scale[passive, None] / kinematics.column_scale[actuated]
        rigid.update(home)
        order = qr((rigid.jacobian() * self._scale)[:, passive].T, mode="r", pivoting=True)[1]
        self._rows = np.sort(order[: len(passive)])
        self._chosen_scale = self._scale[self._rows]

    def tangent(self, q: Array) -> Array | None:
        """T (nv, n) at the closed configuration `q` (nq,)."""
        self._rigid.update(q)
        matrix = self._rigid.jacobian() * self._scale
        actuated, passive = matrix[:, self._actuated], matrix[:, self._passive]
        factors, _, solved, failed = dgesv(passive[self._rows], actuated[self._rows])
        if failed or not _trusted(factors) or np.abs(actuated - passive @ solved).max() > 1e-9:
            return None
        tangent = np.zeros((len(self._k.column_scale), len(self._actuated)))
        tangent[self._actuated, np.arange(len(self._actuated))] = 1.0
        tangent[self._passive] = self._back * solved
        return tangent

    def drift(self, q: Array, v_full: Array, tangent: Array) -> Array:
        """d (nv,) with a_full = T a + d at a closed configuration.

        Every acceleration that the cuts allow has this form, so one call of `pin.constraintDynamics` tells it.
        """
        allowed = self._rigid.acceleration(q, v_full, np.zeros(len(v_full)))
        return np.asarray(allowed - tangent @ allowed[self._actuated])

    def close(self, q: Array, move: Array) -> Array | None:
        """The closed configuration (nq,) next to the closed `q` after the actuators moved by `move` (n,)."""
        motion = np.zeros(len(self._k.column_scale))
        motion[self._actuated] = move
        wanted = move / self._k.column_scale[self._actuated]
        if np.abs(wanted).max() > tolerances.STRIDE.value:
            return None
        last, start = np.inf, 0.0
        for step in range(NEWTON_STEPS):
            self._rigid.update(q)
            residual = self._row_scale * self._rigid.residual()
            matrix = self._rigid.jacobian()[self._rows] * self._chosen_scale
            if step and np.abs(residual).max() < 1e-2 * tolerances.CLOSURE.value:
                change = np.linalg.det(matrix[:, self._passive]) / start
                return q if 1.0 / LARGEST_CHANGE < change < LARGEST_CHANGE else None
            right = residual[self._rows]
            if step == 0:
                start = np.linalg.det(matrix[:, self._passive])
                right = right + matrix[:, self._actuated] @ wanted
            factors, _, solved, failed = dgesv(matrix[:, self._passive], right)
            size = float(np.abs(solved).max())
            if failed or not _trusted(factors) or size > min(tolerances.STRIDE.value, 0.3 * last):
                return None
            last = size
            motion[self._passive] = -self._k.column_scale[self._passive] * solved
            q = self._k.integrate(q, motion)
            motion[self._actuated] = 0.0
        return None


def _trusted(factors: Array) -> bool:
    pivots = np.abs(np.diagonal(factors))
    return bool(pivots.min() > SMALLEST_PIVOT * pivots.max())
