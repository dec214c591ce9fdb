"""Ranks of robots whose loops are a little open in the file's digits."""

from __future__ import annotations

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Kinematics, Placed

MAGNIFIED = 1e3
"""Singular values up to so many times what the loops are open by are rounding."""


def rounding(kinematics: Kinematics, placed: Placed) -> float:
    """Singular values of dimensionless rows below it are but the rounding of lengths; as a rule 0."""
    distance, angle, _ = placed.gap
    least = MAGNIFIED * max(distance / kinematics.length, angle)
    return least if least > tolerances.RANK.value else 0.0


def trusted(kinematics: Kinematics, placed: Placed, matrix: Array) -> Array:
    """Dimensionless rows or columns of loops without singular values that are but rounding."""
    least = rounding(kinematics, placed)
    if not least or not matrix.size:
        return matrix
    left, values, right = np.linalg.svd(matrix, full_matrices=False)
    return np.asarray((left * np.where(values > least, values, 0.0)) @ right)
