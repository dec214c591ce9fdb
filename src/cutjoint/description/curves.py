"""Curves of one number: what a coupling makes of the coordinate of a joint.

A curve is made of polynomials, each from one number on to the next, about a number of its own; so everything that
computes with curves, in numbers or in expressions, reads `pieces` and nothing else.  A table of points is the natural
cubic spline through them, which goes on straight beyond its ends: value, slope and bend are continuous everywhere.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np


class Piece(NamedTuple):
    """The part of a curve from `start` on: sum of coefficients[k] (x - centre)^k."""

    start: float
    centre: float
    coefficients: tuple[float, ...]


class CurvePoint(NamedTuple):
    """A curve at one number, with its first and second derivative."""

    value: float
    slope: float
    bend: float


class Curve:
    """A function of one number, made of `pieces`."""

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """Its parts in order; the first one holds from minus infinity on."""
        raise NotImplementedError

    @property
    def ratio(self) -> float | None:
        """Its slope where it is a straight line through zero, else None."""
        return None

    def terms(self, x: str) -> list[tuple[float, str]]:
        """What it adds up, to be read, of a number called `x`: factors and what they stand before."""
        raise NotImplementedError

    def scaled(self, unit_x: float, unit_y: float) -> Curve:
        """The same curve between other units: x in units of `unit_x`, y in units of `unit_y`."""
        raise NotImplementedError

    def at(self, x: float) -> CurvePoint:
        """Value, slope and bend at a number."""
        piece = self.pieces[0]
        for one in self.pieces[1:]:
            if x < one.start:
                break
            piece = one
        x, value, slope, bend = x - piece.centre, 0.0, 0.0, 0.0
        for coefficient in reversed(piece.coefficients):
            bend = bend * x + 2.0 * slope
            slope = slope * x + value
            value = value * x + coefficient
        return CurvePoint(value, slope, bend)


@dataclass(frozen=True)
class Polynomial(Curve):
    """sum of coefficients[k] x^k; without a word x itself."""

    coefficients: tuple[float, ...] = (0.0, 1.0)

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """One."""
        return (Piece(-np.inf, 0.0, self.coefficients),)

    @property
    def ratio(self) -> float | None:
        """Its slope where it is a straight line through zero, else None."""
        constant, slope, *higher = (*self.coefficients, 0.0, 0.0)
        return slope if constant == 0.0 and not any(higher) else None

    def terms(self, x: str) -> list[tuple[float, str]]:
        """What it adds up."""
        powers = ["", x, *(f"{x}^{k}" for k in range(2, len(self.coefficients)))]
        return list(zip(self.coefficients, powers, strict=False))

    def scaled(self, unit_x: float, unit_y: float) -> Polynomial:
        """The same curve between other units."""
        return Polynomial(tuple(c * unit_x**k / unit_y for k, c in enumerate(self.coefficients)))


@dataclass(frozen=True)
class Table(Curve):
    """The natural cubic spline through points (x, y), at least two, with growing x; straight beyond its ends."""

    points: tuple[tuple[float, float], ...]

    @cached_property
    def _pieces(self) -> tuple[Piece, ...]:
        x, y = np.array(self.points, dtype=float).T
        h, rise = np.diff(x), np.diff(y) / np.diff(x)
        bends = np.zeros(len(x))
        if len(x) > 2:
            matrix = np.diag(2.0 * (h[1:] + h[:-1])) + np.diag(h[1:-1], 1) + np.diag(h[1:-1], -1)
            bends[1:-1] = np.linalg.solve(matrix, 6.0 * np.diff(rise))
        slopes = rise - h * (2.0 * bends[:-1] + bends[1:]) / 6.0
        last = float(rise[-1] + h[-1] * (bends[-2] + 2.0 * bends[-1]) / 6.0)
        cubics = np.column_stack([y[:-1], slopes, bends[:-1] / 2.0, np.diff(bends) / (6.0 * h)]).tolist()
        inner = [Piece(start, start, tuple(cubic)) for start, cubic in zip(x.tolist(), cubics, strict=False)]
        first = Piece(-np.inf, float(x[0]), (float(y[0]), float(slopes[0])))
        return (first, *inner, Piece(float(x[-1]), float(x[-1]), (float(y[-1]), last)))

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """A straight one, a cubic between each two points, and a straight one."""
        return self._pieces

    def terms(self, x: str) -> list[tuple[float, str]]:
        """What it adds up."""
        return [(1.0, f"spline of {len(self.points)} points({x})")]

    def scaled(self, unit_x: float, unit_y: float) -> Table:
        """The same curve between other units."""
        return Table(tuple((x / unit_x, y / unit_y) for x, y in self.points))


def added_up(terms: Iterable[tuple[float, str]]) -> str:
    """A sum to be read: `0.5 left - right^2 + 0.1`."""
    words = [
        ("-" if factor < 0.0 else "+", what if what and abs(factor) == 1.0 else f"{abs(factor):g} {what}".strip())
        for factor, what in terms
        if factor != 0.0
    ]
    if not words:
        return "0"
    (sign, first), *others = words
    return " ".join([f"-{first}" if sign == "-" else first, *(f"{sign} {word}" for sign, word in others)])
