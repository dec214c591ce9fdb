"""Programs in plain NumPy: slow, but it needs no compiler, and says in one line each what the operations are."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.compile.expressions.operations import Op
from cutjoint.compile.expressions.program import Program

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
}
"""Operation -> what it computes."""


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
