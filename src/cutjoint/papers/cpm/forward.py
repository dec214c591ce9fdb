"""Forward kinematics of the CPM with rotary motors: the eighth-degree polynomial that section 1.1 speaks of.

With the motors held, (3), (6) and (9) are three cylinders of radius L2 along x, y and z.  Lengths in units of L2, with
the origin in (middle of the second and third axis in x, third axis in y, second axis in z) they are

    (Y + A)^2 + (Z + B)^2 = 1,    Z^2 + (X + d)^2 = 1,    (X - d)^2 + Y^2 = 1

Their squares leave 2 A Y + 2 B Z + q = 0 with q = 1 + A^2 + B^2 - 2 d^2 - 2 X^2, and Y^2 = f, Z^2 = g are known in X:

    (4 A^2 f - 4 B^2 g - q^2)^2 - 16 B^2 g q^2 = 0,    f = 1 - (X - d)^2,    g = 1 - (X + d)^2

The leading term is 16 X^8 whatever the motors do: the degree is eight, at every posture and for every size of the
robot.  (The cylinders have no common point at infinity, so by Bezout there are eight solutions, complex ones and
multiple ones counted.)  Every real solution is polished by Newton's method on (3), (6), (9) and returned only where it
closes them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array, readonly
from cutjoint.papers.cpm.parameters import CpmParameters
from cutjoint.papers.scalars import three

POLISHING = 60
"""Most Newton steps for a solution: quadratic at a regular one, one bit a step where two solutions meet."""

GIVING_UP = 12
"""Newton steps after which a start must be near a solution; those of real solutions start there."""

MEETING = 1e-6
"""Solutions nearer than this times L2 are one: where two meet, rounding places each to the root of 1e-16 only."""

SIGNS = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]])


class Cylinders(NamedTuple):
    """The three cylinders in units of L2.

    Attributes:
        a, b: offset of the first axis from the third in y and from the second in z, reversed.
        d: half the distance of the third axis from the second in x.
        origin: the origin of X, Y, Z [m].
    """

    a: float
    b: float
    d: float
    origin: tuple[float, float, float]


def elbows(p: CpmParameters, angles: npt.ArrayLike) -> Array:
    """Axes of the three cylinders, the points M_i in the limbs' planes, shape (3, 2) [m]: (y, z), (z, x), (x, y)."""
    one, two, three_ = np.asarray(angles, dtype=np.float64)
    return np.array(
        [
            [p.L + p.L1 * np.cos(one), p.L1 * np.sin(one)],
            [p.L1 * np.cos(two), p.L + p.L1 * np.sin(two)],
            [p.L1 * np.cos(three_), p.D - p.L - p.L1 * np.sin(three_)],
        ]
    )


def cylinders(p: CpmParameters, angles: npt.ArrayLike) -> Cylinders:
    """The cylinders (3), (6), (9) in units of L2 for the motor angles [rad]."""
    (y1, z1), (z2, x2), (x3, y3) = elbows(p, angles) / p.L2
    origin = (float(0.5 * (x2 + x3) * p.L2), float(y3 * p.L2), float(z2 * p.L2))
    return Cylinders(float(y3 - y1), float(z2 - z1), float(0.5 * (x3 - x2)), origin)


def polynomial(c: Cylinders) -> Array:
    """Coefficients of the eighth-degree polynomial in X, the highest power first, shape (9,); the first is 16."""
    q = np.array([-2.0, 0.0, 1.0 + c.a * c.a + c.b * c.b - 2.0 * c.d * c.d])
    f = np.array([-1.0, 2.0 * c.d, 1.0 - c.d * c.d])
    g = np.array([-1.0, -2.0 * c.d, 1.0 - c.d * c.d])
    square = np.polymul(q, q)
    inner = np.polysub(4.0 * c.a * c.a * f - 4.0 * c.b * c.b * g, square)
    return np.asarray(np.polysub(np.polymul(inner, inner), 16.0 * c.b * c.b * np.polymul(g, square)))


