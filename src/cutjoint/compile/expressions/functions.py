"""Elementary functions of expressions and floats alike.

This module is the namespace `fn` that the equations of `cutjoint.papers` ask for, as the modules math and numpy are.
"""

from __future__ import annotations

from functools import partial

from cutjoint.compile.expressions.graph import FOLDED, Expression, Number
from cutjoint.compile.expressions.operations import Op


def is_zero(value: Number) -> bool:
    """Whether a value is zero whatever the inputs are."""
    return (value.constant if isinstance(value, Expression) else value) == 0.0


def _apply(op: Op, *values: Number) -> Number:
    graph = next((value.graph for value in values if isinstance(value, Expression)), None)
    if graph is None:
        return FOLDED[op](*values)
    return Expression(graph, graph.function(op, *(graph.reference(value) for value in values)))


sqrt = partial(_apply, Op.SQRT)
sin = partial(_apply, Op.SIN)
cos = partial(_apply, Op.COS)
acos = partial(_apply, Op.ACOS)
atan2 = partial(_apply, Op.ATAN2)
"""(y, x) -> angle of the point (x, y)."""
absolute = partial(_apply, Op.ABS)
minimum = partial(_apply, Op.MIN)
maximum = partial(_apply, Op.MAX)
