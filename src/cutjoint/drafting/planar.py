"""Flat links: bars in layers above a plane, so that they pass one another, with pins through them.

The plane is the local x-y plane, hinges turn about the local z axis.  `UPRIGHT` turns it where it meets the base: local
x is the world's x, local y points up, and positive angles are counterclockwise as seen from the world's -y.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import acos, atan2, cos, hypot, pi, sin

import numpy as np

from cutjoint.drafting.sketch import LinkSketch, Solid, Tie, Vector, bar, box, rod

UPRIGHT: Vector = (0.5 * pi, 0.0, 0.0)
UPRIGHT_NOTE = "It stands in the x-z plane; angles count from x towards z, which points up."
Point = tuple[float, float]


@dataclass(frozen=True)
class Plane:
    """How wide the bars are [m]; the rest of their section follows."""

    width: float

    @classmethod
    def of(cls, lengths: Sequence[float]) -> Plane:
        """Bars that look well for links of these lengths."""
        return cls(float(min(0.1 * np.exp(np.mean(np.log(lengths))), 0.5 * min(lengths))))

    @property
    def thick(self) -> float:
        """Thickness of a bar [m]."""
        return 0.45 * self.width

    def layer(self, k: int) -> float:
        """Height of layer `k` above the plane [m]."""
        return 1.16 * k * self.thick

    def at(self, point: Point, k: int) -> Vector:
        """A point of the plane in layer `k`."""
        return (point[0], point[1], self.layer(k))

    def bar(self, a: Point, b: Point, k: int, colour: str) -> Solid:
        """A bar between two points."""
        return bar(self.at(a, k), self.at(b, k), (self.thick, self.width), colour)

    def end(self, at: Point, k: int, colour: str) -> Solid:
        """The round end of a bar."""
        x, y, h = self.at(at, k)
        return rod((x, y, h - 0.5 * self.thick), (x, y, h + 0.5 * self.thick), 0.5 * self.width, colour)

    def pin(self, at: Point, low: int, high: int) -> Solid:
        """A pin through the layers `low` to `high`."""
        (x, y, a), b = self.at(at, low), self.layer(high)
        return rod((x, y, a - 0.75 * self.thick), (x, y, b + 0.75 * self.thick), 0.3 * self.width, "dark")

    def motor(self, at: Point, low: int, high: int) -> Solid:
        """A motor's body from layer `low` to `high`."""
        return rod(self.at(at, low), self.at(at, high), 1.1 * self.width, "dark")

    def link(self, name: str, about: str, length: float, k: int, colour: str, *more: Solid) -> LinkSketch:
        """A straight link along local x from its joint, and what else is to be seen on it."""
        ends = [self.end((x, 0.0), k, colour) for x in (0.0, length)]
        return LinkSketch(name, about, [self.bar((0.0, 0.0), (length, 0.0), k, colour)], [*ends, *more])

    def base(self, about: str, motors: Sequence[float], pins: Sequence[float] = ()) -> LinkSketch:
        """A rail behind the layers, with a block under each motor (world's x [m]) and a post under each pin."""
        w, back = self.width, -self.layer(-3)
        xs = [*motors, *pins]
        middle, wide = 0.5 * (min(xs) + max(xs)), max(xs) - min(xs) + 4.0 * w
        rail = box((wide, 2.0 * w, 0.8 * w), "grey", (middle, back, -2.0 * w))
        posts = [box((1.2 * w, w, 2.0 * w), "grey", (x, back, -0.9 * w)) for x in xs]
        return LinkSketch("base", about, (), [rail, *posts])


def hinge(
    name: str,
    parent: str,
    child: str,
    at: Point,
    about: str = "",
    *,
    on_base: bool = False,
    limits: tuple[float, float] | None = None,
    driven: bool = False,
) -> Tie:
    """A hinge at a point of the parent's plane, or of the base's x-z plane; without limits it goes round."""
    place = (at[0], 0.0, at[1]) if on_base else (at[0], at[1], 0.0)
    kind = "continuous" if limits is None else "revolute"
    rpy = UPRIGHT if on_base else (0.0, 0.0, 0.0)
    return Tie(name, kind, parent, child, about, place, rpy, limits=limits, driven=driven)


def meet(a: Point, b: Point, from_a: float, from_b: float, sign: int) -> Point:
    """The point at these distances from two others; with `sign` +1 to the left of the way from `a` to `b`.

    Raises:
        ValueError: there is none.
    """
    dx, dy = b[0] - a[0], b[1] - a[1]
    r = hypot(dx, dy)
    angle = atan2(dy, dx) + sign * acos((r * r + from_a**2 - from_b**2) / (2.0 * from_a * r))
    return (a[0] + from_a * cos(angle), a[1] + from_a * sin(angle))


def angle_of(a: Point, b: Point) -> float:
    """Angle of the way from `a` to `b`."""
    return atan2(b[1] - a[1], b[0] - a[0])


def wrapped(angle: float) -> float:
    """The same angle from -pi to pi."""
    return (angle + pi) % (2.0 * pi) - pi
