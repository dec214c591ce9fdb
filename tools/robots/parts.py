"""What a robot under urdf/ is made of: shapes, inertias, links, joints, cuts, homes and variants.

Plain values only; `write` turns them into URDF and loops.toml.  SI units and radians throughout.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import atan2, hypot, pi, sqrt

Vector = tuple[float, float, float]
Colour = tuple[float, float, float, float]

ZERO: Vector = (0.0, 0.0, 0.0)

# The colours of Okabe and Ito, which people with any kind of colour vision can tell apart, and greys.
COLOURS: Mapping[str, Colour] = {
    "base": (0.55, 0.57, 0.60, 1.0),
    "dark": (0.22, 0.23, 0.25, 1.0),
    "light": (0.80, 0.81, 0.83, 1.0),
    "orange": (0.902, 0.624, 0.0, 1.0),
    "sky": (0.337, 0.706, 0.914, 1.0),
    "green": (0.0, 0.620, 0.451, 1.0),
    "yellow": (0.941, 0.894, 0.259, 1.0),
    "blue": (0.0, 0.447, 0.698, 1.0),
    "vermilion": (0.835, 0.369, 0.0, 1.0),
    "purple": (0.800, 0.475, 0.655, 1.0),
}


def add(a: Vector, b: Vector) -> Vector:
    """Sum of two vectors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def scale(s: float, a: Vector) -> Vector:
    """`s` times `a`."""
    return (s * a[0], s * a[1], s * a[2])


@dataclass(frozen=True)
class Shape:
    """A visual: box (x, y, z), cylinder (radius, length along z) or sphere (radius,), placed in the link frame."""

    kind: str
    size: tuple[float, ...]
    colour: str
    xyz: Vector = ZERO
    rpy: Vector = ZERO


def box(size: Vector, colour: str, xyz: Vector = ZERO, rpy: Vector = ZERO) -> Shape:
    """A box with the edge lengths `size`."""
    return Shape("box", size, colour, xyz, rpy)


def ball(radius: float, colour: str, xyz: Vector = ZERO) -> Shape:
    """A sphere."""
    return Shape("sphere", (radius,), colour, xyz)


def rod(a: Vector, b: Vector, radius: float, colour: str) -> Shape:
    """A cylinder from `a` to `b`."""
    d = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
    return Shape("cylinder", (radius, sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2)), colour, scale(0.5, add(a, b)), along(d))


def bar(a: Vector, b: Vector, section: tuple[float, float], colour: str) -> Shape:
    """A box from `a` to `b`; `section` is its size along the x and y axes that `along` turns."""
    d = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
    length = sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2)
    return Shape("box", (*section, length), colour, scale(0.5, add(a, b)), along(d))


def along(d: Vector) -> Vector:
    """Roll, pitch, yaw that turn the z axis into the direction of `d` (no roll)."""
    return (0.0, atan2(hypot(d[0], d[1]), d[2]), atan2(d[1], d[0]) if hypot(d[0], d[1]) > 0.0 else 0.0)


@dataclass(frozen=True)
class Inertial:
    """Mass, centre of mass in the link frame and inertia (ixx, iyy, izz, ixy, ixz, iyz) about it, along the link axes.

    Raises:
        ValueError: no rigid body has these values.
    """

    mass: float
    com: Vector = ZERO
    inertia: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        ixx, iyy, izz, *products = self.inertia
        if any(products):
            raise ValueError(f"the robots here have their link axes along principal axes, found products {products}")
        largest = max(ixx, iyy, izz)
        if not (self.mass > 0.0 and min(ixx, iyy, izz) >= 0.0 and ixx + iyy + izz >= 2.0 * largest * (1.0 - 1e-12)):
            raise ValueError(f"not a rigid body: mass {self.mass} kg, principal moments {(ixx, iyy, izz)} kg m2")


AXES = {"x": 0, "y": 1, "z": 2}


def slender(mass: float, length: float, radius: float, axis: str, start: Vector = ZERO, sign: int = 1) -> Inertial:
    """A slender uniform rod from `start` along `axis`: m l^2 / 12 across, m r^2 / 2 about itself."""
    return _rod(mass, length, axis, start, sign, across=mass * length**2 / 12.0, about=0.5 * mass * radius**2)


def dumbbell(mass: float, length: float, axis: str, start: Vector = ZERO, sign: int = 1) -> Inertial:
    """Half of `mass` at each end of a massless rod: m l^2 / 4 across, none about itself."""
    return _rod(mass, length, axis, start, sign, across=mass * length**2 / 4.0, about=0.0)


def _rod(mass: float, length: float, axis: str, start: Vector, sign: int, across: float, about: float) -> Inertial:
    """A body of revolution about `axis` with its centre half a length from `start`."""
    i = AXES[axis]
    com = [start[0], start[1], start[2]]
    com[i] += sign * 0.5 * length
    moments = [across, across, across]
    moments[i] = about
    return Inertial(mass, (com[0], com[1], com[2]), (moments[0], moments[1], moments[2], 0.0, 0.0, 0.0))


def block(mass: float, size: Vector, com: Vector = ZERO) -> Inertial:
    """A uniform box."""
    x, y, z = (s**2 for s in size)
    f = mass / 12.0
    return Inertial(mass, com, (f * (y + z), f * (x + z), f * (x + y), 0.0, 0.0, 0.0))


def disc(mass: float, radius: float, thickness: float, axis: str, com: Vector = ZERO) -> Inertial:
    """A uniform solid cylinder about `axis`."""
    across = mass * (3.0 * radius**2 + thickness**2) / 12.0
    moments = [across, across, across]
    moments[AXES[axis]] = 0.5 * mass * radius**2
    return Inertial(mass, com, (moments[0], moments[1], moments[2], 0.0, 0.0, 0.0))


@dataclass(frozen=True)
class Link:
    """A body: inertia (None: massless) and looks."""

    name: str
    inertial: Inertial | None = None
    visuals: tuple[Shape, ...] = ()


@dataclass(frozen=True)
class Joint:
    """A joint of the open tree."""

    name: str
    type: str
    parent: str
    child: str
    xyz: Vector = ZERO
    rpy: Vector = ZERO
    axis: Vector = ZERO
    lower: float = -2.0 * pi
    upper: float = 2.0 * pi
    effort: float = 0.0
    velocity: float = 50.0


@dataclass(frozen=True)
class Frame:
    """A frame on a link."""

    link: str
    xyz: Vector = ZERO
    rpy: Vector = ZERO


@dataclass(frozen=True)
class Cut:
    """A cut joint between two frames."""

    name: str
    type: str
    a: Frame
    b: Frame


@dataclass(frozen=True)
class Home:
    """Exact actuated coordinates and rough passive ones."""

    name: str
    about: str
    actuated: Mapping[str, float]
    passive: Mapping[str, float | tuple[float, ...]]


@dataclass(frozen=True)
class Variant:
    """Inertias that replace those of the tree."""

    name: str
    about: str
    inertials: Mapping[str, Inertial] = field(default_factory=dict)


@dataclass(frozen=True)
class Robot:
    """Everything that urdf/<name>/ says."""

    name: str
    title: str
    source: str
    notes: tuple[str, ...]
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    cuts: tuple[Cut, ...]
    actuators: tuple[str, ...]
    homes: tuple[Home, ...]
    tool: str = "tool"
    gravity: Vector = (0.0, 0.0, -9.81)
    variants: tuple[Variant, ...] = ()
