"""Forms: enclosures of what a straight-line program computes over many boxes at once, roundings included.

A form stands for all values m + l(s) + q(s) + c(s) + e with the shares s in [-1, 1] (one for every edge of a box),
polynomials l, q and c of first, second and third degree (the last in forms of third order alone), and |e| <= r. They are
kept with their signs, so terms that cancel do so here too; what is of higher order goes into r with a bound. With L, Q
and C the sums of the sizes of the coefficients, B = Q + C + r, R = L + B the radius, f1, f2, f3 derivatives over
factorials in the middle, and T a bound of the next one,

    order   x y                                              f(x)
    2       |m_x| r_y + |m_y| r_x + L_x B_y + B_x R_y        |f1| r + |f2| (2 L + B) B + T R^3
    3       |m_x| r_y + |m_y| r_x + L_x (C_y + r_y)          |f1| r + |f2| (2 L (C + r) + B^2)
                + Q_x B_y + (C_x + r_x) R_y                      + |f3| B (3 L^2 + 3 L B + B^2) + T R^4

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
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.compile.expressions.operations import Op
from cutjoint.compile.expressions.program import Program
from cutjoint.errors import InputError

Indices = npt.NDArray[np.intp]
EPS = float(np.finfo(np.float64).eps)
UP = 1.0 + 64.0 * EPS
"""Makes up for the roundings of a short sum of bounds."""
TINY = 1e-290
"""Makes up for what underflows."""


class FormTerms(NamedTuple):
    """The polynomial of a form: 1, the shares, and their products.

    Attributes:
        shares: how many there are.
        order: 2 or 3.
        pairs: of every product of two, the numbers of its factors, growing, (products, 2).
        triples: of every product of three, likewise; none where the order is 2.
        half: 1/2 for every square, 1 for every other product of two, (products, 1).
        rests: rows of the two other factors among the products of two, for each factor of every triple, (triples, 3).
        once: 1 for factors of triples, 0 for those that are there already, (triples, 3, 1).
    """

    shares: int
    order: int
    pairs: Indices
    triples: Indices
    half: Array
    rests: Indices
    once: Array

    @property
    def cubes(self) -> int:
        """Number of the first product of three."""
        return 1 + self.shares + len(self.pairs)

    @property
    def size(self) -> int:
        """How many terms there are."""
        return self.cubes + len(self.triples)

    def values(self, shares: Array) -> Array:
        """Of all terms at shares (shares,), shape (terms,)."""
        pairs, triples = shares[self.pairs].prod(axis=1), shares[self.triples].prod(axis=1)
        return np.concatenate([np.ones(1), shares, pairs, triples])


@cache
def terms_of(shares: int, order: int = 2) -> FormTerms:
    """The terms for a number of shares."""
    pairs = list(combinations_with_replacement(range(shares), 2))
    triples = list(combinations_with_replacement(range(shares), 3)) if order == 3 else []
    rests = [[1 + shares + pairs.index(pair) for pair in ((j, k), (i, k), (i, j))] for i, j, k in triples]
    once = [[1.0, float(j != i), float(k != j)] for i, j, k in triples]
    return FormTerms(
        shares,
        order,
        np.array(pairs, dtype=np.intp).reshape(-1, 2),
        np.array(triples, dtype=np.intp).reshape(-1, 3),
        np.array([[0.5 if i == j else 1.0] for i, j in pairs]),
        np.array(rests, dtype=np.intp).reshape(-1, 3),
        np.array(once).reshape(-1, 3, 1),
    )


class Form(NamedTuple):
    """Many forms side by side.

    Attributes:
        terms: of the polynomials.
        line: coefficients of all terms, shape (terms, boxes) or (terms, 1).
        rest: bound of all else, shape (boxes,) or (1,).
        linear: sum of the sizes of what is linear, same shape.
        square: the same of what is of second degree.
        cubic: the same of what is of third degree, and the rest.
    """

    terms: FormTerms
    line: Array
    rest: Array
    linear: Array
    square: Array
    cubic: Array

    @property
    def bent(self) -> Array:
        """Bound of all but what is linear."""
        return np.asarray((self.square + self.cubic) * UP)

    @property
    def radius(self) -> Array:
        """Bound of how far values are from the middle."""
        return np.asarray((self.linear + self.square + self.cubic) * UP)

    @property
    def largest(self) -> Array:
        """Bound of the size of the values."""
        return np.asarray((np.abs(self.line[0]) + self.linear + self.square + self.cubic) * UP)


def form(terms: FormTerms, line: Array, rest: Array) -> Form:
    """A form from its polynomial and its rest."""
    sizes, pairs, cubes = np.abs(line), 1 + terms.shares, terms.cubes
    linear, square = sizes[1:pairs].sum(axis=0) * UP, sizes[pairs:cubes].sum(axis=0) * UP
    cubic = (sizes[cubes:].sum(axis=0) + rest) * UP if terms.order == 3 else rest
    return Form(terms, line, rest, linear, square, cubic)


def constant(value: float, terms: FormTerms) -> Form:
    """A number; exact where it is a small multiple of 1/2."""
    line = np.zeros((terms.size, 1))
    line[0] = value
    exact = abs(value) <= 4.0 and 2.0 * value == round(2.0 * value)
    return form(terms, line, np.array([0.0 if exact else 4.0 * EPS * abs(value)]))


def add(x: Form, y: Form) -> Form:
    """x + y."""
    return form(x.terms, x.line + y.line, ((x.rest + y.rest) + EPS * (x.largest + y.largest)) * UP)


def subtract(x: Form, y: Form) -> Form:
    """x - y."""
    return form(x.terms, x.line - y.line, ((x.rest + y.rest) + EPS * (x.largest + y.largest)) * UP)


def negative(x: Form) -> Form:
    """-x."""
    return x._replace(line=-x.line)


def multiply(x: Form, y: Form) -> Form:
    """x y."""
    terms = x.terms
    line = x.line[0] * y.line + y.line[0] * x.line
    line[0] = x.line[0] * y.line[0]
    rest = np.abs(x.line[0]) * y.rest + np.abs(y.line[0]) * x.rest
    if x.linear.any() and y.linear.any():
        line[1 + terms.shares : terms.cubes] += _squares(terms, x.line, y.line)
    if terms.order == 3:
        line[terms.cubes :] += _cubes(terms, x.line, y.line) + _cubes(terms, y.line, x.line)
        rest = rest + x.linear * y.cubic + x.square * (y.square + y.cubic)
        rest = rest + x.cubic * (y.linear + y.square + y.cubic)
    else:
        rest = rest + x.linear * y.bent + x.bent * (y.linear + y.bent)
    return form(terms, line, (rest + 16.0 * EPS * (x.largest * y.largest)) * UP + TINY)


def _squares(terms: FormTerms, x: Array, y: Array) -> Array:
    """Coefficients of the products of two linear parts."""
    i, j = 1 + terms.pairs.T
    return np.asarray((x[i] * y[j] + x[j] * y[i]) * terms.half)


def _cubes(terms: FormTerms, x: Array, y: Array) -> Array:
    """Coefficients of the product of the linear part of x and what is of second degree of y."""
    return np.asarray((x[1 + terms.triples] * y[terms.rests] * terms.once).sum(axis=1))


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
    squares[1 + terms.shares : terms.cubes] = _squares(terms, x.line, x.line)
    line = f.first * x.line + f.second * squares
    line[0] = f.value
    if terms.order == 3:
        line[terms.cubes :] += 2.0 * f.second * _cubes(terms, x.line, x.line) + f.third * _cubes(terms, x.line, squares)
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


def weighted(forms: Sequence[Form], weights: Array, constant_part: float) -> Form:
    """The sum of forms, each times a number, and a number."""
    terms = forms[0].terms
    total = constant(constant_part, terms)
    for one, weight in zip(forms, weights.tolist(), strict=True):
        if weight:
            total = add(total, multiply(one, constant(weight, terms)))
    return total
