"""Small vectors and rotations, quicker than numpy's own functions on arrays as small as these."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array

_FIRST = np.eye(3)[:, [1, 2, 0, 2, 0, 1]]
_SECOND = np.eye(3)[:, [2, 0, 1, 1, 2, 0]]
_LOWER, _UPPER = np.array([7, 2, 3]), np.array([5, 6, 1])
_TRACE = np.eye(3).ravel()


def cross(x: Array, y: Array) -> Array:
    """Cross product of vectors, shape (3,) or (k, 3)."""
    products = x.dot(_FIRST) * y.dot(_SECOND)
    return np.asarray(products[..., :3] - products[..., 3:])


def stretched(sines: Array, cosine: float) -> Array:
    """The two components of the sine of the angle between two unit vectors, stretched to the angle, shape (2,)."""
    sine = float(np.hypot(sines[0], sines[1]))
    if sine > 1e-12:
        return sines * (float(np.arctan2(sine, cosine)) / sine)
    return sines if cosine > 0.0 else np.array([np.pi, 0.0])


def rotation_vectors(a: Array, b: Array) -> Array:
    """Rotation vectors in world axes that turn the axes a into b, shape (k, 3, 3) each, one after another, (3 k,)."""
    turn = b @ a.transpose(0, 2, 1)
    entries = turn.reshape(-1, 9)
    twice = entries.take(_LOWER, 1) - entries.take(_UPPER, 1)
    if np.vdot(twice, twice) < 1e-8 and min(entries.dot(_TRACE).tolist()) > 0.0:
        return np.asarray(0.5 * twice.ravel())  # sines of small angles, right to 1e-14, as a rule
    return np.concatenate([pin.log3(one) for one in turn])
