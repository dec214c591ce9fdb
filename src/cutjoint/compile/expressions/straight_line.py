"""From the graph to a program: the straight line of instructions that computes some of its expressions.

Three things happen on the way: what no result needs is dropped, divisions by one and the same number share its
reciprocal, and a product that is used once, in a sum, becomes a fused multiply-add.  Nothing else is reordered, so a
program gives the same digits as a scalar and as a batch.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.expressions.operations import Op
from cutjoint.compile.expressions.program import Program


def assemble(
    graph: Graph,
    name: str,
    arguments: Mapping[str, Sequence[Expression]],
    results: Mapping[str, Sequence[Number]],
    *,
    fused: bool = True,
) -> Program:
    """The straight line that computes `results` from `arguments`.

    Args:
        graph: where the expressions live; reciprocals are added to it.
        name: for messages.
        arguments: name -> inputs of the graph.
        results: name -> expressions or numbers.
        fused: whether products may be fused into sums (off where the processor has no such instruction).
    """
    outputs = [graph.reference(value) for values in results.values() for value in values]
    position = {abs(x.ref): k for k, x in enumerate(x for xs in arguments.values() for x in xs)}
    line = _Line(graph, position, fused)
    places = line.build(outputs)
    count = len(line.op)
    return Program(
        name,
        tuple((key, len(xs)) for key, xs in arguments.items()),
        tuple((key, len(values)) for key, values in results.items()),
        np.array(line.op, dtype=np.uint8),
        np.array(line.operands, dtype=np.int32).reshape(count, 3),
        np.array(line.values, dtype=np.float64),
        np.array(places, dtype=np.int32),
    )


class _Line:
    """Walks the graph from its outputs and writes instructions, operands first."""

    def __init__(self, graph: Graph, position: dict[int, int], fused: bool) -> None:
        self.graph, self.position, self.fused = graph, position, fused
        self.op: list[int] = []
        self.operands: list[tuple[int, int, int]] = []
        self.values: list[float] = []
        self._place: dict[int, int] = {}
        self._negative: dict[int, int] = {}
        self._uses: Counter[int] = Counter()
        self._shared: dict[int, int] = {}

    def build(self, outputs: Sequence[int]) -> list[int]:
        graph = self.graph
        nodes = graph.ancestors(outputs)
        quotients = [node for node in nodes if graph.op[node] is Op.DIV]
        often = Counter(graph.b[node] for node in quotients)
        self._shared = {
            node: graph.div(graph.constant(1.0), graph.b[node]) for node in quotients if often[graph.b[node]] > 1
        }
        live = self._live(outputs)
        for node in live:
            self._uses.update(abs(x) for x in self._reads(node))
        self._uses.update(abs(x) for x in outputs)
        depth: dict[int, int] = {}
        for node in live:
            depth[node] = 1 + max((depth[abs(x)] for x in self._reads(node)), default=0)
        for output in outputs:
            self._write(abs(output), depth)
        return [self._signed(output) for output in outputs]

    def _reads(self, node: int) -> tuple[int, ...]:
        """Operand references of a node, with shared reciprocals in place of quotients."""
        graph = self.graph
        inverse = self._shared.get(node)
        if inverse is not None and abs(inverse) != node:
            return (graph.a[node], inverse)
        return graph.operands(node)

    def _live(self, outputs: Sequence[int]) -> list[int]:
        done: set[int] = set()
        order: list[int] = []
        stack = [(abs(output), False) for output in reversed(outputs)]
        while stack:
            node, ready = stack.pop()
            if ready:
                order.append(node)
            elif node not in done:
                done.add(node)
                stack.append((node, True))
                stack.extend((abs(x), False) for x in self._reads(node))
        return order

    def _fusable(self, ref: int) -> bool:
        node = abs(ref)
        is_product = self.graph.op[node] is Op.MUL or (node in self._shared and abs(self._shared[node]) != node)
        return self.fused and is_product and self._uses[node] == 1 and node not in self._place

    def _parts(self, node: int) -> tuple[Op, tuple[int, ...]]:
        """Operation and operands of a node as an instruction."""
        graph = self.graph
        op, reads = graph.op[node], self._reads(node)
        if node in self._shared and abs(self._shared[node]) != node:
            return Op.MUL, reads
        if op in (Op.ADD, Op.SUB):
            a, b = reads
            if self._fusable(b):
                return (Op.FMA if op is Op.ADD else Op.FNMA), (*self._reads(abs(b)), a)
            if self._fusable(a):
                return (Op.FMA if op is Op.ADD else Op.FMS), (*self._reads(abs(a)), b)
        return op, reads

    def _write(self, root: int, depth: dict[int, int]) -> None:
        stack = [(root, False)]
        while stack:
            node, ready = stack.pop()
            if node in self._place:
                continue
            op, reads = self._parts(node)
            if not ready:
                stack.append((node, True))
                deepest_last = sorted({abs(x) for x in reads}, key=lambda x: depth[x])
                stack.extend((x, False) for x in deepest_last if x not in self._place)
                continue
            self._place[node] = self._emit(node, op, reads)

    def _emit(self, node: int, op: Op, reads: tuple[int, ...]) -> int:
        if op is Op.CONST:
            return self._push(op, (-1, -1, -1), self.graph.value[node])
        if op is Op.INPUT:
            return self._push(op, (self.position[node], -1, -1))
        places = [self._signed(x) for x in reads]
        if op.commutes:
            places.sort()
        return self._push(op, (*places, *(-1,) * (3 - len(places))))

    def _signed(self, ref: int) -> int:
        place = self._place[abs(ref)]
        if ref > 0:
            return place
        if place not in self._negative:
            if self.op[place] == Op.CONST:
                self._negative[place] = self._push(Op.CONST, (-1, -1, -1), -self.values[place])
            else:
                self._negative[place] = self._push(Op.NEG, (place, -1, -1))
        return self._negative[place]

    def _push(self, op: Op, operands: tuple[int, ...], value: float = 0.0) -> int:
        self.op.append(int(op))
        self.operands.append((operands[0], operands[1], operands[2]))
        self.values.append(value)
        return len(self.op) - 1
