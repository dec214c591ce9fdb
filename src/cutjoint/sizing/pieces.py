"""A way in smooth pieces, divided until every integral over it is right.

A piece whose two orders of integration differ by too much is divided where an actuator turns round or its effort
changes sign (there friction jumps, and the power that comes back begins), else in the middle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cutjoint.arrays import Array
from cutjoint.sizing.chebyshev import CLOSE_UP, COARSE, POINTS, TO_CLOSE_UP, WEIGHTS
from cutjoint.sizing.values import Course

RELATIVE = 1e-9
"""By how much the two orders may differ, beside an integral or, where that is small, beside SLIGHT times the greatest
that it might be."""
FINE_RELATIVE = 1e-5
"""The same over a spline of very many knots, at each of which its third derivative jumps."""
SLIGHT = 1e-3
INSIDE = 1e-12
"""Part of the whole time by which the ends of a piece are looked at inside it: on its own side of a jump."""
SHORTEST = 1e-10
"""Part of the whole time below which no piece is divided."""
APART = 1e-6
"""Part of a piece by which places are apart where it is divided."""
MOST_TURNS = 6
"""Changes of sign in a piece; where there are more it is too long to tell them."""
FIRST, MOST = 8, 4000
"""Pieces to begin with, and at most."""

Evaluate = Callable[[Array], Course]
Integrands = Callable[[Course], Array]


@dataclass(frozen=True, eq=False)
class SmoothPiece:
    """From `low` to `high` [s]: what was evaluated at its points."""

    low: float
    high: float
    course: Course

    @property
    def width(self) -> float:
        """[s]."""
        return self.high - self.low

    def integral(self, values: Array) -> Array:
        """Of values at its points, shape (points, ...)."""
        return np.asarray(self.width * np.tensordot(WEIGHTS, values, axes=1))

    def roughly(self, values: Array) -> Array:
        """The same by the lower order."""
        return np.asarray(self.width * np.tensordot(COARSE, values[::2], axes=1))

    def close_up_of(self, values: Array) -> Array:
        """Values at its points, shape (points, n), interpolated at more of them."""
        return np.asarray(TO_CLOSE_UP @ values)

    @property
    def close_up(self) -> tuple[Array, Array, Array, Array]:
        """Times, velocities, efforts and efforts without rotors, interpolated at more points."""
        v, effort, bare = (self.close_up_of(one) for one in (self.course.v, self.course.effort, self.course.bare))
        return self.low + self.width * CLOSE_UP, v, effort, bare


@dataclass(frozen=True, eq=False)
class SmoothWay:
    """All pieces in their order.

    Attributes:
        pieces: of smooth motion.
        integrals: of the integrands, over the whole way.
        error: by how much they may be wrong, relative; twice the order is far more exact where the motion is smooth.
    """

    pieces: tuple[SmoothPiece, ...]
    integrals: Array
    error: float


def way_of(
    evaluate: Evaluate,
    integrands: Integrands,
    scales: Callable[[Course], Array],
    breaks: Array,
    duration: float,
    relative: float = RELATIVE,
) -> SmoothWay:
    """The way divided so that all integrals are right.

    Args:
        evaluate: the course at instants.
        integrands: of a course, shape (m, k).
        scales: greatest sizes that the integrands might have, of a course with the extremes, shape (k,).
        breaks: instants at which the motion is not smooth [s].
        duration: of the way [s].
        relative: by how much the two orders may differ.
    """
    edges = np.concatenate([[0.0], breaks, [duration]])
    spans = np.diff(edges)
    parts = np.maximum(1, np.ceil(FIRST * spans / duration)).astype(int)
    todo = [
        (low + (high - low) * k / count, low + (high - low) * (k + 1) / count)
        for low, high, count in zip(edges[:-1], edges[1:], parts, strict=True)
        for k in range(count)
    ]
    done: list[SmoothPiece] = []
    rough: list[Array] = []
    while todo:
        fresh = _evaluated(evaluate, todo, duration)
        everything = [*done, *fresh]
        sizes = sum((piece.integral(np.abs(integrands(piece.course))) for piece in everything), np.zeros(()))
        bound = SLIGHT * duration * scales(Course.joined([piece.course for piece in everything]))
        allowed = relative * np.maximum(sizes, bound)
        todo = []
        full = len(everything) >= MOST
        for piece in fresh:
            values = integrands(piece.course)
            off = np.abs(piece.integral(values) - piece.roughly(values))
            if full or piece.width < SHORTEST * duration or bool((off <= allowed).all()):
                done.append(piece)
                rough.append(off / np.maximum(np.maximum(sizes, bound), 1e-300))
            else:
                cuts = [piece.low, *_turning(piece), piece.high]
                todo += pairwise(cuts)
    order = np.argsort([piece.low for piece in done], kind="stable")
    pieces = tuple(done[k] for k in order)
    integrals = sum((piece.integral(integrands(piece.course)) for piece in pieces), np.zeros(()))
    return SmoothWay(pieces, np.asarray(integrals), float(np.sum(rough, axis=0).max(initial=0.0)))


def _evaluated(evaluate: Evaluate, spans: list[tuple[float, float]], duration: float) -> list[SmoothPiece]:
    """The pieces, evaluated together."""
    times = []
    for low, high in spans:
        own = low + (high - low) * POINTS
        inside = min(INSIDE * duration, 1e-3 * (high - low))
        own[0], own[-1] = low + inside, high - inside
        times.append(own)
    course, count = evaluate(np.concatenate(times)), len(POINTS)
    return [
        SmoothPiece(low, high, course.piece(k * count, (k + 1) * count)) for k, (low, high) in enumerate(spans)
    ]  # fmt: skip


def _turning(piece: SmoothPiece) -> list[float]:
    """Where a piece is divided: at changes of sign of velocities, efforts and powers, else in the middle."""
    times, v, effort, bare = piece.close_up
    values = np.hstack([v, effort, bare])
    found = []
    for column in values.T:
        for k in np.flatnonzero(column[1:] * column[:-1] < 0.0):
            share = column[k] / (column[k] - column[k + 1])
            found.append(float(times[k] + share * (times[k + 1] - times[k])))
    edge = APART * piece.width
    kept = [piece.low]
    for t in sorted(found):
        if t - kept[-1] > edge and piece.high - t > edge:
            kept.append(t)
    return kept[1:] if 1 < len(kept) <= MOST_TURNS else [0.5 * (piece.low + piece.high)]