def solutions(p: CpmParameters, angles: npt.ArrayLike) -> Array:
    """All positions of the tool that the motor angles [rad] allow, shape (k, 3) [m], k <= 8, ordered by x, y, z.

    Away from singularities of type 2 k is even.  At one, where two solutions meet, the pair is one row.

    Raises:
        InputError: wrong shape or not finite.
    """
    held = three("angles", angles, "rad")
    c = cylinders(p, held)
    if max(abs(c.a), abs(c.b)) > 2.0 or abs(c.d) > 1.0:
        return readonly(np.zeros((0, 3)))  # two of the cylinders stand apart
    found = _polished(c, _starts(c))
    errors = _residual(c, found)
    distinct: list[tuple[Array, float]] = []
    for index in np.argsort(errors, kind="stable"):
        one = found[index]
        if errors[index] > tolerances.CLOSURE.value or any(np.linalg.norm(one - x) <= room for x, room in distinct):
            continue
        distinct.append((one, max(MEETING, _room(c, one))))
    ordered = sorted((x.tolist() for x, _ in distinct), key=lambda x: [round(one, 9) for one in x])
    return readonly(np.array(ordered).reshape(-1, 3) * p.L2 + np.array(c.origin))


def _starts(c: Cylinders) -> Array:
    """Near every real solution: the eight roots' real parts, with either sign of Y and Z, shape (32, 3)."""
    x = np.clip(np.roots(polynomial(c)).real, abs(c.d) - 1.0, 1.0 - abs(c.d))
    heights = np.sqrt(np.maximum(np.stack([1.0 - (x - c.d) ** 2, 1.0 - (x + c.d) ** 2], axis=1), 0.0))
    sides = heights[:, None, :] * SIGNS
    return np.concatenate([np.broadcast_to(x[:, None, None], (len(x), 4, 1)), sides], axis=2).reshape(-1, 3)


def _rods(c: Cylinders, x: Array) -> tuple[Array, ...]:
    """The rods' components, shape (k,) each: their rows in space are (0, a, b), (d, 0, e), (f, g, 0)."""
    return (x[:, 1] + c.a, x[:, 2] + c.b, x[:, 0] + c.d, x[:, 2], x[:, 0] - c.d, x[:, 1])


def _errors(rods: tuple[Array, ...]) -> tuple[Array, Array, Array]:
    """Half the left sides less the right ones of (3), (6), (9), shape (k,) each."""
    a, b, d, e, f, g = rods
    return (0.5 * (a * a + b * b - 1.0), 0.5 * (d * d + e * e - 1.0), 0.5 * (f * f + g * g - 1.0))


def _residual(c: Cylinders, x: Array) -> Array:
    """Worst error of a rod's length, shape (k,)."""
    return np.asarray(np.abs(_errors(_rods(c, x))).max(axis=0))


def _room(c: Cylinders, x: Array) -> float:
    """Radius around a solution that holds no other one: the equations are quadratic, with second derivatives below
    sqrt(2), so another solution is at least sqrt(2) times the smallest singular value of the rods away."""
    a, b, d, e, f, g = (float(one[0]) for one in _rods(c, x[None, :]))
    values = np.linalg.svd([[0.0, a, b], [d, 0.0, e], [f, g, 0.0]], compute_uv=False)
    return 0.5 * float(np.sqrt(2.0) * values[-1])


def _polished(c: Cylinders, x: Array) -> Array:
    """Newton's method from all starts at once; starts that are not on their way to a solution are given up."""
    for count in range(POLISHING):
        if count == GIVING_UP:
            x = x[_residual(c, x) < 1e-6]
        a, b, d, e, f, g = rods = _rods(c, x)
        r, s, t = _errors(rods)
        volume = a * e * f + b * d * g
        volume = np.where(np.abs(volume) > 1e-30, volume, 1e-30)
        step = np.stack(
            [
                (-e * g * r + b * g * s + a * e * t) / volume,
                (e * f * r - b * f * s + b * d * t) / volume,
                (d * g * r + a * f * s - a * d * t) / volume,
            ],
            axis=1,
        )
        size = np.sqrt(np.sum(step * step, axis=1, keepdims=True))
        x = x - step * np.minimum(1.0, 0.5 / np.maximum(size, 1e-300))
        if size.max(initial=0.0) < 1e-13:
            break
    return x
