"""Exact derivatives of traced expressions, by forward accumulation on the graph.

A tangent is pushed through every node along with its value (chain rule), so the derivative is again a graph: it shares
all sub-expressions with the value and is compiled with it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.expressions.operations import Op

STEPS = (Op.FLOOR, Op.NEAREST, Op.LESS, Op.AT_MOST)
"""What is constant between its jumps; the derivative does not see these."""


def tangent(graph: Graph, outputs: Sequence[Number], seed: Mapping[int, Number]) -> list[Expression]:
    """Directional derivative of `outputs`.

    Args:
        graph: where all expressions live.
        outputs: the values to differentiate.
        seed: node of an input -> its rate.  Rates may themselves be expressions; other inputs stand still.

    Returns:
        One expression an output.
    """
    zero = graph.constant(0.0)
    references = [graph.reference(output) for output in outputs]
    rate: dict[int, int] = {node: graph.reference(value) for node, value in seed.items()}

    def of(ref: int) -> int:
        found = rate.get(abs(ref), zero)
        return found if ref > 0 else -found

    for node in graph.ancestors(references):
        if node in seed:
            continue
        op, a, b = graph.op[node], graph.a[node], graph.b[node]
        da = of(a) if op.arity > 0 else zero
        db = of(b) if op.arity > 1 else zero
        if op is Op.PICK:
            rate[node] = graph.pick(a, db, of(graph.c[node]))
        elif op not in STEPS and (da != zero or db != zero):
            rate[node] = _rule(graph, op, node, a, b, da, db)
    return [Expression(graph, of(ref)) for ref in references]


def _rule(g: Graph, op: Op, node: int, a: int, b: int, da: int, db: int) -> int:
    """Tangent of one node."""
    match op:
        case Op.ADD:
            return g.add(da, db)
        case Op.SUB:
            return g.add(da, -db)
        case Op.MUL:
            return g.add(g.mul(da, b), g.mul(a, db))
        case Op.DIV:
            return g.div(g.add(da, -g.mul(node, db)), b)
        case Op.SQRT:
            return g.div(g.mul(g.constant(0.5), da), node)
        case Op.SIN:
            return g.mul(g.function(Op.COS, a), da)
        case Op.COS:
            return -g.mul(g.function(Op.SIN, a), da)
        case Op.ATAN2:
            square = g.add(g.mul(a, a), g.mul(b, b))
            return g.div(g.add(g.mul(b, da), -g.mul(a, db)), square)
        case Op.ACOS:
            one = g.constant(1.0)
            return -g.div(da, g.function(Op.SQRT, g.mul(g.add(one, -a), g.add(one, a))))
        case Op.ABS:
            return g.pick(g.function(Op.LESS, a, g.constant(0.0)), -da, da)
        case Op.MIN:
            return g.pick(g.function(Op.LESS, a, b), da, db)
        case Op.MAX:
            return g.pick(g.function(Op.LESS, a, b), db, da)
    raise AssertionError(op)
