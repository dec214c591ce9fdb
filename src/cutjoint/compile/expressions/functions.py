"""Elementary functions of expressions and floats alike.

This module is the namespace `fn` that the equations of `cutjoint.papers` ask for, as the modules math and numpy are.
"""

from __future__ import annotations

from functools import partial

from cutjoint.compile.expressions.graph import Expression, Number
from cutjoint.compile.expressions.nodes import FOLDED
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
floor = partial(_apply, Op.FLOOR)
nearest = partial(_apply, Op.NEAREST)
"""The nearest whole number; of two that are as near, the even one (as `numpy.rint`)."""
less = partial(_apply, Op.LESS)
"""(a, b) -> 1 where a < b, else 0."""
at_most = partial(_apply, Op.AT_MOST)
"""(a, b) -> 1 where a <= b, else 0."""
pick = partial(_apply, Op.PICK)
"""(test, x, y) -> x where `test` is not 0, else y; the one that is not picked may be anything."""


def where_less(a: Number, b: Number, x: Number, y: Number) -> Number:
    """x where a < b, else y."""
    return pick(less(a, b), x, y)
