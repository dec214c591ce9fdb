"""What a template draws: solids, bodies, joints and cuts as plain values, before they become the text of two files.

SI units and radians.  A body's inertia comes from its solids and the density; what is only to be seen has no mass.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import atan2, hypot, pi

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.transforms import placement

Vector = tuple[float, float, float]
Coordinate = float | tuple[float, ...]
ZERO: Vector = (0.0, 0.0, 0.0)

COLOURS: Mapping[str, str] = {
    "grey": "0.55 0.57 0.60 1",
    "dark": "0.22 0.23 0.25 1",
    "light": "0.80 0.81 0.83 1",
    "orange": "0.90 0.62 0.00 1",
    "sky": "0.34 0.71 0.91 1",
    "green": "0.00 0.62 0.45 1",
    "yellow": "0.94 0.89 0.26 1",
    "blue": "0.00 0.45 0.70 1",
    "vermilion": "0.84 0.37 0.00 1",
    "purple": "0.80 0.48 0.65 1",
}
"""Those of Okabe and Ito, which people with any kind of colour vision can tell apart, and greys."""


@dataclass(frozen=True)
class Solid:
    """A box (x, y, z), a cylinder (radius, length along z) or a sphere (radius,) [m] in the frame of its link."""

    kind: str
    size: tuple[float, ...]
    colour: str
    xyz: Vector = ZERO
    rpy: Vector = ZERO

    @property
    def volume(self) -> float:
        """Its volume [m3]."""
        if self.kind == "box":
            return float(np.prod(self.size))
        r = self.size[0]
        return pi * r * r * self.size[1] if self.kind == "cylinder" else 4.0 / 3.0 * pi * r**3

    @property
    def moments(self) -> Array:
        """Inertia per mass about its middle, along its own axes, shape (3, 3) [m2]."""
        if self.kind == "box":
            x, y, z = (one * one for one in self.size)
            return np.diag([y + z, x + z, x + y]) / 12.0
        r2 = self.size[0] ** 2
        if self.kind == "sphere":
            return 0.4 * r2 * np.eye(3)
        across = (3.0 * r2 + self.size[1] ** 2) / 12.0
        return np.diag([across, across, 0.5 * r2])


@dataclass(frozen=True)
class LinkSketch:
    """A link: what it is, the solids that weigh, and what is only to be seen."""

    name: str
    about: str
    solids: Sequence[Solid] = ()
    looks: Sequence[Solid] = ()

    def inertial(self, density: float) -> tuple[float, Array, Array]:
        """Mass [kg], centre of mass (3,) [m] and inertia (3, 3) [kg m2] about it, for a density [kg/m3]."""
        masses = [density * one.volume for one in self.solids]
        mass = sum(masses)
        com = sum((m * np.array(one.xyz) for m, one in zip(masses, self.solids, strict=True)), np.zeros(3)) / mass
        inertia = np.zeros((3, 3))
        for m, one in zip(masses, self.solids, strict=True):
            axes = placement(ZERO, one.rpy)[:3, :3]
            d = np.array(one.xyz) - com
            inertia += m * (axes @ one.moments @ axes.T + float(d @ d) * np.eye(3) - np.outer(d, d))
        return mass, com, inertia


@dataclass(frozen=True)
class Tie:
    """A joint of the open tree.  `axis` is in its own frame; one that is `driven` has a motor."""

    name: str
    type: str
    parent: str
    child: str
    about: str = ""
    xyz: Vector = ZERO
    rpy: Vector = ZERO
    axis: Vector = (0.0, 0.0, 1.0)
    limits: tuple[float, float] | None = None
    driven: bool = False


@dataclass(frozen=True)
class Loop:
    """A cut joint between two points of links [m], with the axes of the links."""

    name: str
    type: str
    about: str
    a: tuple[str, Vector]
    b: tuple[str, Vector]


@dataclass(frozen=True)
class Sketch:
    """A robot of a template.

    Attributes:
        title, source: what it is, and where its design is from.
        notes: what the head of the URDF tells.
        bodies, ties: links and joints of the open tree.
        loops: the cut joints.
        tool: the link that is the tool.
        home, passive: exact actuated coordinates, and rough passive ones.
        about_home: what the posture looks like.
        mobility: how many ways it must be able to move.
    """

    title: str
    source: str
    notes: Sequence[str]
    bodies: Sequence[LinkSketch]
    ties: Sequence[Tie]
    loops: Sequence[Loop]
    tool: str
    home: Mapping[str, float]
    passive: Mapping[str, Coordinate]
    about_home: str
    mobility: int
    changes: Sequence[str] = field(default=())

    @property
    def driven(self) -> tuple[str, ...]:
        """The actuated joints."""
        return tuple(tie.name for tie in self.ties if tie.driven)


def box(size: Vector, colour: str, xyz: Vector = ZERO, rpy: Vector = ZERO) -> Solid:
    """A box with the edge lengths `size`."""
    return Solid("box", size, colour, xyz, rpy)


def ball(radius: float, colour: str, xyz: Vector = ZERO) -> Solid:
    """A sphere."""
    return Solid("sphere", (radius,), colour, xyz)


def rod(a: Vector, b: Vector, radius: float, colour: str) -> Solid:
    """A cylinder from `a` to `b`."""
    d, middle = _between(a, b)
    return Solid("cylinder", (radius, float(np.linalg.norm(d))), colour, middle, along(d))


def bar(a: Vector, b: Vector, section: tuple[float, float], colour: str) -> Solid:
    """A box from `a` to `b`; `section` is its size along the x and y axes that `along` turns."""
    d, middle = _between(a, b)
    return Solid("box", (*section, float(np.linalg.norm(d))), colour, middle, along(d))


def along(d: Vector) -> Vector:
    """Roll, pitch, yaw that turn the z axis into the direction of `d` (no roll)."""
    flat = hypot(d[0], d[1])
    return (0.0, atan2(flat, d[2]), atan2(d[1], d[0]) if flat > 0.0 else 0.0)


def _between(a: Vector, b: Vector) -> tuple[Vector, Vector]:
    """From `a` to `b`, and the middle."""
    d = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
    return d, (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2]))
