"""A traced function as a straight line of instructions: plain data that can be stored, checked and translated.

Instruction k computes value k from earlier values.  Between graph and program three things happen: what no result needs
is dropped, divisions by one and the same number share its reciprocal, and a product that is used once, in a sum,
becomes a fused multiply-add.  Nothing else is reordered, so a program gives the same digits as a scalar and as a batch.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.compile.expressions.graph import ARITY, COMMUTES, Expression, Graph, Number, Op
from cutjoint.errors import CompileError

MAGIC = b"cutjoint program 1\n"
Indices = npt.NDArray[np.int32]


class ProgramError(CompileError):
    """Stored instructions are not a program: damaged, truncated, or not made by this version."""


@dataclass(frozen=True, eq=False)
class Program:
    """Straight-line code.

    Attributes:
        name: what it computes, for messages.
        arguments: name and length of each argument, in order.
        results: name and length of each result, in order.
        op: operation of every instruction, shape (k,).
        operands: earlier instructions it reads, shape (k, 3); -1 where unused; an input's position in the arguments.
        values: the constants, shape (k,); zero elsewhere.
        outputs: instruction behind every number of the results, in order.
    """

    name: str
    arguments: tuple[tuple[str, int], ...]
    results: tuple[tuple[str, int], ...]
    op: npt.NDArray[np.uint8]
    operands: Indices
    values: Array
    outputs: Indices

    def __post_init__(self) -> None:
        for part in (self.op, self.operands, self.values, self.outputs):
            part.setflags(write=False)

    def __reduce__(self) -> Any:
        return Program.from_bytes, (self.to_bytes(),)

    @property
    def n_in(self) -> int:
        """Numbers in all arguments together."""
        return sum(size for _, size in self.arguments)

    @property
    def n_out(self) -> int:
        """Numbers in all results together."""
        return sum(size for _, size in self.results)

    @property
    def operations(self) -> int:
        """Arithmetic instructions (a fused multiply-add is one)."""
        return int(np.count_nonzero((self.op != Op.CONST) & (self.op != Op.INPUT)))

    def result_slice(self, name: str) -> slice:
        """Where a result stands among the outputs."""
        return _slice(self.results, name)

    def argument_slice(self, name: str) -> slice:
        """Where an argument stands among the inputs."""
        return _slice(self.arguments, name)

    def counts(self) -> dict[str, int]:
        """How often each operation occurs."""
        found = Counter(Op(int(op)).name.lower() for op in self.op)
        return dict(found.most_common())

    # -- storage -----------------------------------------------------------------------------------------------------

    def to_bytes(self) -> bytes:
        """The program as bytes: a header line of JSON, then the arrays, then the digest of all of it."""
        header = json.dumps(
            {
                "name": self.name,
                "arguments": self.arguments,
                "results": self.results,
                "instructions": len(self.op),
                "outputs": len(self.outputs),
            }
        ).encode()
        body = b"".join(
            (
                MAGIC,
                header,
                b"\n",
                self.op.astype("<u1").tobytes(),
                self.operands.astype("<i4").tobytes(),
                self.values.astype("<f8").tobytes(),
                self.outputs.astype("<i4").tobytes(),
            )
        )
        return body + sha256(body).digest()

    @staticmethod
    def from_bytes(data: bytes) -> Program:
        """The program in `data`.

        Raises:
            ProgramError: wrong magic or digest, wrong length, or instructions that are not straight-line code.
        """
        if not data.startswith(MAGIC) or len(data) < len(MAGIC) + 34:
            raise ProgramError("not a stored program of this version")
        body, digest = data[:-32], data[-32:]
        if sha256(body).digest() != digest:
            raise ProgramError("the digest does not match: the file is damaged or truncated")
        head, _, rest = body[len(MAGIC) :].partition(b"\n")
        try:
            header = json.loads(head)
            k, m = int(header["instructions"]), int(header["outputs"])
            name = str(header["name"])
            arguments = tuple((str(a), int(n)) for a, n in header["arguments"])
            results = tuple((str(a), int(n)) for a, n in header["results"])
        except (ValueError, KeyError, TypeError) as error:
            raise ProgramError(f"the header cannot be read: {error}") from error
        if k < 0 or m < 0 or len(rest) != k * (1 + 12 + 8) + 4 * m:
            raise ProgramError("the length does not match the header")
        op = np.frombuffer(rest, "<u1", k)
        operands = np.frombuffer(rest, "<i4", 3 * k, offset=k).reshape(k, 3)
        values = np.frombuffer(rest, "<f8", k, offset=13 * k)
        outputs = np.frombuffer(rest, "<i4", m, offset=21 * k)
        program = Program(name, arguments, results, op, operands, values, outputs)
        program.validate()
        return program

    def validate(self) -> None:
        """Check that every instruction reads only earlier values and inputs that exist.

        Raises:
            ProgramError: it does not.
        """
        known = np.array([int(op) for op in Op])
        if not np.isin(self.op, known).all():
            raise ProgramError("unknown operation")
        if any(size < 0 for _, size in (*self.arguments, *self.results)) or len(self.outputs) != self.n_out:
            raise ProgramError("the results do not match the outputs")
        index = np.arange(len(self.op))
        arity = np.array([ARITY.get(Op(int(op)), 2) for op in self.op], dtype=int).reshape(-1)
        for column in range(3):
            used = arity > column
            operand = self.operands[:, column]
            if np.any(used & ((operand < 0) | (operand >= index))):
                raise ProgramError("an instruction reads a value that is not there yet")
        inputs = self.operands[self.op == Op.INPUT, 0]
        if np.any((inputs < 0) | (inputs >= self.n_in)):
            raise ProgramError("an input lies outside the arguments")
        if not np.isfinite(self.values).all():
            raise ProgramError("a constant is not finite")
        if np.any((self.outputs < 0) | (self.outputs >= len(self.op))):
            raise ProgramError("an output does not exist")


def _slice(table: tuple[tuple[str, int], ...], name: str) -> slice:
    start = 0
    for found, size in table:
        if found == name:
            return slice(start, start + size)
        start += size
    raise KeyError(name)


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
        count = ARITY.get(graph.op[node], 2)
        return (graph.a[node], graph.b[node])[:count]

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
        if op in COMMUTES:
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


def interpret(program: Program, inputs: Sequence[npt.ArrayLike]) -> list[Array]:
    """Run a program in plain NumPy: slow, but it needs no compiler.  `inputs` are numbers or arrays of one shape."""
    given = [np.asarray(x, dtype=np.float64) for x in inputs]
    done: list[Array] = []
    for code, (a, b, c), value in zip(program.op, program.operands, program.values, strict=True):
        op = Op(int(code))
        if op is Op.CONST:
            done.append(np.float64(value))  # type: ignore[arg-type]
        elif op is Op.INPUT:
            done.append(given[a])
        else:
            x = done[a]
            y = done[b] if b >= 0 else x
            z = done[c] if c >= 0 else x
            done.append(_INTERPRET[op](x, y, z))
    return [np.asarray(done[k]) for k in program.outputs]


_INTERPRET = {
    Op.ADD: lambda x, y, z: x + y,
    Op.SUB: lambda x, y, z: x - y,
    Op.MUL: lambda x, y, z: x * y,
    Op.DIV: lambda x, y, z: x / y,
    Op.SQRT: lambda x, y, z: np.sqrt(x),
    Op.SIN: lambda x, y, z: np.sin(x),
    Op.COS: lambda x, y, z: np.cos(x),
    Op.ATAN2: lambda x, y, z: np.arctan2(x, y),
    Op.ACOS: lambda x, y, z: np.arccos(x),
    Op.ABS: lambda x, y, z: np.abs(x),
    Op.MIN: lambda x, y, z: np.minimum(x, y),
    Op.MAX: lambda x, y, z: np.maximum(x, y),
    Op.NEG: lambda x, y, z: -x,
    Op.FMA: lambda x, y, z: x * y + z,
    Op.FMS: lambda x, y, z: x * y - z,
    Op.FNMA: lambda x, y, z: z - x * y,
}
