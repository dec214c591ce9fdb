"""Functions of forms, and whole straight-line programs over them.

What sine and the like add to the rest is in the table of `cutjoint.workspace.certified.forms`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.expressions.operations import Op
from cutjoint.compile.expressions.program import Program
from cutjoint.errors import InputError
from cutjoint.workspace.certified.forms import (
    EPS,
    TINY,
    UP,
    Form,
    add,
    constant,
    cubes_of,
    form,
    multiply,
    negative,
    squares_of,
    subtract,
)


class Slopes(NamedTuple):
    """Of a function in the middles of forms: its value and its derivatives over factorials.

    Attributes:
        value, first, second, third: these.
        third_bound, fourth_bound: bounds of the size of the third and the fourth over all of the forms.
        rounding: bound of the rounding of `value`.
    """

    value: Array
    first: Array
    second: Array
    third: Array
    third_bound: Array
    fourth_bound: Array
    rounding: Array


def led(x: Form, f: Slopes) -> Form:
    """A function of a form."""
    terms, linear, bent, radius = x.terms, x.linear, x.bent, x.radius
    squares = np.zeros_like(x.line)
    squares[1 + terms.shares : terms.cubes] = squares_of(terms, x.line, x.line)
    line = f.first * x.line + f.second * squares
    line[0] = f.value
    if terms.order == 3:
        line[terms.cubes :] += 2.0 * f.second * cubes_of(terms, x.line, x.line) + f.third * cubes_of(
            terms, x.line, squares
        )
        rest = np.abs(f.second) * (2.0 * linear * x.cubic + bent**2) + f.fourth_bound * radius**4
        rest = rest + np.abs(f.third) * bent * (3.0 * linear * (linear + bent) + bent**2)
    else:
        rest = np.abs(f.second) * (2.0 * linear + bent) * bent + f.third_bound * radius**3
    size = (np.abs(f.first) + (np.abs(f.second) + np.abs(f.third) * radius) * radius) * radius
    rest = rest + np.abs(f.first) * x.rest + f.rounding + 32.0 * EPS * size
    return form(terms, line, rest * UP + TINY)


def sine(x: Form) -> Form:
    """sin x."""
    return _turning(x, np.sin(x.line[0]), np.cos(x.line[0]))


def cosine(x: Form) -> Form:
    """cos x."""
    return _turning(x, np.cos(x.line[0]), -np.sin(x.line[0]))


def _turning(x: Form, value: Array, slope: Array) -> Form:
    third, fourth = np.asarray(1.0 / 5.99), np.asarray(1.0 / 23.9)
    rounding = 8.0 * EPS * (1.0 + x.radius) ** 3
    return led(x, Slopes(value, slope, -0.5 * value, -slope / 6.0, third, fourth, rounding))


def _least(x: Form) -> Array:
    """The least size of values of one sign; NaN where there may be a zero among them."""
    room = (np.abs(x.line[0]) - x.radius) * (1.0 - 8.0 * EPS) - 2.0 * EPS * np.abs(x.line[0])
    return np.where(room > 0.0, room, np.nan)


def reciprocal(x: Form) -> Form:
    """1 / x."""
    value, least = 1.0 / x.line[0], _least(x)
    third, fourth = least**-4.0 * UP, least**-5.0 * UP
    return led(x, Slopes(value, -(value**2), value**3, -(value**4), third, fourth, 4.0 * EPS * np.abs(value)))


def divide(x: Form, y: Form) -> Form:
    """x / y."""
    return multiply(x, reciprocal(y))


def root(x: Form) -> Form:
    """The square root."""
    least = np.where(x.line[0] > 0.0, _least(x), np.nan)
    value = np.sqrt(x.line[0])
    third, fourth = least**-2.5 * (UP / 16.0), least**-3.5 * (UP * 5.0 / 128.0)
    slopes = Slopes(value, 0.5 / value, -0.125 / value**3, 0.0625 / value**5, third, fourth, 4.0 * EPS * value)
    return led(x, slopes)


def less(x: Form, y: Form) -> Form:
    """1 or 0 where all values agree, else nothing that can be used (NaN)."""
    apart = subtract(x, y)
    middle, radius = apart.line[0], apart.radius
    line = np.zeros_like(apart.line)
    line[0] = np.where(middle + radius < 0.0, 1.0, np.where(middle - radius > 0.0, 0.0, np.nan))
    return form(x.terms, line, np.where(np.isnan(line[0]), np.nan, 0.0))


def picked(test: Form, x: Form, y: Form) -> Form:
    """x where the test is 1, y where it is 0."""
    which, unknown = test.line[0] == 1.0, np.isnan(test.line[0])
    line = np.where(unknown, np.nan, np.where(which, x.line, y.line))
    return form(x.terms, line, np.where(unknown, np.nan, np.where(which, x.rest, y.rest)))


MEANING: Mapping[Op, Callable[..., Form]] = {
    Op.ADD: add,
    Op.SUB: subtract,
    Op.MUL: multiply,
    Op.DIV: divide,
    Op.NEG: negative,
    Op.SIN: sine,
    Op.COS: cosine,
    Op.SQRT: root,
    Op.LESS: less,
    Op.PICK: picked,
}
"""What the operations compute; programs for this have no fused ones."""


def enclose(program: Program, inputs: Sequence[Form]) -> list[Form]:
    """Forms of all results of a program.

    Raises:
        InputError: it has an operation without an enclosure.
    """
    unknown = sorted(
        {Op(code).name for code in program.op.tolist()} - {op.name for op in (*MEANING, Op.CONST, Op.INPUT)}
    )
    if unknown:
        raise InputError(f"{program.name} cannot be enclosed: it has {', '.join(unknown)}")
    terms = inputs[0].terms
    last = {int(k): i for i, row in enumerate(program.operands.tolist()) for k in row if k >= 0}
    keep = set(program.outputs.tolist())
    values: dict[int, Form] = {}
    rows = zip(program.op.tolist(), program.operands.tolist(), program.values.tolist(), strict=True)
    with np.errstate(all="ignore"):
        for index, (code, operands, number) in enumerate(rows):
            match op := Op(code):
                case Op.CONST:
                    values[index] = constant(number, terms)
                    continue
                case Op.INPUT:
                    values[index] = inputs[operands[0]]
                    continue
            read = operands[: op.arity]
            values[index] = MEANING[op](*(values[k] for k in read))
            for k in set(read):
                if last[k] == index and k not in keep:
                    del values[k]
    return [values[k] for k in program.outputs.tolist()]
