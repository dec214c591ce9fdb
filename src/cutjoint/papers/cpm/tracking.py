"""Following the tool of the CPM with rotary motors while the motors turn, without ever leaving the branch.

With the elbows moved by a distance d in all (root of the sum of squares) from a closed posture, the errors of (3), (6),
(9) at the old tool are at most L2 d + d^2 / 2, the rods' matrix E changes by at most d, and the second derivatives of
the errors are below sqrt(2).  By the theorem of Newton and Kantorovich a solution exists near the old tool, is the only
one around, and E stays regular on the whole way there, as long as

    sqrt(2) (L2 d + d^2 / 2) <= (s - d)^2 / 2,    s the smallest singular value of E

Steps of this size therefore stay on the branch, and stop only before a singularity of type 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import NamedTuple

import numpy as np

from cutjoint.arrays import Array
from cutjoint.papers.cpm import forward
from cutjoint.papers.cpm.parameters import Parameters

NEWTON_STEPS = 30
"""Newton converges quadratically within the bound above: five steps are usual."""

SAFETY = 0.9
"""Fraction of the largest proved step that is taken."""


class Track(NamedTuple):
    """Where a way ended.

    Attributes:
        tool: there [m].
        progress: fraction of the way, 1 at the target.
        measure: volume of the second rods' directions there, the type-2 measure without its sign.
    """

    tool: tuple[float, float, float]
    progress: float
    measure: float


class Tracker:
    """Walks along straight ways of the motor angles.

    Args:
        parameters: geometry.
        limit: smallest volume of the second rods' directions; the walk ends where it is less.
    """

    def __init__(self, parameters: Parameters, limit: float) -> None:
        self._p, self._limit = parameters, limit

    def walk(self, angles: Sequence[float], tool: Sequence[float], target: Sequence[float]) -> Track:
        """Turn the motors from `angles` to `target` [rad] on a straight way, the tool starting at `tool` [m]."""
        p = self._p
        start, move = np.asarray(angles, dtype=np.float64), np.subtract(target, angles)
        length = p.L1 * float(np.linalg.norm(move))  # no elbow's chord is longer than its arc
        done, here = 0.0, np.asarray(tool, dtype=np.float64)
        while True:
            e = self._rods(start + done * move, here)
            measure = abs(float(np.linalg.det(e))) / p.L2**3
            if done >= 1.0 or measure < self._limit:
                x, y, z = here.tolist()
                return Track((x, y, z), done, measure)
            step = SAFETY * self._proved(float(np.linalg.svd(e, compute_uv=False)[-1]))
            done = 1.0 if length * (1.0 - done) <= step else done + step / length
            here = self._settled(start + done * move, here)

    def _proved(self, smallest: float) -> float:
        """The largest d of the bound: a root of a quadratic, written so that it is exact for small ones."""
        half = smallest + sqrt(2.0) * self._p.L2
        # (s - d)^2 = 2 sqrt(2) L2 d + sqrt(2) d^2, that is (sqrt(2) - 1) d^2 + 2 half d - s^2 = 0
        return smallest * smallest / (half + sqrt(half * half + (sqrt(2.0) - 1.0) * smallest * smallest))

    def _rods(self, angles: Array, tool: Array) -> Array:
        x, y, z = tool
        (y1, z1), (z2, x2), (x3, y3) = forward.elbows(self._p, angles)
        return np.array([[0.0, y - y1, z - z1], [x - x2, 0.0, z - z2], [x - x3, y - y3, 0.0]])

    def _settled(self, angles: Array, tool: Array) -> Array:
        """Newton's method on (3), (6), (9), to rounding."""
        last = np.inf
        for _ in range(NEWTON_STEPS):
            e = self._rods(angles, tool)
            error = 0.5 * (np.sum(e * e, axis=1) - self._p.L2**2)
            step = np.linalg.solve(e, error)
            size = float(np.abs(step).max())
            tool = tool - step
            if size < 1e-15 * self._p.L2 or (size < 1e-9 * self._p.L2 and size >= 0.5 * last):
                break
            last = size
        return np.asarray(tool)
