"""How a soft robot answers small forces in one posture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Placed
from cutjoint.reprs import line


@dataclass(frozen=True, eq=False)
class SoftResponse:
    """How a soft robot answers generalised forces p in one posture: motion = basis @ solve(stiffness, basis' p).

    All are dimensionless in motions: lengths by the robot's, so that stiffness is energy [J].

    Attributes:
        placed: the soft robot.
        basis: closed motions, shape (nv, d).
        stiffness: of them, shape (d, d) [J].
        bending: derivative of weights, loads and loop forces along them, shape (nv, d) [J].
    """

    placed: Placed
    basis: Array
    stiffness: Array
    bending: Array

    __repr__ = line("stiffness", stiffness="J")


def evened(matrix: Array) -> Array:
    """A symmetric matrix with 1 or -1 on its diagonal."""
    root = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(matrix)), np.finfo(float).tiny))
    return np.asarray(root[:, None] * matrix * root)


def solved(stiffness: Array, right: Array) -> Array:
    """Solution with rows and columns evened, so that hard and soft springs keep their digits."""
    if not stiffness.size:
        return np.zeros_like(right)
    root = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(stiffness)), np.finfo(float).tiny))
    even = root[:, None] * stiffness * root
    return np.asarray((root * np.linalg.solve(even, (root * right.T).T).T).T)
