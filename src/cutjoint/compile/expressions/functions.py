"""Elementary functions of expressions and floats alike.

This module is the namespace `fn` that the equations of `cutjoint.papers` ask for, as the modules math and numpy are.
"""

from __future__ import annotations

from cutjoint.compile.expressions.graph import FOLDED, Expression, Number
from cutjoint.compile.expressions.operations import Op


def is_zero(value: Number) -> bool:
    """Whether a value is zero whatever the inputs are."""
    return (value.constant if isinstance(value, Expression) else value) == 0.0


def sqrt(x: Number) -> Number:
    """Square root."""
    return _apply(Op.SQRT, x)


def sin(x: Number) -> Number:
    """Sine."""
    return _apply(Op.SIN, x)


def cos(x: Number) -> Number:
    """Cosine."""
    return _apply(Op.COS, x)


def acos(x: Number) -> Number:
    """Inverse cosine."""
    return _apply(Op.ACOS, x)


def atan2(y: Number, x: Number) -> Number:
    """Angle of the point (x, y)."""
    return _apply(Op.ATAN2, y, x)


def absolute(x: Number) -> Number:
    """|x|."""
    return _apply(Op.ABS, x)


def minimum(x: Number, y: Number) -> Number:
    """The smaller one."""
    return _apply(Op.MIN, x, y)


def maximum(x: Number, y: Number) -> Number:
    """The larger one."""
    return _apply(Op.MAX, x, y)


def _apply(op: Op, *values: Number) -> Number:
    graph = next((value.graph for value in values if isinstance(value, Expression)), None)
    if graph is None:
        return FOLDED[op](*values)
    return Expression(graph, graph.function(op, *(graph.reference(value) for value in values)))
