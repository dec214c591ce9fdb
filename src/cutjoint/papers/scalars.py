"""Scalar algebra that the papers' equations are written in: three-vectors and 3 x 3 systems without a branch.

Everything here uses only + - * / on its arguments, and the few elementary functions of a namespace `fn` that is handed
in.  So one and the same equation runs on floats (`fn=math`, the quickest way in plain Python), on arrays of states
(`fn=numpy`) and on symbols (`cutjoint.compile` brings its own functions).  Checks on values belong to the models.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import LARGEST, as_vector
from cutjoint.errors import InputError

Scalar: TypeAlias = Any
"""A float, an array of states or a symbol."""

Vector: TypeAlias = Scalar
"""A tuple of scalars, as many as the robot has actuators."""

Vector3: TypeAlias = tuple[Scalar, Scalar, Scalar]
Matrix3: TypeAlias = tuple[Vector3, Vector3, Vector3]
"""Rows of a 3 x 3 matrix."""

Vector6: TypeAlias = tuple[Scalar, Scalar, Scalar, Scalar, Scalar, Scalar]
"""A symmetric 3 x 3 matrix as (xx, xy, xz, yy, yz, zz)."""


class Functions(Protocol):
    """The elementary functions that the equations need; the modules math and numpy (>= 2) offer them, and so does the
    tracer of `cutjoint.compile`."""

    sqrt: Callable[..., Scalar]
    sin: Callable[..., Scalar]
    cos: Callable[..., Scalar]
    acos: Callable[..., Scalar]
    atan2: Callable[..., Scalar]


_FLOAT = np.dtype(np.float64)

NUMBERS: Functions = cast(Functions, math)
"""Plain floats."""


def dot(a: Vector3, b: Vector3) -> Scalar:
    """a' b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector3, b: Vector3) -> Vector3:
    """a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def times(matrix: Matrix3, x: Vector3) -> Vector3:
    """Matrix times vector."""
    return (dot(matrix[0], x), dot(matrix[1], x), dot(matrix[2], x))


def transposed(matrix: Matrix3) -> Matrix3:
    """The transpose."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    return ((a, d, g), (b, e, h), (c, f, i))


def gram(matrix: Matrix3) -> Vector6:
    """The symmetric product matrix' matrix as (xx, xy, xz, yy, yz, zz)."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    return (
        a * a + d * d + g * g,
        a * b + d * e + g * h,
        a * c + d * f + g * i,
        b * b + e * e + h * h,
        b * c + e * f + h * i,
        c * c + f * f + i * i,
    )


def inertia_of(still: Scalar, moving: Scalar, matrix: Matrix3) -> Vector6:
    """still 1 + moving matrix' matrix as (xx, xy, xz, yy, yz, zz): the mass matrix of what turns by itself and what a
    Jacobian moves."""
    xx, xy, xz, yy, yz, zz = gram(matrix)
    return (still + moving * xx, moving * xy, moving * xz, still + moving * yy, moving * yz, still + moving * zz)


def symmetric(entries: Vector6) -> Matrix3:
    """The full matrix of (xx, xy, xz, yy, yz, zz)."""
    xx, xy, xz, yy, yz, zz = entries
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


def inverse(matrix: Matrix3) -> Matrix3:
    """The inverse, from the cofactors."""
    a, b, c = matrix
    bc, ca, ab = cross(b, c), cross(c, a), cross(a, b)
    d = 1.0 / dot(a, bc)
    return (
        (bc[0] * d, ca[0] * d, ab[0] * d),
        (bc[1] * d, ca[1] * d, ab[1] * d),
        (bc[2] * d, ca[2] * d, ab[2] * d),
    )


def solve_symmetric(entries: Vector6, y: Vector3) -> Vector3:
    """x with S x = y, S symmetric positive definite (Cholesky without roots, S = L D L')."""
    xx, xy, xz, yy, yz, zz = entries
    l21 = xy / xx
    l31 = xz / xx
    d2 = yy - l21 * xy
    w = yz - l31 * xy
    l32 = w / d2
    d3 = zz - l31 * xz - l32 * w
    y1 = y[0]
    y2 = y[1] - l21 * y1
    y3 = y[2] - l31 * y1 - l32 * y2
    x3 = y3 / d3
    x2 = y2 / d2 - l32 * x3
    x1 = y1 / xx - l21 * x2 - l31 * x3
    return (x1, x2, x3)


def two_link_angle(u: Scalar, w: Scalar, k: Scalar, sign: Scalar, fn: Functions = NUMBERS) -> Scalar:
    """Angle, from the u axis towards w, of a direction whose component along it is k: u cos t + w sin t = k.

    This is the first link of a planar two-link limb whose end is at (u, w).  `sign` +1 or -1 picks the root: the first
    link stands ahead of or behind the line from its pivot to the end.
    """
    return fn.atan2(w, u) + sign * fn.acos(k / fn.sqrt(u * u + w * w))


def three(name: str, values: npt.ArrayLike, unit: str) -> tuple[float, float, float]:
    """Three finite floats out of `values`; quick for a float array of shape (3,).

    Raises:
        InputError: wrong shape, not numbers or not finite; the message names the argument.
    """
    if isinstance(values, np.ndarray) and values.shape == (3,) and values.dtype is _FLOAT:
        x, y, z = values.tolist()
        if abs(x) + abs(y) + abs(z) <= LARGEST:
            return x, y, z
    x, y, z = as_vector(name, values, 3, unit).tolist()
    return x, y, z


def check_signs(signs: Sequence[int]) -> tuple[int, int, int]:
    """Three signs, each +1 or -1.

    Raises:
        InputError: not three, or another value.
    """
    if len(signs) != 3 or any(sign not in (1, -1) for sign in signs):
        raise InputError(f"signs must be three numbers, each +1 or -1, one a limb; found {tuple(signs)!r}")
    one, two, three_ = (int(sign) for sign in signs)
    return one, two, three_
