"""Scalar expressions as a graph in which every sub-expression exists once.

A model that is evaluated on `Expression`s (`cutjoint.compile.expressions.graph`) instead of floats leaves its
arithmetic behind as a graph.  Nodes are found again by what they compute (hash consing), so common sub-expressions
merge while the model is traced; constants are folded, signs are pulled outwards (so a - b and b - a share a node), and
sums inside sine and cosine are expanded when they consist of inverse trigonometric functions (cos(acos x) is x).  What
is left is turned into a straight line by `cutjoint.compile.expressions.straight_line` and differentiated by
`cutjoint.compile.expressions.derivative`.

A reference is a signed number: +k is the value of node k, -k its negative; node numbers start at 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping

from cutjoint.compile.expressions.operations import Op
from cutjoint.errors import InputError

FOLDED: Mapping[Op, Callable[..., float]] = {
    Op.SQRT: math.sqrt,
    Op.SIN: math.sin,
    Op.COS: math.cos,
    Op.ATAN2: math.atan2,
    Op.ACOS: math.acos,
    Op.ABS: abs,
    Op.MIN: min,
    Op.MAX: max,
    Op.FLOOR: lambda x: float(math.floor(x)),
    Op.NEAREST: lambda x: float(round(x)),
    Op.LESS: lambda x, y: 1.0 if x < y else 0.0,
    Op.AT_MOST: lambda x, y: 1.0 if x <= y else 0.0,
    Op.PICK: lambda test, x, y: x if test else y,
}
"""The functions on plain numbers."""


class Nodes:
    """The nodes: parallel lists of operation, three operands (references, 0: none) and, for constants, the value."""

    def __init__(self) -> None:
        self.op: list[Op] = [Op.CONST]
        self.a: list[int] = [0]
        self.b: list[int] = [0]
        self.c: list[int] = [0]
        self.value: list[float] = [math.nan]
        self.inputs: list[int] = []
        self._known: dict[tuple[int, int, int, int] | float, int] = {}
        self._zero = self.constant(0.0)
        self._one = self.constant(1.0)

    # -- making nodes ------------------------------------------------------------------------------------------------

    def _new(self, op: Op, a: int, b: int, c: int, value: float = math.nan) -> int:
        self.op.append(op)
        self.a.append(a)
        self.b.append(b)
        self.c.append(c)
        self.value.append(value)
        return len(self.op) - 1

    def _node(self, op: Op, a: int, b: int = 0, c: int = 0) -> int:
        key = (int(op), a, b, c)
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = self._new(op, a, b, c)
        return found

    def input(self) -> int:
        """A new argument of the function that is being traced."""
        node = self._new(Op.INPUT, len(self.inputs), 0, 0)
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
            node = self._known[size] = self._new(Op.CONST, 0, 0, 0, size)
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

    def function(self, op: Op, *operands: int) -> int:
        """A function of references: one of `FOLDED`."""
        if op in (Op.SIN, Op.COS):
            return self.sine_cosine(operands[0])[0 if op is Op.SIN else 1]
        known = [number for x in operands if (number := self.constant_of(x)) is not None]
        if len(known) == len(operands):
            return self.constant(FOLDED[op](*known))
        x = operands[0]
        if op is Op.ABS:
            return abs(x) if self.op[abs(x)] in (Op.ABS, Op.SQRT) else self._node(op, abs(x))
        if op in (Op.MIN, Op.MAX):
            y = operands[1]
            return x if x == y else self._node(op, *((x, y) if abs(x) < abs(y) else (y, x)))
        if op is Op.NEAREST:
            return self._node(op, x) if x > 0 else -self._node(op, -x)
        if op is Op.PICK:
            return self.pick(*operands)
        return self._node(op, *operands)

    def pick(self, test: int, x: int, y: int) -> int:
        """Reference to x where `test` is not 0, else to y."""
        known = self.constant_of(test)
        if known is not None:
            return x if known else y
        if x == y:
            return x
        if x < 0 and y < 0:
            return -self._node(Op.PICK, abs(test), -x, -y)
        return self._node(Op.PICK, abs(test), x, y)

    def sine_cosine(self, x: int) -> tuple[int, int]:
        """References to sine and cosine of one."""
        if x < 0:
            sine, cosine = self.sine_cosine(-x)
            return -sine, cosine
        p = self.constant_of(x)
        if p is not None:
            return self.constant(_clean(math.sin(p))), self.constant(_clean(math.cos(p)))
        op, a, b = self.op[x], self.a[x], self.b[x]
        if op is Op.ACOS:
            return self.function(Op.SQRT, self.mul(self.add(self._one, -a), self.add(self._one, a))), a
        if op is Op.ATAN2:
            radius = self.function(Op.SQRT, self.add(self.mul(a, a), self.mul(b, b)))
            return self.div(a, radius), self.div(b, radius)
        if op in (Op.ADD, Op.SUB) and self._is_inverse(a) and self._is_inverse(b):
            sa, ca = self.sine_cosine(a)
            sb, cb = self.sine_cosine(b if op is Op.ADD else -b)
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

    def operands(self, node: int) -> tuple[int, ...]:
        """The references that a node is computed from."""
        return (self.a[node], self.b[node], self.c[node])[: self.op[node].arity]

    def ancestors(self, references: Iterable[int]) -> list[int]:
        """All nodes that `references` depend on, operands before results."""
        wanted: set[int] = set()
        stack = [abs(ref) for ref in references]
        while stack:
            node = stack.pop()
            if node in wanted:
                continue
            wanted.add(node)
            stack += (abs(x) for x in self.operands(node))
        return sorted(wanted)


def _clean(value: float) -> float:
    """Sine or cosine of a constant without the rounding of pi in it."""
    nearest = round(value)
    return float(nearest) if abs(value - nearest) < 1e-15 else value
