"""Scalar expressions as a graph in which every sub-expression exists once.

A model that is evaluated on `Expression`s instead of floats leaves its arithmetic behind as a graph.  Nodes are found
again by what they compute (hash consing), so common sub-expressions merge while the model is traced; constants are
folded, signs are pulled outwards (so a - b and b - a share a node), and sums inside sine and cosine are expanded when
they consist of inverse trigonometric functions (cos(acos x) is x).  What is left is turned into a straight line by
`cutjoint.compile.expressions.program` and differentiated by `cutjoint.compile.expressions.derivative`.

A reference is a signed number: +k is the value of node k, -k its negative; node numbers start at 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from enum import IntEnum
from typing import Any, TypeAlias, Union

from cutjoint.errors import InputError


class Op(IntEnum):
    """What a node computes from its operands a, b, c.  The numbers are part of the file format of the cache."""

    CONST = 1
    INPUT = 2
    ADD = 3
    SUB = 4
    MUL = 5
    DIV = 6
    SQRT = 7
    SIN = 8
    COS = 9
    ATAN2 = 10
    ACOS = 11
    ABS = 12
    MIN = 13
    MAX = 14
    NEG = 15
    FMA = 16
    """a b + c; made by the program, not by the tracer."""
    FMS = 17
    """a b - c"""
    FNMA = 18
    """c - a b"""


ARITY = {
    Op.CONST: 0,
    Op.INPUT: 0,
    Op.SQRT: 1,
    Op.SIN: 1,
    Op.COS: 1,
    Op.ACOS: 1,
    Op.ABS: 1,
    Op.NEG: 1,
    Op.FMA: 3,
    Op.FMS: 3,
    Op.FNMA: 3,
}
"""Number of operands; two where nothing is said."""

COMMUTES = (Op.ADD, Op.MUL, Op.MIN, Op.MAX)

Number: TypeAlias = Union["Expression", float]


class Graph:
    """The nodes: parallel lists of operation, first and second operand (references) and, for constants, the value."""

    def __init__(self) -> None:
        self.op: list[Op] = [Op.CONST]
        self.a: list[int] = [0]
        self.b: list[int] = [0]
        self.value: list[float] = [math.nan]
        self.inputs: list[int] = []
        self._known: dict[tuple[int, int, int] | float, int] = {}
        self._zero = self.constant(0.0)
        self._one = self.constant(1.0)

    # -- making nodes ------------------------------------------------------------------------------------------------

    def _new(self, op: Op, a: int, b: int, value: float = math.nan) -> int:
        self.op.append(op)
        self.a.append(a)
        self.b.append(b)
        self.value.append(value)
        return len(self.op) - 1

    def _node(self, op: Op, a: int, b: int = 0) -> int:
        key = (int(op), a, b)
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = self._new(op, a, b)
        return found

    def input(self) -> int:
        """A new argument of the function that is being traced."""
        node = self._new(Op.INPUT, len(self.inputs), 0)
        self.inputs.append(node)
        return node

    def constant(self, value: float) -> int:
        """Reference to a constant.

        Raises:
            InputError: the value is not finite.
        """
        value = float(value)
        if not math.isfinite(value):
            raise InputError(f"a traced model may only hold finite constants, found {value!r}")
        size = abs(value)
        node = self._known.get(size)
        if node is None:
            node = self._known[size] = self._new(Op.CONST, 0, 0, size)
        return -node if value < 0.0 else node

    def constant_of(self, x: int) -> float | None:
        """The number behind a reference, or None where it is not constant."""
        if self.op[abs(x)] is not Op.CONST:
            return None
        value = self.value[abs(x)]
        return value if x > 0 else -value

    # -- arithmetic on references ------------------------------------------------------------------------------------

    def add(self, x: int, y: int) -> int:
        p, q = self.constant_of(x), self.constant_of(y)
        if p is not None and q is not None:
            return self.constant(p + q)
        if p == 0.0:
            return y
        if q == 0.0:
            return x
        if x == -y:
            return self._zero
        if abs(y) < abs(x):
            x, y = y, x
        sign = 1 if x > 0 else -1
        x, y = sign * x, sign * y
        return sign * (self._node(Op.ADD, x, y) if y > 0 else self._node(Op.SUB, x, -y))

    def mul(self, x: int, y: int) -> int:
        p, q = self.constant_of(x), self.constant_of(y)
        if p is not None and q is not None:
            return self.constant(p * q)
        if q is not None:
            x, y, p, q = y, x, q, p
        if p is not None:
            if p == 0.0:
                return self._zero
            if abs(p) == 1.0:
                return y if p > 0 else -y
            if self.op[abs(y)] is Op.MUL:
                inner = self.constant_of(self.a[abs(y)])
                if inner is not None:
                    rest = self.b[abs(y)]
                    return self.mul(self.constant(p * inner), rest if y > 0 else -rest)
        sign = 1 if (x > 0) == (y > 0) else -1
        x, y = abs(x), abs(y)
        if p is None and y < x:
            x, y = y, x
        return sign * self._node(Op.MUL, x, y)

    def div(self, x: int, y: int) -> int:
        p, q = self.constant_of(x), self.constant_of(y)
        if q is not None:
            if q == 0.0:
                raise InputError("a traced model divides by the constant zero")
            return self.mul(x, self.constant(1.0 / q)) if p is None else self.constant(p / q)
        if p == 0.0:
            return self._zero
        if abs(x) == abs(y):
            return self._one if x == y else -self._one
        sign = 1 if (x > 0) == (y > 0) else -1
        return sign * self._node(Op.DIV, abs(x), abs(y))

    def sqrt(self, x: int) -> int:
        p = self.constant_of(x)
        return self._node(Op.SQRT, x) if p is None else self.constant(math.sqrt(p))

    def absolute(self, x: int) -> int:
        return abs(x) if self.op[abs(x)] in (Op.CONST, Op.ABS, Op.SQRT) else self._node(Op.ABS, abs(x))

    def minimum(self, x: int, y: int) -> int:
        return self._extreme(Op.MIN, min, x, y)

    def maximum(self, x: int, y: int) -> int:
        return self._extreme(Op.MAX, max, x, y)

    def _extreme(self, op: Op, fold: Callable[[float, float], float], x: int, y: int) -> int:
        p, q = self.constant_of(x), self.constant_of(y)
        if p is not None and q is not None:
            return self.constant(fold(p, q))
        if x == y:
            return x
        return self._node(op, *((x, y) if abs(x) < abs(y) else (y, x)))

    def atan2(self, y: int, x: int) -> int:
        p, q = self.constant_of(y), self.constant_of(x)
        if p is not None and q is not None:
            return self.constant(math.atan2(p, q))
        return self._node(Op.ATAN2, y, x)

    def acos(self, x: int) -> int:
        p = self.constant_of(x)
        return self._node(Op.ACOS, x) if p is None else self.constant(math.acos(p))

    def sin(self, x: int) -> int:
        return self._sin_cos(x)[0]

    def cos(self, x: int) -> int:
        return self._sin_cos(x)[1]

    def _sin_cos(self, x: int) -> tuple[int, int]:
        """References to sine and cosine."""
        if x < 0:
            sine, cosine = self._sin_cos(-x)
            return -sine, cosine
        p = self.constant_of(x)
        if p is not None:
            return self.constant(_clean(math.sin(p))), self.constant(_clean(math.cos(p)))
        op, a, b = self.op[x], self.a[x], self.b[x]
        if op is Op.ACOS:
            return self.sqrt(self.mul(self.add(self._one, -a), self.add(self._one, a))), a
        if op is Op.ATAN2:
            radius = self.sqrt(self.add(self.mul(a, a), self.mul(b, b)))
            return self.div(a, radius), self.div(b, radius)
        if op in (Op.ADD, Op.SUB) and self._is_inverse(a) and self._is_inverse(b):
            sa, ca = self._sin_cos(a)
            sb, cb = self._sin_cos(b if op is Op.ADD else -b)
            return (
                self.add(self.mul(sa, cb), self.mul(ca, sb)),
                self.add(self.mul(ca, cb), -self.mul(sa, sb)),
            )
        return self._node(Op.SIN, x), self._node(Op.COS, x)

    def _is_inverse(self, x: int) -> bool:
        """Whether sine and cosine of a reference need no trigonometric function."""
        op = self.op[abs(x)]
        if op in (Op.ADD, Op.SUB):
            return self._is_inverse(self.a[abs(x)]) and self._is_inverse(self.b[abs(x)])
        return op in (Op.ACOS, Op.ATAN2, Op.CONST)

    # -- views -------------------------------------------------------------------------------------------------------

    def symbols(self, count: int) -> list[Expression]:
        """`count` new arguments."""
        return [Expression(self, self.input()) for _ in range(count)]

    def reference(self, value: Number) -> int:
        """Reference of an expression of this graph or of a plain number."""
        return value.ref if isinstance(value, Expression) else self.constant(float(value))

    def ancestors(self, references: Iterable[int]) -> list[int]:
        """All nodes that `references` depend on, operands before results."""
        wanted: set[int] = set()
        stack = [abs(ref) for ref in references]
        while stack:
            node = stack.pop()
            if node in wanted:
                continue
            wanted.add(node)
            count = ARITY.get(self.op[node], 2)
            if count > 0:
                stack.append(abs(self.a[node]))
            if count > 1:
                stack.append(abs(self.b[node]))
        return sorted(wanted)


def _clean(value: float) -> float:
    """Sine or cosine of a constant without the rounding of pi in it."""
    nearest = round(value)
    return float(nearest) if abs(value - nearest) < 1e-15 else value


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
        return self._make(self.graph.absolute(self.ref))

    def __gt__(self, other: Number) -> bool:
        difference = (self - other).constant
        if difference is None:
            raise InputError("a traced model may not compare values: there are no values while tracing")
        return difference > 0.0

    def __lt__(self, other: Number) -> bool:
        return -self > -other

    def __bool__(self) -> bool:
        if self.constant is not None:
            return self.constant != 0.0
        raise InputError("a traced model may not branch on a value: there is no value while tracing")

    def sin(self) -> Expression:
        """Sine."""
        return self._make(self.graph.sin(self.ref))

    def cos(self) -> Expression:
        """Cosine."""
        return self._make(self.graph.cos(self.ref))

    def sqrt(self) -> Expression:
        """Square root."""
        return self._make(self.graph.sqrt(self.ref))

    def acos(self) -> Expression:
        """Inverse cosine."""
        return self._make(self.graph.acos(self.ref))

    @property
    def constant(self) -> float | None:
        """The number, if it is one."""
        return self.graph.constant_of(self.ref)


def is_zero(value: Number) -> bool:
    """Whether a value is zero whatever the inputs are."""
    return (value.constant if isinstance(value, Expression) else value) == 0.0


def absolute(x: Number) -> Number:
    """|x|."""
    return Expression(x.graph, x.graph.absolute(x.ref)) if isinstance(x, Expression) else abs(x)


def minimum(x: Number, y: Number) -> Number:
    """The smaller one."""
    graph = _graph(x, y)
    if graph is None:
        return min(x, y, key=float)  # type: ignore[arg-type]
    return Expression(graph, graph.minimum(graph.reference(x), graph.reference(y)))


def maximum(x: Number, y: Number) -> Number:
    """The larger one."""
    graph = _graph(x, y)
    if graph is None:
        return max(x, y, key=float)  # type: ignore[arg-type]
    return Expression(graph, graph.maximum(graph.reference(x), graph.reference(y)))


def _graph(*values: Number) -> Graph | None:
    return next((value.graph for value in values if isinstance(value, Expression)), None)


class Functions:
    """The elementary functions on expressions and floats alike."""

    @staticmethod
    def sqrt(x: Number) -> Number:
        """Square root."""
        return x.sqrt() if isinstance(x, Expression) else math.sqrt(x)

    @staticmethod
    def sin(x: Number) -> Number:
        """Sine."""
        return x.sin() if isinstance(x, Expression) else math.sin(x)

    @staticmethod
    def cos(x: Number) -> Number:
        """Cosine."""
        return x.cos() if isinstance(x, Expression) else math.cos(x)

    @staticmethod
    def acos(x: Number) -> Number:
        """Inverse cosine."""
        return x.acos() if isinstance(x, Expression) else math.acos(x)

    @staticmethod
    def atan2(y: Number, x: Number) -> Number:
        """Angle of the point (x, y)."""
        graph = _graph(x, y)
        if graph is None:
            return math.atan2(y, x)  # type: ignore[arg-type]
        return Expression(graph, graph.atan2(graph.reference(y), graph.reference(x)))


FUNCTIONS: Any = Functions
"""The namespace that the papers' equations ask for."""
