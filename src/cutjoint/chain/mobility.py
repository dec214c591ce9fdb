"""Mobility of a closed robot at a posture: rank of its constraints, what the actuators determine, how near it is to a
singularity.

All matrices are scaled by the characteristic length, so singular values are dimensionless.  With K the constraint
Jacobian, split into actuated and passive columns K_a and K_p:

- mobility = velocities - rank K; rows beyond the rank are redundant.
- type-2 (parallel) singularity: K_p loses rank, so the robot moves with all actuators locked.
- type-1 (serial) singularity: the tool's Jacobian loses rank, so the tool cannot move in some direction.

Idle motions, such as a rod between two balls that spins about itself, are counted in the mobility; the actuators need
not determine them.

After Gosselin and Angeles, Singularity analysis of closed-loop kinematic chains, IEEE T. Robot. Autom. 6(3), 1990.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Kinematics, Placed, joints_of
from cutjoint.chain.rank import dependent_rows, rank_of, smallest
from cutjoint.chain.structure import Structure, idle_motions, locked_motions, scaled_tool
from cutjoint.chain.tangent import tangent_map


@dataclass(frozen=True)
class MobilityReport:
    """Mobility of a closed robot at one posture.

    Attributes:
        velocities: velocities of the open tree.
        rows, rank: constraint rows, and how many of them are independent here.
        mobility: velocities - rank.
        redundant_rows: names of rows that depend on the rows before them.
        dropped_rows: those of them that do so only up to rounding, and are not closed.
        actuators: number of actuated coordinates.
        determined: whether the actuators determine the motion but for idle ones, and do not depend on each other.
        idle_mobility: number of idle motions: with all actuators locked, and without moving the tool.
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
    dropped_rows: tuple[str, ...]
    actuators: int
    determined: bool
    idle_mobility: int
    free: tuple[str, ...]
    idle: tuple[str, ...]
    type1: float
    type2: float
    condition: float
    gap: tuple[float, float]


def mobility_report(kinematics: Kinematics, actuated: Array, structure: Structure, placed: Placed) -> MobilityReport:
    """Mobility at one configuration.

    Args:
        actuated: velocity indices of the actuated joints, shape (n,).
        structure: of the robot at nearly every posture.
    """
    k, n, nv = kinematics, len(actuated), kinematics.model.nv
    passive = np.setdiff1d(np.arange(nv), actuated)
    matrix = placed.scaled
    distance, angle, _ = placed.gap
    rank = rank_of(matrix)
    locked = locked_motions(k, actuated, placed)
    idle = idle_motions(k, actuated, placed, locked)
    tangent = tangent_map(k, actuated, passive, placed, structure.idle)
    regular = tangent.type2 > tolerances.RANK.value
    determined = regular and tangent.consistent and locked.shape[1] == structure.idle
    usually = structure.locked == structure.idle and structure.rank + structure.idle + n == nv
    type1 = condition = float("nan")
    type2 = tangent.type2 if determined or usually else float("nan")
    if determined and k.tool_support is not None and structure.directions:
        jacobian = scaled_tool(k, placed)[:3] / k.column_scale @ tangent.map * k.column_scale[actuated]
        values = np.linalg.svd(jacobian, compute_uv=False)
        type1 = smallest(jacobian, structure.directions)
        condition = float(values[0] / type1) if type1 > 0.0 else float("inf")
    return MobilityReport(
        velocities=nv,
        rows=k.closure.all_rows,
        rank=rank,
        mobility=nv - rank,
        redundant_rows=(*k.closure.left_out, *(k.closure.row_names[i] for i in dependent_rows(matrix))),
        dropped_rows=k.closure.left_out,
        actuators=n,
        determined=determined,
        idle_mobility=idle.shape[1],
        free=joints_of(k.model, locked),
        idle=joints_of(k.model, idle),
        type1=type1,
        type2=type2,
        condition=condition,
        gap=(distance, angle),
    )
