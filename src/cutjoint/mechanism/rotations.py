"""Rotations in numbers: matrices, rotation vectors and unit quaternions, written out for three coordinates.

A rotation vector is axis times angle [rad]; a quaternion is (x, y, z, w), the order of Pinocchio and ROS.  From a
matrix to a quaternion by the largest of its four squares (S. W. Shepperd: Quaternion from rotation matrix.  J. Guidance
and Control 1 (1978) 223-224).
"""

from __future__ import annotations

from math import atan2, cos, isfinite, sin, sqrt

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, as_vector
from cutjoint.errors import InputError

NOT_QUITE = 1e-6
"""By how much a rotation that is given may miss being one; it is then the nearest one that is taken."""

ROUNDED = 1e-14
"""What a matrix that is a rotation up to rounding may miss; it is taken as it is."""

Quaternion = tuple[float, float, float, float]


def quaternion_of(rotation: Array) -> Quaternion:
    """(x, y, z, w) of a rotation matrix, with w >= 0."""
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    trace = a + e + i
    squares = (trace, a, e, i)
    largest = max(range(4), key=squares.__getitem__)
    if largest == 0:
        s = 0.5 / sqrt(trace + 1.0)
        return (h - f) * s, (c - g) * s, (d - b) * s, 0.25 / s
    if largest == 1:
        s = 0.5 / sqrt(1.0 + a - e - i)
        x, y, z, w = 0.25 / s, (b + d) * s, (c + g) * s, (h - f) * s
    elif largest == 2:
        s = 0.5 / sqrt(1.0 + e - a - i)
        x, y, z, w = (b + d) * s, 0.25 / s, (f + h) * s, (c - g) * s
    else:
        s = 0.5 / sqrt(1.0 + i - a - e)
        x, y, z, w = (c + g) * s, (f + h) * s, 0.25 / s, (d - b) * s
    return (x, y, z, w) if w >= 0.0 else (-x, -y, -z, -w)


def matrix_of(quaternion: npt.ArrayLike) -> Array:
    """Rotation matrix (3, 3) of a unit quaternion (x, y, z, w)."""
    x, y, z, w = np.asarray(quaternion, dtype=np.float64).tolist()
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def turned(vector: npt.ArrayLike) -> Array:
    """Rotation matrix (3, 3) of a rotation vector (3,) [rad]."""
    x, y, z = np.asarray(vector, dtype=np.float64).tolist()
    angle = sqrt(x * x + y * y + z * z)
    half = 0.5 * angle
    s = sin(half) / angle if angle > 1e-8 else 0.5 - angle * angle / 48.0
    return matrix_of((s * x, s * y, s * z, cos(half)))


def vector_of(rotation: Array) -> Array:
    """Rotation vector (3,) [rad] of a rotation matrix; at most half a turn."""
    x, y, z, w = quaternion_of(rotation)
    size = sqrt(x * x + y * y + z * z)
    factor = 2.0 * atan2(size, w) / size if size > 1e-12 else 2.0
    return np.array([factor * x, factor * y, factor * z])


def crossing(vector: Array) -> Array:
    """The matrix [u] with [u] w = u x w."""
    x, y, z = vector.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation_from(values: npt.ArrayLike) -> Array:
    """The rotation nearest to a (3, 3) matrix that is nearly one, or of a quaternion (x, y, z, w) that is nearly unit.

    Raises:
        InputError: it is none.
    """
    array = np.asarray(values, dtype=np.float64)
    if array.shape == (4,):
        given = as_vector("quaternion", array, 4)
        size = float(np.linalg.norm(given))
        if abs(size - 1.0) > 1e3 * NOT_QUITE:
            raise InputError(
                f"a quaternion (x, y, z, w) must have length 1, found {given.tolist()} of length {size:.6g}"
            )
        return matrix_of(given / size)
    if array.shape != (3, 3) or not all(map(isfinite, array.ravel().tolist())):
        raise InputError(
            f"a rotation must be a finite (3, 3) matrix or quaternion (x, y, z, w), found {array.tolist()}"
        )
    off, volume = _misses(array)
    if off > NOT_QUITE or volume < 0.0:
        what = "a reflection" if off <= NOT_QUITE else f"rows that miss being orthogonal unit vectors by {off:.2g}"
        raise InputError(f"this (3, 3) matrix is no rotation but has {what}: {array.tolist()}")
    if off < ROUNDED:
        return array
    left, _, right = np.linalg.svd(array)
    return np.asarray(left @ right)


def _misses(array: Array) -> tuple[float, float]:
    """By how much the rows of a (3, 3) matrix miss being orthogonal unit vectors, and their volume."""
    (a, b, c), (d, e, f), (g, h, i) = array.tolist()
    squares = (a * a + b * b + c * c - 1.0, d * d + e * e + f * f - 1.0, g * g + h * h + i * i - 1.0)
    products = (a * d + b * e + c * f, a * g + b * h + c * i, d * g + e * h + f * i)
    volume = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return max(map(abs, (*squares, *products))), volume
