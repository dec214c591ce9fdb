"""Integrals of smooth pieces: Clenshaw and Curtis on 17 points, which hold the 9 of half the order.

C. W. Clenshaw, A. R. Curtis: A method for numerical integration on an automatic computer.  Numer. Math. 2 (1960)
197-205.  The difference of the two orders bounds the error of the lower one; that of the higher one is far less where
the integrand is smooth.  The points crowd at the ends, which belong to them, so that a piece is interpolated by
the barycentric formula (J.-P. Berrut, L. N. Trefethen: Barycentric Lagrange interpolation.  SIAM Rev. 46 (2004)
501-517) as exactly as it is integrated.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array, readonly

ORDER = 16
"""Of the higher rule; there is one point more."""
FINER = 4
"""So many times as many points has a piece that is looked at closely."""


def _points(order: int) -> Array:
    return 0.5 * (1.0 - np.cos(np.pi * np.arange(order + 1) / order))


def _weights(order: int) -> Array:
    """Of the points on a piece of length 1; the order is even."""
    j = np.arange(1, order // 2 + 1)
    share = np.where(j == order // 2, 1.0, 2.0) / (4.0 * j * j - 1.0)
    k = np.arange(order + 1)
    waves = 1.0 - np.cos(2.0 * np.pi * np.outer(k, j) / order) @ share
    return np.asarray(np.where((k == 0) | (k == order), 0.5, 1.0) * waves / order)


def between(where: Array) -> Array:
    """The matrix that takes values at the points to values at other places of [0, 1], shape (places, points)."""
    signs = np.where(np.arange(ORDER + 1) % 2, -1.0, 1.0)
    signs[[0, -1]] *= 0.5
    away = np.asarray(where, dtype=np.float64)[:, None] - POINTS
    exact = away == 0.0
    share = signs / np.where(exact, 1.0, away)
    share[exact.any(axis=1)] = 0.0
    share[exact] = 1.0
    return np.asarray(share / share.sum(axis=1, keepdims=True))


POINTS = readonly(_points(ORDER))
WEIGHTS = readonly(_weights(ORDER))
COARSE = readonly(_weights(ORDER // 2))
"""Weights of every second point."""
CLOSE_UP = readonly(_points(FINER * ORDER))
TO_CLOSE_UP = readonly(between(CLOSE_UP))
