"""By how much one frame is turned against another, as the vector along the axis whose length is the angle, in [0, pi].

    from a unit quaternion (v, w):          2 atan2(|v|, |w|) / |v| v sign(w)
    from the axes a, b of both frames:      atan2(|s|, c) / |s| s,  s = (sum of a_k x b_k) / 2,  c = (tr - 1) / 2

Both are smooth at rest.  At half a turn the axis has no sign; the second one loses digits before that.
"""

from __future__ import annotations

from cutjoint.compile.expressions import functions
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import ZERO, Matrix, Vector, add, column, cross, dot, scale

SQUARE = 1e-300
"""Added to the square of a size that is divided by, so that nothing is divided by nothing."""


def size_of(vector: Vector) -> Number:
    """Length of a vector, never 0."""
    return functions.sqrt(dot(vector, vector) + SQUARE)


def from_quaternion(x: Number, y: Number, z: Number, w: Number) -> Vector:
    """Rotation vector of a unit quaternion."""
    vector: Vector = (x, y, z)
    sine = size_of(vector)
    half = functions.atan2(sine, functions.absolute(w))
    return scale(functions.where_less(w, 0.0, -2.0, 2.0) * half / sine, vector)


def between(a: Matrix, b: Matrix) -> tuple[Vector, Number]:
    """Rotation vector, in world axes, that turns the axes `a` (columns) into `b`; and its strain."""
    sines = ZERO
    cosines: Number = 0.0
    for k in range(3):
        sines = add(sines, cross(column(a, k), column(b, k)))
        cosines = cosines + dot(column(a, k), column(b, k))
    return _along(scale(0.5, sines), 0.5 * (cosines - 1.0))


def leaning(a: Vector, b: Vector) -> tuple[Vector, Number]:
    """Rotation vector that turns one unit vector the shortest way into another; and its strain."""
    return _along(cross(a, b), dot(a, b))


def _along(sines: Vector, cosine: Number) -> tuple[Vector, Number]:
    """A rotation vector from the sine along its axis and the cosine; and its strain."""
    sine = size_of(sines)
    strain = functions.where_less(cosine, 0.0, 1.0 / sine, 1.0)
    return scale(functions.atan2(sine, cosine) / sine, sines), strain
