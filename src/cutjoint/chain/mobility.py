"""Mobility of a closed robot at a posture: rank of its constraints, what the actuators determine, how near it is to a
singularity.

All matrices are scaled by the characteristic length, so singular values are dimensionless.  With K the constraint
Jacobian, split into actuated and passive columns K_a and K_p:

- mobility = velocities - rank K; rows beyond the rank are redundant.
- type-2 (parallel) singularity: K_p loses rank, so the robot moves with all actuators locked.
- type-1 (serial) singularity: the tool's Jacobian loses rank, so the tool cannot move in some direction.

After Gosselin and Angeles, Singularity analysis of closed-loop kinematic chains, IEEE T. Robot. Autom. 6(3), 1990.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array


@dataclass(frozen=True)
class MobilityReport:
    """Mobility of a closed robot at one posture.

    Attributes:
        velocities: velocities of the open tree.
        rows, rank: constraint rows, and how many of them are independent here.
        mobility: velocities - rank.
        redundant_rows: names of rows that depend on the rows before them.
        actuators: number of actuated coordinates.
        determined: whether the actuators determine the motion, and are as many as the mobility.
        free: passive joints that move with all actuators locked.
        type1, type2: distance to type-1 and type-2 singularities, dimensionless, 0 = singular; NaN where undefined
            (no tool; motion not determined).
        condition: condition number of the scaled tool Jacobian; NaN where undefined.
        gap: worst loop gap ([m], [rad]).
    """

    velocities: int
    rows: int
    rank: int
    mobility: int
    redundant_rows: tuple[str, ...]
    actuators: int
    determined: bool
    free: tuple[str, ...]
    type1: float
    type2: float
    condition: float
    gap: tuple[float, float]


def rank_of(matrix: Array) -> int:
    """Rank of a scaled matrix, cut at the tolerance RANK."""
    values = np.linalg.svd(matrix, compute_uv=False) if matrix.size else np.zeros(0)
    return int(np.sum(values > tolerances.RANK.value * max(values.max(initial=0.0), 1e-300)))


def null_space(matrix: Array) -> Array:
    """Orthonormal basis of the null space of a scaled matrix, shape (columns, nullity)."""
    columns = matrix.shape[1]
    if matrix.shape[0] == 0:
        return np.eye(columns)
    _, values, basis = np.linalg.svd(matrix)
    rank = int(np.sum(values > tolerances.RANK.value * max(values.max(initial=0.0), 1e-300)))
    return np.asarray(basis[rank:].T)


def dependent_rows(matrix: Array) -> list[int]:
    """Rows that depend on the rows before them (Gram-Schmidt, twice for rounding)."""
    basis: list[Array] = []
    dependent: list[int] = []
    size = float(np.abs(matrix).max(initial=1e-300))
    for index, row in enumerate(matrix):
        rest = row.copy()
        for _ in range(2):
            for direction in basis:
                rest -= (rest @ direction) * direction
        length = float(np.linalg.norm(rest))
        if length > 1e-6 * size:
            basis.append(rest / length)
        else:
            dependent.append(index)
    return dependent


def smallest(matrix: Array, count: int) -> float:
    """The `count`-th largest singular value of a scaled matrix (0 where it has fewer)."""
    if count == 0:
        return float("inf")
    values = np.linalg.svd(matrix, compute_uv=False)
    return float(values[count - 1]) if len(values) >= count else 0.0
