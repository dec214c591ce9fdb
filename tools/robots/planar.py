"""Shared by the planar linkages: flat links in the local x-y plane that turn about the local z axis.

A linkage that stands upright has its plane turned by `UPRIGHT` where it meets the base: local x is the world's x, local
y points up, and positive angles are counterclockwise as seen from the world's -y.
"""

from __future__ import annotations

from math import acos, atan2, cos, hypot, pi, sin

from cutjoint.description import Home, Joint, Link, Shape
from robots.parts import Vector, add, bar, joint, posture, rod, slender

UPRIGHT: Vector = (0.5 * pi, 0.0, 0.0)
AXIS: Vector = (0.0, 0.0, 1.0)
THICK, WIDTH, RADIUS = 0.012, 0.026, 0.01

Point = tuple[float, float]


def layer(k: int) -> float:
    """Height of layer `k` above the plane, so that links pass one another."""
    return k * (THICK + 0.002)


def flat_bar(length: float, k: int, colour: str, start: float = 0.0) -> tuple[Shape, ...]:
    """A bar with round ends along local x in layer `k`."""
    h = layer(k)
    a, b = (start, 0.0, h), (length, 0.0, h)
    ends = (rod(add(p, (0.0, 0.0, -0.5 * THICK)), add(p, (0.0, 0.0, 0.5 * THICK)), 0.5 * WIDTH, colour) for p in (a, b))
    return (bar(a, b, (THICK, WIDTH), colour), *ends)


def pin(at: Vector, low: int, high: int) -> Shape:
    """A pin along z through the layers `low` to `high`."""
    a, b = (at[0], at[1], layer(low) - 0.75 * THICK), (at[0], at[1], layer(high) + 0.75 * THICK)
    return rod(a, b, 0.3 * WIDTH, "dark")


def motor(at: Vector, low: int, high: int) -> Shape:
    """A motor's body about z at `at`, from layer `low` to `high`."""
    return rod((at[0], at[1], layer(low)), (at[0], at[1], layer(high)), 1.1 * WIDTH, "dark")


def link(name: str, mass: float, length: float, k: int, colour: str, *more: Shape) -> Link:
    """A slender uniform link along local x from its joint, and what else is to be seen on it."""
    return Link(name, slender(mass, length, RADIUS, "x"), (*flat_bar(length, k, colour), *more))


def hinge(name: str, parent: str, child: str, at: Vector, rpy: Vector = (0.0, 0.0, 0.0), effort: float = 0.0) -> Joint:
    """A revolute joint about local z; with `effort` it is a motor."""
    return joint(name, "revolute", parent, child, xyz=at, rpy=rpy, axis=AXIS, effort=effort)


def two_links(start: Point, end: Point, first: float, second: float, sign: int) -> tuple[float, float]:
    """Angles from the x axis of two links that join `start` to `end`; `sign` +1 turns the first counterclockwise."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    r = hypot(dx, dy)
    a = atan2(dy, dx) + sign * acos((r * r + first * first - second * second) / (2.0 * first * r))
    return a, atan2(dy - first * sin(a), dx - first * cos(a))


def wrapped(angle: float) -> float:
    """The same angle from -pi to pi."""
    return (angle + pi) % (2.0 * pi) - pi


def home(about: str, actuated: dict[str, float], passive: dict[str, float]) -> Home:
    """The home called default."""
    return posture("default", about, actuated, dict(passive))
