"""Angular velocity and acceleration of a rotation exp([phi]) whose rotation vector phi [rad] moves; for three numbers
and for three arrays alike.

With J the right Jacobian of the rotation vector, along the axes of the body,

    w = J phi_dot,    J = 1 - a [phi] + b [phi]^2,    a = (1 - cos x) / x^2,  b = (x - sin x) / x^3,  x = |phi|,
    w_dot = J phi_ddot + J_dot phi_dot

(J. Sola, J. Deray, D. Atchuthan: A micro Lie theory for state estimation in robotics.  arXiv:1812.01537).  Up to half a
turn a and b are taken as power series in x^2, as far as their terms are felt, which hold for small x too.
"""

from __future__ import annotations

from bisect import bisect_left
from math import cos, factorial, sin, sqrt
from typing import Generic, TypeVar

import numpy as np

from cutjoint.arrays import Array

Number = TypeVar("Number", float, Array)
Triple = tuple[Number, Number, Number]
Four = tuple[Number, Number, Number, Number]
Five = tuple[Number, Number, Number, Number, Number]

_TERMS = 20
_A = [(-1.0) ** k / factorial(2 * k + 2) for k in range(_TERMS + 1)]
_B = [(-1.0) ** k / factorial(2 * k + 3) for k in range(_TERMS + 1)]
# A row a power of x^2, for (a - 1 / 2) / x^2, b, and their derivatives by x over x.
_ROWS = [(_A[k + 1], _B[k], 2.0 * (k + 1) * _A[k + 1], 2.0 * (k + 1) * _B[k + 1]) for k in range(_TERMS)]
# The largest x^2 at which the power k is not felt any more.
_UNFELT = [(1e-18 / abs(_B[k])) ** (1.0 / k) for k in range(1, _TERMS)]


class RightJacobian(Generic[Number]):
    """J at the rotation vector `phi`, or at many of them."""

    def __init__(self, phi: Triple[Number]) -> None:
        self.phi: Triple[Number] = phi
        self._coefficients: Five[Number] = _coefficients(dot(phi, phi))

    def times(self, rate: Triple[Number]) -> Triple[Number]:
        """J rate: the angular velocity while the rotation vector moves at `rate`."""
        (x, y, z), (u, v, w) = rate, cross(self.phi, rate)
        p, q, r = cross(self.phi, (u, v, w))
        a, _, b, _, _ = self._coefficients
        return x - a * u + b * p, y - a * v + b * q, z - a * w + b * r

    def solve(self, velocity: Triple[Number]) -> Triple[Number]:
        """J^-1 velocity: the rate of the rotation vector at an angular velocity; for less than a whole turn."""
        (x, y, z), (u, v, w) = velocity, cross(self.phi, velocity)
        p, q, r = cross(self.phi, (u, v, w))
        a, rest, b, _, _ = self._coefficients
        c = (2.0 * rest + b) / (2.0 * a)
        return x + 0.5 * u + c * p, y + 0.5 * v + c * q, z + 0.5 * w + c * r

    def change(self, rate: Triple[Number], other: Triple[Number]) -> Triple[Number]:
        """J_dot other, while the rotation vector moves at `rate`."""
        along, across, aside = dot(self.phi, rate), cross(self.phi, other), cross(rate, other)
        (x, y, z), (u, v, w), (p, q, r) = cross(rate, across), cross(self.phi, aside), cross(self.phi, across)
        a, _, b, a_rate, b_rate = self._coefficients
        c, d = a_rate * along, b_rate * along
        return (
            b * (x + u) - a * aside[0] - c * across[0] + d * p,
            b * (y + v) - a * aside[1] - c * across[1] + d * q,
            b * (z + w) - a * aside[2] - c * across[2] + d * r,
        )


def _coefficients(square: Number) -> Five[Number]:
    """a, (a - 1/2) / x^2, b, and the derivatives of a and b by x over x, at x^2; arrays up to half a turn."""
    if not isinstance(square, np.ndarray) and square > 10.0:
        x = sqrt(square)
        a, b = (1.0 - cos(x)) / square, (x - sin(x)) / (x * square)
        return a, (a - 0.5) / square, b, (sin(x) / x - 2.0 * a) / square, (a - 3.0 * b) / square
    terms = 1 + bisect_left(_UNFELT, float(np.max(square)) if isinstance(square, np.ndarray) else square)
    p = q = r = s = 0.0 * square
    for k in range(min(terms, _TERMS) - 1, -1, -1):
        one, two, three, four = _ROWS[k]
        p, q, r, s = p * square + one, q * square + two, r * square + three, s * square + four
    return 0.5 + p * square, p, q, r, s


def quaternion_of_vector(phi: Triple[float]) -> Four[float]:
    """Unit quaternion x, y, z, w of a rotation vector."""
    angle = sqrt(dot(phi, phi))
    s = sin(0.5 * angle) / angle if angle > 1e-8 else 0.5
    return s * phi[0], s * phi[1], s * phi[2], cos(0.5 * angle)


def product(p: Four[Number], q: Four[Number]) -> Four[Number]:
    """The quaternion p q, x y z w: first q and then p."""
    (a, b, c, d), (x, y, z, w) = p, q
    return (
        d * x + a * w + b * z - c * y,
        d * y + b * w + c * x - a * z,
        d * z + c * w + a * y - b * x,
        d * w - a * x - b * y - c * z,
    )


def dot(u: Triple[Number], v: Triple[Number]) -> Number:
    """u . v"""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def cross(u: Triple[Number], v: Triple[Number]) -> Triple[Number]:
    """u x v"""
    (a, b, c), (x, y, z) = u, v
    return b * z - c * y, c * x - a * z, a * y - b * x


def triple(rows: Array) -> Triple[Array]:
    """The rows of a (3, n) array."""
    return rows[0], rows[1], rows[2]
