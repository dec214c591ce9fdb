"""The tangent map of a closed chain: velocities of all joints from those of the actuators.

With the constraint Jacobian split into actuated and passive columns, K_a v + K_p v_p = 0 gives v_p = -K_p^+ K_a v.  The
smallest singular value of K_p (scaled by the characteristic length) is the distance to a type-2 singularity; the
pseudo-inverse keeps as many singular values as there are passive velocities, so redundant rows do no harm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Kinematics


@dataclass(frozen=True, eq=False)
class TangentMap:
    """Tangent map at one configuration.

    Attributes:
        map: T with v_full = T @ v, shape (nv, n).
        inverse: K_p^+, shape (passive, rows): d_passive = -inverse @ drift of the rows.
        type2: distance to a type-2 singularity, dimensionless; infinite where no joint is passive.
    """

    map: Array
    inverse: Array
    type2: float


def tangent_map(kinematics: Kinematics, actuated: Array, passive: Array, q: Array) -> TangentMap:
    """The tangent map at `q` (nq,) for the actuated and passive velocity indices, (n,) and (nv - n,).

    It means something only where the actuators determine the motion; at a type-2 singularity its entries are huge.
    """
    selection = np.zeros((kinematics.model.nv, len(actuated)))
    selection[actuated, np.arange(len(actuated))] = 1.0
    count = len(passive)
    if count == 0:
        return TangentMap(selection, np.zeros((0, kinematics.closure.rows)), float("inf"))
    kinematics.update(q)
    matrix = kinematics.scaled_jacobian()
    left, values, right = np.linalg.svd(matrix[:, passive], full_matrices=False)
    if len(values) < count:
        return TangentMap(selection, np.zeros((count, kinematics.closure.rows)), 0.0)
    inverse = right.T @ (left.T / np.maximum(values, 1e-300)[:, None])
    scale = kinematics.column_scale
    inverse = scale[passive, None] * inverse * kinematics.row_scale
    columns = matrix[:, actuated] / kinematics.row_scale[:, None] / scale[actuated]
    selection[passive] = -inverse @ columns
    return TangentMap(selection, inverse, float(values[count - 1]))
