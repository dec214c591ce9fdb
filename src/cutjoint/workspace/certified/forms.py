"""Quadratic forms: enclosures of what a straight-line program computes over many boxes at once, roundings included.

A form stands for all values m + g . s + s' H s + e with the shares s in [-1, 1] (one for every edge of a box) and |e|
<= r. The polynomial is kept with its signs, so terms that cancel do so here too; all of third order goes into r with a
bound. With L the sum of |g|, Q that of |H|, R = L + Q + r the radius, and T a bound of a sixth of the third
derivative,

    x y:       |m_x| r_y + |m_y| r_x + L_x (Q_y + r_y) + (Q_x + r_x) R_y
    f(x):      |f'| r + |f''| / 2 (2 L + Q + r) (Q + r) + T R^3

Every operation adds a bound of its own rounding to r, from `EPS`; that of numpy's sine and cosine, which are good to a
few units in the last place, is taken as eight.  Constants of a program are what the description's numbers were rounded
to, so all but small multiples of 1/2 count as uncertain by four units in their last place.

After M. Berz, G. Hoffstaetter: Computation and application of Taylor polynomials with interval remainder bounds.
Reliable Computing 4 (1998) 83-97; and L. H. de Figueiredo, J. Stolfi: Affine arithmetic: concepts and applications.
Numer. Algorithms 37 (2004) 147-158.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.compile.expressions.operations import Op
from cutjoint.compile.expressions.program import Program
from cutjoint.errors import InputError

EPS = float(np.finfo(np.float64).eps)
UP = 1.0 + 64.0 * EPS
"""Makes up for the roundings of a short sum of bounds."""
TINY = 1e-290
"""Makes up for what underflows."""


class FormTerms(NamedTuple):
    """The polynomial of a form: 1, the shares, and their products.

    Attributes:
        shares: how many there are.
        first, second: of every product, the numbers of its factors, first <= second.
        half: 1/2 for every square, 1 for every other product.
    """

    shares: int
    first: npt.NDArray[np.intp]
    second: npt.NDArray[np.intp]
    half: Array

    @property
    def size(self) -> int:
        """How many terms there are."""
        return 1 + self.shares + len(self.first)

    def values(self, shares: Array) -> Array:
        """Of all terms at shares (shares,), shape (terms,)."""
        return np.concatenate([np.ones(1), shares, shares[self.first] * shares[self.second]])


@cache
def terms_of(shares: int) -> FormTerms:
    """The terms for a number of shares."""
    first, second = np.triu_indices(shares)
    return FormTerms(shares, first, second, np.where(first == second, 0.5, 1.0)[:, None])


@cache
def terms_by_size(size: int) -> FormTerms:
    """The terms by how many they are."""
    return next(terms for shares in range(size) if (terms := terms_of(shares)).size == size)


class Form(NamedTuple):
    """Many forms side by side.

    Attributes:
        line: coefficients of all terms, shape (terms, boxes) or (terms, 1).
        rest: bound of all else, shape (boxes,) or (1,).
        linear: sum of the sizes of what is linear, same shape.
        bent: the same of what is quadratic, and the rest.
    """

    line: Array
    rest: Array
    linear: Array
    bent: Array

    @property
    def radius(self) -> Array:
        """Bound of how far values are from the middle."""
        return np.asarray((self.linear + self.bent) * UP)

    @property
    def largest(self) -> Array:
        """Bound of the size of the values."""
        return np.asarray((np.abs(self.line[0]) + self.linear + self.bent) * UP)


def form(line: Array, rest: Array) -> Form:
    """A form from its polynomial and its rest."""
    shares, sizes = terms_by_size(len(line)).shares, np.abs(line)
    return Form(line, rest, sizes[1 : 1 + shares].sum(axis=0) * UP, (sizes[1 + shares :].sum(axis=0) + rest) * UP)


def constant(value: float, shares: int) -> Form:
    """A number; exact where it is a small multiple of 1/2."""
    line = np.zeros((terms_of(shares).size, 1))
    line[0] = value
    exact = abs(value) <= 4.0 and 2.0 * value == round(2.0 * value)
    return form(line, np.array([0.0 if exact else 4.0 * EPS * abs(value)]))


def add(x: Form, y: Form) -> Form:
    """x + y."""
    return form(x.line + y.line, ((x.rest + y.rest) + EPS * (x.largest + y.largest)) * UP)


def subtract(x: Form, y: Form) -> Form:
    """x - y."""
    return form(x.line - y.line, ((x.rest + y.rest) + EPS * (x.largest + y.largest)) * UP)


def negative(x: Form) -> Form:
    """-x."""
    return x._replace(line=-x.line)


def multiply(x: Form, y: Form) -> Form:
    """x y."""
    terms = terms_by_size(len(x.line))
    line = x.line[0] * y.line + y.line[0] * x.line
    line[0] = x.line[0] * y.line[0]
    if x.linear.any() and y.linear.any():
        line[1 + terms.shares :] += _product(terms, x.line, y.line)
    rest = np.abs(x.line[0]) * y.rest + np.abs(y.line[0]) * x.rest
    rest = rest + x.linear * y.bent + x.bent * (y.linear + y.bent)
    return form(line, (rest + 8.0 * EPS * (x.largest * y.largest)) * UP + TINY)


def _product(terms: FormTerms, x: Array, y: Array) -> Array:
    """Coefficients of the products of two linear parts."""
    i, j = 1 + terms.first, 1 + terms.second
    return np.asarray((x[i] * y[j] + x[j] * y[i]) * terms.half)


def led(x: Form, value: Array, slope: Array, bend: Array, third: Array, rounding: Array) -> Form:
    """A function of a form.

    Args:
        x: the form.
        value, slope, bend: in the middle, of the function, its derivative, and half its second derivative.
        third: bound of a sixth of its third derivative.
        rounding: bound of the rounding of `value`.
    """
    terms = terms_by_size(len(x.line))
    line = slope * x.line
    line[0] = value
    line[1 + terms.shares :] += bend * _product(terms, x.line, x.line)
    radius = x.radius
    rest = np.abs(slope) * x.rest + np.abs(bend) * (2.0 * x.linear + x.bent) * x.bent + third * radius**3
    rounded = rounding + 16.0 * EPS * (np.abs(slope) + np.abs(bend) * radius) * radius
    return form(line, (rest + rounded) * UP + TINY)


def sine(x: Form) -> Form:
    """sin x."""
    value, slope = np.sin(x.line[0]), np.cos(x.line[0])
    return led(x, value, slope, -0.5 * value, np.asarray(1.0 / 5.99), 8.0 * EPS * (1.0 + x.radius) ** 2)


def cosine(x: Form) -> Form:
    """cos x."""
    value, slope = np.cos(x.line[0]), -np.sin(x.line[0])
    return led(x, value, slope, -0.5 * value, np.asarray(1.0 / 5.99), 8.0 * EPS * (1.0 + x.radius) ** 2)


def _least(x: Form) -> Array:
    """The least size of values of one sign; NaN where there may be a zero among them."""
    room = np.abs(x.line[0]) - x.radius
    return np.where(room > 0.0, room * (1.0 - 8.0 * EPS) - 2.0 * EPS * np.abs(x.line[0]), np.nan)


def reciprocal(x: Form) -> Form:
    """1 / x."""
    value, least = 1.0 / x.line[0], _least(x)
    least = np.where(least > 0.0, least, np.nan)
    return led(x, value, -value * value, value**3, least**-4.0 * UP, 4.0 * EPS * np.abs(value))


def divide(x: Form, y: Form) -> Form:
    """x / y."""
    return multiply(x, reciprocal(y))


def root(x: Form) -> Form:
    """The square root."""
    least = _least(x)
    least = np.where((least > 0.0) & (x.line[0] > 0.0), least, np.nan)
    value = np.sqrt(x.line[0])
    return led(x, value, 0.5 / value, -0.125 / value**3, least**-2.5 * (UP / 16.0), 4.0 * EPS * value)


def less(x: Form, y: Form) -> Form:
    """1 or 0 where all values agree, else nothing that can be used (NaN)."""
    apart = subtract(x, y)
    middle, radius = apart.line[0], apart.radius
    line = np.zeros_like(apart.line)
    line[0] = np.where(middle + radius < 0.0, 1.0, np.where(middle - radius > 0.0, 0.0, np.nan))
    return form(line, np.where(np.isnan(line[0]), np.nan, 0.0))


def picked(test: Form, x: Form, y: Form) -> Form:
    """x where the test is 1, y where it is 0."""
    which, unknown = test.line[0] == 1.0, np.isnan(test.line[0])
    line = np.where(unknown, np.nan, np.where(which, x.line, y.line))
    return form(line, np.where(unknown, np.nan, np.where(which, x.rest, y.rest)))


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
    shares = terms_by_size(len(inputs[0].line)).shares
    last = {int(k): i for i, row in enumerate(program.operands.tolist()) for k in row if k >= 0}
    keep = set(program.outputs.tolist())
    values: dict[int, Form] = {}
    rows = zip(program.op.tolist(), program.operands.tolist(), program.values.tolist(), strict=True)
    with np.errstate(all="ignore"):
        for index, (code, operands, number) in enumerate(rows):
            match op := Op(code):
                case Op.CONST:
                    values[index] = constant(number, shares)
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


def weighted(forms: Sequence[Form], weights: Array, constant_part: float) -> Form:
    """The sum of forms, each times a number, and a number."""
    shares = terms_by_size(len(forms[0].line)).shares
    total = constant(constant_part, shares)
    for one, weight in zip(forms, weights.tolist(), strict=True):
        if weight:
            total = add(total, multiply(one, constant(weight, shares)))
    return total
