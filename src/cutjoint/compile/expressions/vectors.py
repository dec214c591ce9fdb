"""Vectors and rotations made of expressions or floats; plain tuples, so that zeros and constants fold away."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.expressions.graph import Expression, Number

Vector: TypeAlias = tuple[Number, Number, Number]
Matrix: TypeAlias = tuple[Vector, Vector, Vector]
"""Rows of a 3 x 3 matrix."""

ZERO: Vector = (0.0, 0.0, 0.0)
IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ROUNDING = 4e-16
"""Entries of given rotations so near 0, 1 or -1 are taken for that: they are the rounding of a quarter turn."""


def constant_vector(values: Array) -> Vector:
    """A vector of floats."""
    x, y, z = (float(value) for value in values)
    return (x, y, z)


def constant_rotation(values: Array) -> Matrix:
    """A rotation of floats, rid of the rounding of quarter turns."""
    exact = np.where(np.abs(values - np.round(values)) <= ROUNDING, np.round(values), values)
    a, b, c = (constant_vector(row) for row in exact)
    return (a, b, c)


def add(a: Vector, b: Vector) -> Vector:
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a: Vector, b: Vector) -> Vector:
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(s: Number, a: Vector) -> Vector:
    """s a."""
    return (s * a[0], s * a[1], s * a[2])


def dot(a: Sequence[Number], b: Sequence[Number]) -> Number:
    """a' b, of any length."""
    total: Number = 0.0
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total


def cross(a: Vector, b: Vector) -> Vector:
    """a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def turn(m: Matrix, a: Vector) -> Vector:
    """Matrix times vector."""
    return (dot(m[0], a), dot(m[1], a), dot(m[2], a))


def transposed(m: Matrix) -> Matrix:
    """The transpose."""
    return ((m[0][0], m[1][0], m[2][0]), (m[0][1], m[1][1], m[2][1]), (m[0][2], m[1][2], m[2][2]))


def product(a: Matrix, b: Matrix) -> Matrix:
    """Matrix times matrix."""
    columns = transposed(b)
    x, y, z = ((dot(row, columns[0]), dot(row, columns[1]), dot(row, columns[2])) for row in a)
    return (x, y, z)


def column(m: Matrix, k: int) -> Vector:
    """Column k."""
    return (m[0][k], m[1][k], m[2][k])


def about(axis: int, sine: Number, cosine: Number) -> Matrix:
    """Rotation about coordinate axis 0, 1 or 2."""
    match axis:
        case 0:
            return ((1.0, 0.0, 0.0), (0.0, cosine, -sine), (0.0, sine, cosine))
        case 1:
            return ((cosine, 0.0, sine), (0.0, 1.0, 0.0), (-sine, 0.0, cosine))
    return ((cosine, -sine, 0.0), (sine, cosine, 0.0), (0.0, 0.0, 1.0))


def from_quaternion(x: Number, y: Number, z: Number, w: Number) -> Matrix:
    """Rotation of a unit quaternion."""
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


def rotation_onto(axis: Array) -> Array:
    """A constant rotation whose third column is the unit vector `axis`."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = np.cross(helper, axis)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first), axis], axis=1)


def frame_along(axis: Array) -> tuple[Array, int]:
    """A constant rotation, and which of its columns is the direction of `axis`; the identity where that serves."""
    axis = axis / np.linalg.norm(axis)
    nearest = int(np.argmax(np.abs(axis)))
    if abs(axis[nearest] - 1.0) < ROUNDING:
        return np.eye(3), nearest
    return rotation_onto(axis), 2


def across(axes: Matrix) -> tuple[Vector, Vector, bool]:
    """Two directions across the z axis of a frame, and whether they are constants, as that axis is."""
    z = [x.constant if isinstance(x, Expression) else x for x in column(axes, 2)]
    if None in z:
        return column(axes, 0), column(axes, 1), False
    constant = np.array(z, dtype=np.float64)
    frame = constant_rotation(rotation_onto(constant / np.linalg.norm(constant)))
    return column(frame, 0), column(frame, 1), True
