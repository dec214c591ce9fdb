"""A traced function as a straight line of instructions: plain data that can be stored, checked and translated.

Instruction k computes value k from earlier values.  `cutjoint.compile.expressions.straight_line` makes programs, back
ends machine code of them; `interpret` runs them in plain NumPy: slow, but it needs no compiler.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.compile.expressions.operations import Op
from cutjoint.errors import CompileError
from cutjoint.reprs import line

MAGIC = b"cutjoint program 2\n"
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

    __repr__ = line("name", "arguments", "results")

    def __post_init__(self) -> None:
        for part in (self.op, self.operands, self.values, self.outputs):
            part.setflags(write=False)

    def __reduce__(self) -> tuple[object, ...]:
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
        arity = np.array([Op(code).arity for code in self.op.tolist()], dtype=int)
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


MEANING: Mapping[Op, Callable[..., Array]] = {
    Op.ADD: lambda x, y: x + y,
    Op.SUB: lambda x, y: x - y,
    Op.MUL: lambda x, y: x * y,
    Op.DIV: lambda x, y: x / y,
    Op.SQRT: np.sqrt,
    Op.SIN: np.sin,
    Op.COS: np.cos,
    Op.ATAN2: np.arctan2,
    Op.ACOS: np.arccos,
    Op.ABS: np.abs,
    Op.MIN: np.minimum,
    Op.MAX: np.maximum,
    Op.NEG: lambda x: -x,
    Op.FMA: lambda x, y, z: x * y + z,
    Op.FMS: lambda x, y, z: x * y - z,
    Op.FNMA: lambda x, y, z: z - x * y,
    Op.FLOOR: np.floor,
    Op.NEAREST: np.rint,
    Op.LESS: lambda x, y: np.where(x < y, 1.0, 0.0),
    Op.AT_MOST: lambda x, y: np.where(x <= y, 1.0, 0.0),
    Op.PICK: lambda x, y, z: np.choose(np.equal(x, 0.0), (y, z)),
}
"""Operation -> what it computes, in NumPy."""


def interpret(program: Program, inputs: Sequence[npt.ArrayLike]) -> list[Array]:
    """Run a program.  `inputs` are numbers or arrays of one shape."""
    given = [np.asarray(x, dtype=np.float64) for x in inputs]
    done: list[Array | np.float64] = []
    rows = zip(program.op.tolist(), program.operands.tolist(), program.values.tolist(), strict=True)
    for code, operands, value in rows:
        match op := Op(code):
            case Op.CONST:
                done.append(np.float64(value))
            case Op.INPUT:
                done.append(given[operands[0]])
            case _:
                done.append(MEANING[op](*(done[k] for k in operands[: op.arity])))
    return [np.asarray(done[k]) for k in program.outputs]
