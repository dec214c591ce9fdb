"""Linear systems with a step of refinement: singular ones in the sense of least squares, least norm."""

from __future__ import annotations

import numpy as np
from oracles.reading import Array

MASSLESS = 1e-13
"""Motions whose kinetic energy is below this part of that of the heaviest one move no mass."""


def saddle(hessian: Array, rows: Array, force: Array, right: Array) -> tuple[Array, Array]:
    """y and f of hessian y = force + rows' f, rows y = right; of least norm where they are not unique."""
    n = len(hessian)
    if not n + len(rows):
        return np.zeros(0), np.zeros(0)
    size = max(float(np.diag(hessian).max(initial=0.0)), 1e-300)
    norms = np.linalg.norm(rows, axis=1)
    scale = 1.0 / np.where(norms > 0.0, norms, 1.0)
    top = rows * scale[:, None]
    matrix = np.block([[hessian / size, -top.T], [top, np.zeros((len(rows), len(rows)))]])
    wanted = np.r_[force / size, right * scale]
    found = np.zeros(len(wanted))
    for _ in range(2):
        found = found + np.linalg.lstsq(matrix, residual(matrix, found, wanted), rcond=MASSLESS)[0]
    return found[:n], found[n:] * scale * size


def residual(matrix: Array, x: Array, right: Array) -> Array:
    """right - matrix x, summed in extended precision."""
    wide = np.longdouble
    return np.asarray(right.astype(wide) - matrix.astype(wide) @ x.astype(wide), dtype=float)
