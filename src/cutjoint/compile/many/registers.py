"""The equations of hardware on expressions, and its registers as places in the memory of a compiled loop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain
from typing import cast

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.expressions import functions
from cutjoint.compile.expressions.graph import Expression, Number
from cutjoint.compile.sources.law import objects
from cutjoint.simulation.hardware.equations import LoopEquations, Registers
from cutjoint.simulation.hardware.fitted import Fitted


def entries(values: Sequence[Number]) -> Array:
    """Expressions as an array, for equations that are written for arrays of floats."""
    return cast(Array, objects(values))


def numbers(values: Array) -> list[Number]:
    """The other way."""
    return cast(list[Number], values.tolist())


def _entrywise(function: Callable[..., Number], arguments: int) -> Callable[..., Array]:
    made = np.frompyfunc(function, arguments, 1)
    return lambda *values: np.asarray(made(*values), dtype=object)


class Expressions:
    """The functions that the equations need, on arrays of expressions."""

    nearest = staticmethod(_entrywise(functions.nearest, 1))
    minimum = staticmethod(_entrywise(functions.minimum, 2))
    maximum = staticmethod(_entrywise(functions.maximum, 2))
    where_less = staticmethod(_entrywise(functions.where_less, 4))


def equations(fitted: Fitted) -> LoopEquations:
    """The equations of some hardware, on expressions."""
    return LoopEquations(fitted, Expressions())


def register_count(fitted: Fitted) -> int:
    """Numbers that the registers of some hardware hold."""
    places = (fitted.ticks.seen_after + 1) * (1 if fitted.differences else 2) + fitted.ticks.acts_after + 1
    return fitted.n * (places + 3)


def registers(symbols: Sequence[Expression], fitted: Fitted) -> Registers:
    """Symbols as registers, in the order of `flat`."""
    rows = [entries(symbols[k : k + fitted.n]) for k in range(0, len(symbols), fitted.n)]
    seen = fitted.ticks.seen_after + 1
    readings, rest = rows[:seen], rows[seen:]
    speeds, rest = ([], rest) if fitted.differences else (rest[:seen], rest[seen:])
    return Registers(tuple(readings), tuple(speeds), rest[0], rest[1], tuple(rest[2:-1]), rest[-1])


def flat(memory: Registers) -> list[Number]:
    """All numbers of registers."""
    rows = (*memory.readings, *memory.speeds, memory.last, memory.speed, *memory.commands, memory.held)
    return list(chain.from_iterable(numbers(row) for row in rows))
