"""Expressions: values in a graph of `cutjoint.compile.expressions.nodes` that are calculated with like floats."""

from __future__ import annotations

from typing import TypeAlias, Union

from cutjoint.compile.expressions.nodes import Nodes
from cutjoint.compile.expressions.operations import Op
from cutjoint.errors import InputError

Number: TypeAlias = Union["Expression", float]


class Graph(Nodes):
    """A graph, and the expressions that live in it."""

    def symbols(self, count: int) -> list[Expression]:
        """`count` new arguments."""
        return [Expression(self, self.input()) for _ in range(count)]

    def reference(self, value: Number) -> int:
        """Reference of an expression of this graph or of a plain number."""
        return value.ref if isinstance(value, Expression) else self.constant(float(value))


# long: Python's operators, a line each
class Expression:
    """A value in a graph that can be calculated with like a float.

    NumPy's sin, cos, sqrt and arccos find the methods where an array of objects holds expressions.
    """

    __array_ufunc__ = None
    __slots__ = ("graph", "ref")

    def __init__(self, graph: Graph, ref: int) -> None:
        self.graph, self.ref = graph, ref

    def __repr__(self) -> str:
        value = self.graph.constant_of(self.ref)
        return f"Expression({value!r})" if value is not None else f"Expression(#{self.ref})"

    def _make(self, ref: int) -> Expression:
        return Expression(self.graph, ref)

    def _apply(self, op: Op) -> Expression:
        return self._make(self.graph.function(op, self.ref))

    def __add__(self, other: Number) -> Expression:
        return self._make(self.graph.add(self.ref, self.graph.reference(other)))

    __radd__ = __add__

    def __sub__(self, other: Number) -> Expression:
        return self._make(self.graph.add(self.ref, -self.graph.reference(other)))

    def __rsub__(self, other: Number) -> Expression:
        return self._make(self.graph.add(self.graph.reference(other), -self.ref))

    def __mul__(self, other: Number) -> Expression:
        return self._make(self.graph.mul(self.ref, self.graph.reference(other)))

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> Expression:
        return self._make(self.graph.div(self.ref, self.graph.reference(other)))

    def __rtruediv__(self, other: Number) -> Expression:
        return self._make(self.graph.div(self.graph.reference(other), self.ref))

    def __pow__(self, power: int) -> Expression:
        if power == 2:
            return self * self
        raise InputError(f"a traced model may only square, found the power {power!r}")

    def __neg__(self) -> Expression:
        return self._make(-self.ref)

    def __abs__(self) -> Expression:
        return self._apply(Op.ABS)

    def _compared(self, other: object, op: Op) -> bool:
        if not isinstance(other, Expression | float | int):
            raise InputError(f"a traced model may compare numbers only, found {other!r}")
        found = self.graph.constant_of(self.graph.function(op, self.ref, self.graph.reference(other)))
        if found is None:
            raise InputError("a traced model may not compare values: there are no values while tracing")
        return found != 0.0

    def __lt__(self, other: Number) -> bool:
        return self._compared(other, Op.LESS)

    def __le__(self, other: Number) -> bool:
        return self._compared(other, Op.AT_MOST)

    def __gt__(self, other: Number) -> bool:
        return not self._compared(other, Op.AT_MOST)

    def __ge__(self, other: Number) -> bool:
        return not self._compared(other, Op.LESS)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Expression) and self.ref == other.ref:
            return True
        return self._compared(other, Op.AT_MOST) and not self._compared(other, Op.LESS)

    __hash__ = object.__hash__

    def __bool__(self) -> bool:
        if self.constant is not None:
            return self.constant != 0.0
        raise InputError("a traced model may not branch on a value: there is no value while tracing")

    def sin(self) -> Expression:
        return self._apply(Op.SIN)

    def cos(self) -> Expression:
        return self._apply(Op.COS)

    def sqrt(self) -> Expression:
        return self._apply(Op.SQRT)

    def arccos(self) -> Expression:
        return self._apply(Op.ACOS)

    @property
    def constant(self) -> float | None:
        """The number, if it is one."""
        return self.graph.constant_of(self.ref)
