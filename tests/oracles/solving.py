"""Linear systems with a step of refinement: singular ones in the sense of least squares, least norm."""

from __future__ import annotations

import numpy as np
from oracles.reading import Array

MOVED = 1e-9
"""Dimensionless velocities below this are none."""

MASSLESS = 1e-13
"""Motions whose kinetic energy is below this part of the heaviest body's move no mass."""


def saddle(hessian: Array, rows: Array, force: Array, right: Array, size: float) -> tuple[Array, Array]:
    """y and f of hessian y = force + rows' f, rows y = right; of least norm where they are not unique.

    `size` is what entries of the hessian are measured by: what is below `MASSLESS` of it is nothing.
    """
    n, norms = len(hessian), np.linalg.norm(rows, axis=1)
    scale = 1.0 / np.where(norms > MOVED, norms, 1.0)
    top = rows * scale[:, None]
    matrix = np.block([[hessian / size, -top.T], [top, np.zeros((len(rows), len(rows)))]])
    wanted = np.r_[force / size, right * scale]
    left, values, across = np.linalg.svd(matrix)
    rank = int(np.sum(values > MASSLESS))
    found = np.zeros(len(wanted))
    for _ in range(2):
        missing = residual(matrix, found, wanted)
        found = found + across[:rank].T @ ((left[:, :rank].T @ missing) / values[:rank])
    return found[:n], found[n:] * scale * size


def residual(matrix: Array, x: Array, right: Array) -> Array:
    """right - matrix x, summed in extended precision."""
    wide = np.longdouble
    return np.asarray(right.astype(wide) - matrix.astype(wide) @ x.astype(wide), dtype=float)
