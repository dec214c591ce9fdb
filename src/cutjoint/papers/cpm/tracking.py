"""Following the tool of the CPM with rotary motors while the motors turn, without ever leaving the branch.

With the elbows moved by a distance d in all (root of the sum of squares) from a closed posture, the errors of (3), (6),
(9) at the old tool are at most L2 d + d^2 / 2, the rods' matrix E changes by at most d, and the second derivatives of
the errors are below sqrt(2).  By the theorem of Newton and Kantorovich a solution exists near the old tool, is the only
one around, and E stays regular on the whole way there, as long as

    sqrt(2) (L2 d + d^2 / 2) <= (s - d)^2 / 2,    s the smallest singular value of E

Steps of this size therefore stay on the branch, and stop only before a singularity of type 2.
"""

from __future__ import annotations

from math import cos, dist, hypot, inf, sin, sqrt
from typing import NamedTuple

from cutjoint.papers.cpm.parameters import CpmParameters

Triple = tuple[float, float, float]

NEWTON_STEPS = 30
"""Newton converges quadratically within the bound above: five steps are usual."""

MOST_STEPS = 20000
"""Steps after which a way counts as one along a singularity; ways that run into one take some hundreds."""

SAFETY = 0.9
"""Fraction of the largest proved step that is taken."""


class Track(NamedTuple):
    """Where a way ended: the tool there [m], the fraction of the way, 1 at the target, and the volume of the second
    rods' directions there, the type-2 measure without its sign."""

    tool: Triple
    progress: float
    measure: float


def walk(p: CpmParameters, limit: float, angles: Triple, tool: Triple, target: Triple) -> Track:
    """Turn the motors from `angles` to `target` [rad] on a straight way, the tool starting at `tool` [m].

    The walk ends where the volume of the second rods' directions is less than `limit`.
    """
    length = p.L1 * dist(angles, target)  # no elbow's chord is longer than its arc
    done = measure = 0.0
    for _ in range(MOST_STEPS):
        rods = _Rods.at(p, _between(angles, target, done), tool)
        measure = abs(rods.volume) / p.L2**3
        if done >= 1.0 or measure < limit:
            break
        step = SAFETY * _proved(rods.smallest(), p.L2)
        done = 1.0 if length * (1.0 - done) <= step else done + step / length
        tool = _settled(p, _between(angles, target, done), tool)
    return Track(tool, done, measure)


def _between(angles: Triple, target: Triple, done: float) -> Triple:
    one, two, three = (a + done * (b - a) for a, b in zip(angles, target, strict=True))
    return (one, two, three) if done < 1.0 else target


def _proved(smallest: float, rod: float) -> float:
    """The largest d of the bound: (sqrt(2) - 1) d^2 + 2 (s + sqrt(2) L2) d = s^2, without cancellation."""
    half = smallest + sqrt(2.0) * rod
    return smallest * smallest / (half + sqrt(half * half + (sqrt(2.0) - 1.0) * smallest * smallest))


def _settled(p: CpmParameters, angles: Triple, tool: Triple) -> Triple:
    """Newton's method on (3), (6), (9), to rounding."""
    x, y, z = tool
    last, unit = inf, p.L2
    for _ in range(NEWTON_STEPS):
        dx, dy, dz = _Rods.at(p, angles, (x, y, z)).newton(unit * unit)
        x, y, z = x - dx, y - dy, z - dz
        size = max(abs(dx), abs(dy), abs(dz))
        if size < 1e-15 * unit or (size < 1e-9 * unit and size >= 0.5 * last):
            break
        last = size
    return (x, y, z)


class _Rods(NamedTuple):
    """The rows (0, a, b), (c, 0, d), (e, f, 0) of E: second rods from their elbows to the tool [m]."""

    a: float
    b: float
    c: float
    d: float
    e: float
    f: float

    @classmethod
    def at(cls, p: CpmParameters, angles: Triple, tool: Triple) -> _Rods:
        """With the motors at `angles` [rad] and the tool at `tool` [m], whether that closes the loops or not."""
        (one, two, three), (x, y, z) = angles, tool
        return cls(
            y - p.L - p.L1 * cos(one),
            z - p.L1 * sin(one),
            x - p.L - p.L1 * sin(two),
            z - p.L1 * cos(two),
            x - p.L1 * cos(three),
            y - p.D + p.L + p.L1 * sin(three),
        )

    @property
    def volume(self) -> float:
        """det E [m3]."""
        return self.a * self.d * self.e + self.b * self.c * self.f

    def _adjugate(self) -> tuple[float, ...]:
        a, b, c, d, e, f = self
        return (-d * f, b * f, a * d, d * e, -b * e, b * c, c * f, a * e, -a * c)

    def smallest(self) -> float:
        """A lower bound of the smallest singular value [m]: one over the root of the sum of squares of the inverse."""
        return abs(self.volume) / hypot(*self._adjugate())

    def newton(self, square: float) -> Triple:
        """Newton's step on half of |e_i|^2 less `square`."""
        a, b, c, d, e, f = self
        r1, r2, r3 = (0.5 * (u * u + w * w - square) for u, w in ((a, b), (c, d), (e, f)))
        k = self._adjugate()
        volume = self.volume
        return (
            (k[0] * r1 + k[1] * r2 + k[2] * r3) / volume,
            (k[3] * r1 + k[4] * r2 + k[5] * r3) / volume,
            (k[6] * r1 + k[7] * r2 + k[8] * r3) / volume,
        )
