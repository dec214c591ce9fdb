"""The whole motion: laws of time of all pieces of a way with a continuous acceleration, one after the other, as rows.

The time 2 c over which a law is averaged bounds the jerk.  Where a limit of jerk needs more, the law is averaged over a
longer time, and also slowed where the bends of the way alone are too much; of both the quickest that keeps the limit is
taken.  That is a motion within the limit, not the quickest of all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from cutjoint.arrays import Array, Frozen
from cutjoint.errors import RetimingError
from cutjoint.reprs import line
from cutjoint.retiming.path import WayPiece
from cutjoint.retiming.time_law import TimeLaw, law_of

ROWS = 8
"""Rows in the time over which a law is averaged."""
LEAST_ROWS = 2
"""Rows a sample of the way."""
SLOWER = tuple(0.97**k for k in range(0, 100, 3))
HALVINGS = 12
LONGEST = 0.5
"""The longest time over which a law is averaged, beside its own."""


@dataclass(frozen=True, eq=False)
class Smoothed(Frozen):
    """Rows of a motion, and the laws that they are of.

    Attributes:
        times: shape (k,) [s].
        q: shape (k, n) [m] or [rad].
        half: half of the time over which laws are averaged [s].
        starts: when each piece begins, shape (pieces + 1,) [s].
        laws: of the pieces.
    """

    times: Array
    q: Array
    half: float
    starts: Array
    laws: tuple[TimeLaw, ...]

    __repr__ = line("half", "laws", half="s")

    def inside(self, k: int, t: Array, *, last: bool) -> Array:
        """Which instants are in piece k, shape (len(t),)."""
        end = t <= self.starts[k + 1] * (1.0 + 1e-12) if last else t < self.starts[k + 1]
        return np.asarray((t >= self.starts[k]) & end)

    def place(self, k: int, t: Array) -> Array:
        """Way lengths at instants of piece k."""
        law = self.laws[k]
        return _around(law.at(np.clip(t - self.starts[k], 0.0, law.duration)), law)

    def along(self, t: Array) -> tuple[Array, Array]:
        """Way lengths and their rates at instants, shape (len(t),) each."""
        place, speed = np.zeros_like(t), np.zeros_like(t)
        for k, law in enumerate(self.laws):
            here = self.inside(k, t, last=k == len(self.laws) - 1)
            place[here] = self.place(k, t[here])
            since = t[here] - self.starts[k]
            after, before = (np.clip(since + off, 0.0, law.duration) for off in (1e-3 * self.half, -1e-3 * self.half))
            speed[here] = (law.at(after) - law.at(before)) / (after - before)
        return place, speed


def smoothed(parts: Sequence[tuple[WayPiece, Array]], half: float, jerk: Array, *, goes_round: bool) -> Smoothed:
    """Rows of the quickest motion whose s_dot^2 are given, averaged over 2 `half`, or longer where `jerk` needs it.

    Raises:
        RetimingError: no motion was found that keeps the limits of jerk.
    """
    first = _rows(parts, half, 1.0, goes_round)
    if not np.isfinite(jerk).any() or _jerk_part(first, jerk, goes_round) <= 1.0:
        return first
    best: Smoothed | None = None
    whole = min(law.shortest for law in first.laws)
    for part in SLOWER:
        low, high = half, LONGEST * whole / part
        if best is not None and sum(law.shortest for law in first.laws) / part >= best.times[-1]:
            break
        now = _rows(parts, high, part, goes_round)
        if _jerk_part(now, jerk, goes_round) > 1.0:
            continue
        for _ in range(HALVINGS):
            middle = float(np.sqrt(low * high))
            tried = _rows(parts, middle, part, goes_round)
            if _jerk_part(tried, jerk, goes_round) <= 1.0:
                high, now = middle, tried
            else:
                low = middle
        if best is None or now.times[-1] < best.times[-1]:
            best = now
    if best is None:
        raise RetimingError(
            "no motion was found that keeps the limits of jerk: even 20 times slower the bends of the way pass them. "
            "Raise them, or round the way",
            limits=["jerk"],
            place=0.0,
            t=0.0,
        )
    return best


def _rows(parts: Sequence[tuple[WayPiece, Array]], half: float, slower: float, goes_round: bool) -> Smoothed:
    laws: list[TimeLaw] = []
    times: list[Array] = []
    rows: list[Array] = []
    starts = [0.0]
    for piece, squares in parts:
        shortest = law_of(piece.s, squares * slower**2, half).shortest
        own = min(half, LONGEST * shortest)
        law = law_of(piece.s, squares * slower**2, own, goes_round=goes_round)
        count = int(max(np.ceil(ROWS * law.duration / (2.0 * own)), LEAST_ROWS * len(piece.s)))
        t = np.linspace(0.0, law.duration, count + 1)
        q = piece.at(_around(law.at(t), law))
        if goes_round:
            q[-1] = q[0]
        elif not rows:
            q[0] = piece.q[0]
        if not goes_round:
            q[-1] = piece.q[-1]
        skip = 1 if rows else 0
        times.append(starts[-1] + t[skip:])
        rows.append(q[skip:])
        laws.append(law)
        starts.append(starts[-1] + law.duration)
    q = np.concatenate(rows)
    return Smoothed(np.concatenate(times), q, half, np.array(starts), tuple(laws))


def _around(s: Array, law: TimeLaw) -> Array:
    """Way lengths of a law within its piece."""
    if not law.goes_round:
        return s
    return np.asarray(law.s[0] + np.mod(s - law.s[0], law.s[-1] - law.s[0]))


def _jerk_part(now: Smoothed, jerk: Array, goes_round: bool) -> float:
    """The largest part of a limit of jerk that the spline through the rows asks for."""
    bounds = "periodic" if goes_round else "clamped"
    third = CubicSpline(now.times, now.q, bc_type=bounds)(0.5 * (now.times[1:] + now.times[:-1]), 3)
    return float((np.abs(third) / jerk).max())
