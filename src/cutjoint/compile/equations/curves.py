"""Curves (`cutjoint.description.curves`) as expressions: value, slope and bend, piece by piece."""

from __future__ import annotations

from cutjoint.compile.expressions.functions import where_less
from cutjoint.compile.expressions.graph import Number
from cutjoint.description.curves import Curve, Piece


def on_curve(curve: Curve, x: Number) -> tuple[Number, Number, Number]:
    """Value, slope and bend of a curve at a number."""
    first, *others = curve.pieces
    found = _on_piece(first, x)
    for piece in others:
        here = _on_piece(piece, x)
        before, at, beyond = ((old, new) for old, new in zip(found, here, strict=True))
        value, slope, bend = (where_less(x, piece.start, old, new) for old, new in (before, at, beyond))
        found = (value, slope, bend)
    return found


def _on_piece(piece: Piece, x: Number) -> tuple[Number, Number, Number]:
    x, found = x - piece.centre, (0.0, 0.0, 0.0)
    sums: tuple[Number, Number, Number] = found
    for coefficient in reversed(piece.coefficients):
        value, slope, bend = sums
        sums = (value * x + coefficient, slope * x + value, bend * x + 2.0 * slope)
    return sums
