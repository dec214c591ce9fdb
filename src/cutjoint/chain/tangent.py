"""The tangent map of a closed chain: velocities of all joints from those of the actuators.

With the constraint Jacobian split into actuated and passive columns, K_a v + K_p v_p = 0 gives v_p = -K_p^+ K_a v.  The
smallest singular value of K_p (dimensionless) is the distance to a type-2 singularity; the pseudo-inverse keeps as many
singular values as there are passive velocities less the idle motions, so redundant rows do no harm.

Idle motions U are those that no actuator drives and that do not move the tool.  They are carried: with M the mass
matrix of the tree, the map that gives them no momentum is

    T = T_0 - U (U' M U)^+ U' M T_0

At regular postures no singular value decomposition is needed: as many independent rows as there are passive velocities
are chosen once, by a pivoted QR factorisation, and one LU gives the map (`QuickTangents`).  The choice is watched:
where a pivot becomes small or a row that was not chosen is not met, the answer is None, and all rows are taken.

After Routh's elimination of cyclic coordinates; E. J. Routh, Stability of Motion, 1877.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, readonly
from cutjoint.chain.dynamics import Motions
from cutjoint.chain.factoring import LU, pivots_of
from cutjoint.chain.kinematics import Kinematics, Placed

_LOOSE = 1e-6
"""Rows that the passive joints cannot meet by more than this tie the actuators to each other."""

SMALLEST_PIVOT = 1e-3
"""Smallest to largest pivot; below it the chosen rows are not trusted."""

MET = 1e-9
"""What the rows that were not chosen may leave of a velocity."""


@dataclass(frozen=True, eq=False)
class TangentMap:
    """Tangent map at one configuration.

    Attributes:
        map: T with v_full = T @ v, shape (nv, n).
        inverse: K_p^+, shape (passive, rows): d_passive = -inverse @ drift of the rows.
        type2: distance to a type-2 singularity, dimensionless; infinite where no joint is passive.
        consistent: whether the actuators do not depend on each other.
        idle: basis of the idle motions, shape (nv, k), [m] or [rad], made orthonormal by the mass matrix; those that
            move no mass are not in it.
    """

    map: Array
    inverse: Array
    type2: float
    consistent: bool
    idle: Array


def tangent_map(kinematics: Kinematics, actuated: Array, passive: Array, placed: Placed, idle: int) -> TangentMap:
    """The tangent map for the actuated and passive velocity indices, (n,) and (nv - n,).

    It means something only where the actuators determine the motion; at a type-2 singularity its entries are huge.

    Args:
        idle: number of idle motions of the robot.
    """
    k = kinematics
    nv, count = k.model.nv, len(passive)
    selection = np.zeros((nv, len(actuated)))
    selection[actuated, np.arange(len(actuated))] = 1.0
    none = np.zeros((nv, 0))
    matrix = placed.scaled
    if count == 0:
        meets = bool(np.abs(matrix).max(initial=0.0) < _LOOSE)
        return TangentMap(selection, np.zeros((0, k.closure.rows)), float("inf"), meets, none)
    left, values, right = np.linalg.svd(matrix[:, passive])
    kept = count - idle
    if len(values) < kept:
        return TangentMap(selection, np.zeros((count, k.closure.rows)), 0.0, True, none)
    type2 = float(values[kept - 1]) if kept else float("inf")
    scaled = right[:kept].T @ (left[:, :kept].T / np.maximum(values[:kept], 1e-300)[:, None])
    columns = matrix[:, actuated]
    solved = scaled @ columns
    unmet = np.abs(columns - matrix[:, passive] @ solved).max(initial=0.0)
    scale = k.column_scale
    inverse = scale[passive, None] * scaled * k.row_scale
    selection[passive] = -scale[passive, None] * solved / scale[actuated]
    if not idle:
        return TangentMap(selection, inverse, type2, bool(unmet < _LOOSE), none)
    spins = np.zeros((nv, idle))
    spins[passive] = right[kept:].T
    mass = scale[:, None] * k.tree.mass_matrix(placed.q) * scale
    motions = Motions.of(spins, mass)
    moved = scale[:, None] * (motions.basis @ motions.factor)
    carried = selection - moved @ (moved.T @ (k.tree.mass_matrix(placed.q) @ selection))
    return TangentMap(carried, inverse, type2, bool(unmet < _LOOSE), readonly(moved))


@dataclass(frozen=True, eq=False)
class QuickTangent:
    """Tangent map at one posture, and what makes drifts quick there.

    Attributes:
        map: T, shape (nv, n).
        rows: chosen rows.
        back: passive accelerations from the drift of the chosen rows, shape (passive, passive).
    """

    map: Array
    rows: npt.NDArray[np.intp]
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
        order = pivots_of(regular.scaled[:, passive].T)
        self.rows = np.sort(order[: len(passive)])

    def at(self, placed: Placed) -> QuickTangent | None:
        """T (nv, n) at a closed configuration."""
        k, matrix = self.kinematics, placed.scaled
        actuated, passive = matrix[:, self._actuated], matrix[:, self._passive]
        chosen = passive[self.rows]
        n = self.n
        right = np.concatenate([actuated[self.rows], np.eye(len(chosen))], axis=1)
        solved = right
        if len(chosen):
            factors = LU(chosen)
            if not are_trusted(factors.pivots):
                return None
            solved = factors.solve(right)
        if np.abs(actuated - passive @ solved[:, :n]).max(initial=0.0) > MET:
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
