"""Forms: enclosures of what a straight-line program computes over many boxes at once, roundings included.

A form stands for all values m + l(s) + q(s) + c(s) + e with the shares s in [-1, 1] (one for every edge of a box),
polynomials l, q and c of first, second and third degree (the last in forms of third order alone), and |e| <= r. They
are kept with their signs, so terms that cancel do so here too; what is of higher order goes into r with a bound. With
L, Q and C the sums of the sizes of the coefficients, B = Q + C + r, R = L + B the radius, f1, f2, f3 derivatives over
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

from collections.abc import Sequence
from functools import cache
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array

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
        line[1 + terms.shares : terms.cubes] += squares_of(terms, x.line, y.line)
    if terms.order == 3:
        line[terms.cubes :] += cubes_of(terms, x.line, y.line) + cubes_of(terms, y.line, x.line)
        rest = rest + x.linear * y.cubic + x.square * (y.square + y.cubic)
        rest = rest + x.cubic * (y.linear + y.square + y.cubic)
    else:
        rest = rest + x.linear * y.bent + x.bent * (y.linear + y.bent)
    return form(terms, line, (rest + 16.0 * EPS * (x.largest * y.largest)) * UP + TINY)


def squares_of(terms: FormTerms, x: Array, y: Array) -> Array:
    """Coefficients of the products of two linear parts."""
    i, j = 1 + terms.pairs.T
    return np.asarray((x[i] * y[j] + x[j] * y[i]) * terms.half)


def cubes_of(terms: FormTerms, x: Array, y: Array) -> Array:
    """Coefficients of the product of the linear part of x and what is of second degree of y."""
    return np.asarray((x[1 + terms.triples] * y[terms.rests] * terms.once).sum(axis=1))


def weighted(forms: Sequence[Form], weights: Array, constant_part: float) -> Form:
    """The sum of forms, each times a number, and a number."""
    terms = forms[0].terms
    total = constant(constant_part, terms)
    for one, weight in zip(forms, weights.tolist(), strict=True):
        if weight:
            total = add(total, multiply(one, constant(weight, terms)))
    return total
