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
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Kinematics, ToolPoint
from cutjoint.chain.tangent import tangent_map


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
        idle: those of them that do so without moving the tool, such as a rod that spins about itself.
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
    idle: tuple[str, ...]
    type1: float
    type2: float
    condition: float
    gap: tuple[float, float]


def mobility_report(
    kinematics: Kinematics, actuated: Array, tool: ToolPoint | None, directions: int, q: Array
) -> MobilityReport:
    """Mobility at the configuration `q` (nq,).

    Args:
        actuated: velocity indices of the actuated joints, shape (n,).
        tool: the tool point, if there is one, and in how many directions it can move where the robot is regular.
    """
    k, n, nv = kinematics, len(actuated), kinematics.model.nv
    passive = np.setdiff1d(np.arange(nv), actuated)
    k.update(q)
    matrix = k.scaled_jacobian()
    distance, angle, _ = k.gap(q)
    rank = rank_of(matrix)
    locked = null_space(np.concatenate([matrix, np.eye(nv)[actuated]]))
    idle = locked
    if tool is not None and locked.shape[1]:
        still = tool.jacobian(k.data) * k.column_scale * np.array([1.0 / k.length] * 3 + [1.0] * 3)[:, None]
        idle = null_space(np.concatenate([matrix, np.eye(nv)[actuated], still]))
    determined = locked.shape[1] == 0 and n == nv - rank
    type1 = type2 = condition = float("nan")
    if determined:
        tangent = tangent_map(k, actuated, passive, q)
        type2 = tangent.type2
        if tool is not None and directions:
            jacobian = tool.jacobian(k.data)[:3] @ tangent.map * k.column_scale[actuated] / k.length
            values = np.linalg.svd(jacobian, compute_uv=False)
            type1 = smallest(jacobian, directions)
            condition = float(values[0] / type1) if type1 > 0.0 else float("inf")
    return MobilityReport(
        velocities=nv,
        rows=k.closure.all_rows,
        rank=rank,
        mobility=nv - rank,
        redundant_rows=(*k.closure.left_out, *(k.closure.row_names[i] for i in dependent_rows(matrix))),
        actuators=n,
        determined=determined,
        free=joints_of(k.model, locked),
        idle=joints_of(k.model, idle),
        type1=type1,
        type2=type2,
        condition=condition,
        gap=(distance, angle),
    )


def joints_of(model: pin.Model, motions: Array) -> tuple[str, ...]:
    """Names of the joints that take part in any of the motions, shape (nv, k)."""
    moving = np.abs(motions).max(axis=1, initial=0.0) > 1e-6
    return tuple(
        model.names[joint]
        for joint in range(1, model.njoints)
        if moving[model.idx_vs[joint] : model.idx_vs[joint] + model.nvs[joint]].any()
    )


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
