"""Builders of what a robot under urdf/ is made of, as values of `cutjoint.description`.  SI units and radians.

Numbers lose their noise around zero.  Angles are remembered beside the matrices that they become, so that `write` can
say them as they were given.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2, hypot, pi, sqrt

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description import CutJoint, CutType, Frame, Home, Inertial, Joint, JointType, Limits, Shape
from cutjoint.description.formats.common.exact import words
from cutjoint.description.transforms import placement, rpy_from_rotation

Vector = tuple[float, float, float]
Rough = Mapping[str, float | tuple[float, ...]]

ZERO: Vector = (0.0, 0.0, 0.0)
GIVEN: dict[str, Vector] = {}
"""Roll, pitch and yaw as a writer would find them again -> as they were given."""

# The colours of Okabe and Ito, which people with any kind of colour vision can tell apart, and greys.
COLOURS: Mapping[str, tuple[float, float, float, float]] = {
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


def clean(value: float) -> float:
    """`value` up to its last two bits, with as few digits as that takes; noise around zero is zero."""
    short = float(f"{value:.13g}")
    return 0.0 if abs(value) < 1e-16 else short if abs(short - value) <= 4e-16 * abs(value) else float(value)


def at(xyz: Vector = ZERO, rpy: Vector = ZERO) -> Array:
    """A placement (4, 4)."""
    angles = (clean(rpy[0]), clean(rpy[1]), clean(rpy[2]))
    matrix = placement([clean(x) for x in xyz], angles)
    GIVEN[words(rpy_from_rotation(matrix[:3, :3]))] = angles
    return matrix


def add(a: Vector, b: Vector) -> Vector:
    """Sum of two vectors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def scale(s: float, a: Vector) -> Vector:
    """`s` times `a`."""
    return (s * a[0], s * a[1], s * a[2])


def shape(kind: str, size: tuple[float, ...], colour: str, xyz: Vector = ZERO, rpy: Vector = ZERO) -> Shape:
    """A visual shape in the link frame."""
    return Shape(kind, tuple(clean(x) for x in size), at(xyz, rpy), COLOURS[colour])


def box(size: Vector, colour: str, xyz: Vector = ZERO, rpy: Vector = ZERO) -> Shape:
    """A box with the edge lengths `size`."""
    return shape("box", size, colour, xyz, rpy)


def ball(radius: float, colour: str, xyz: Vector = ZERO) -> Shape:
    """A sphere."""
    return shape("sphere", (radius,), colour, xyz)


def rod(a: Vector, b: Vector, radius: float, colour: str) -> Shape:
    """A cylinder from `a` to `b`."""
    d = add(b, scale(-1.0, a))
    return shape("cylinder", (radius, sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2)), colour, scale(0.5, add(a, b)), along(d))


def bar(a: Vector, b: Vector, section: tuple[float, float], colour: str) -> Shape:
    """A box from `a` to `b`; `section` is its size along the x and y axes that `along` turns."""
    d = add(b, scale(-1.0, a))
    return shape("box", (*section, sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2)), colour, scale(0.5, add(a, b)), along(d))


def along(d: Vector) -> Vector:
    """Roll, pitch, yaw that turn the z axis into the direction of `d` (no roll)."""
    return (0.0, atan2(hypot(d[0], d[1]), d[2]), atan2(d[1], d[0]) if hypot(d[0], d[1]) > 0.0 else 0.0)


def rigid(mass: float, com: Vector, moments: Vector) -> Inertial:
    """Mass, centre of mass and moments of inertia about it, along the link's axes, which are principal.

    Raises:
        ValueError: no rigid body has these values.
    """
    if not (mass > 0.0 and min(moments) >= 0.0 and sum(moments) >= 2.0 * max(moments) * (1.0 - 1e-12)):
        raise ValueError(f"not a rigid body: mass {mass} kg, principal moments {moments} kg m2")
    return Inertial(clean(mass), np.array([clean(x) for x in com]), np.diag([clean(x) for x in moments]))


def slender(mass: float, length: float, radius: float, axis: str, sign: int = 1) -> Inertial:
    """A slender uniform rod from the origin along `axis`: m l^2 / 12 across, m r^2 / 2 about itself."""
    return _rod(mass, length, axis, sign, across=mass * length**2 / 12.0, about=0.5 * mass * radius**2)


def dumbbell(mass: float, length: float, axis: str) -> Inertial:
    """Half of `mass` at each end of a massless rod: m l^2 / 4 across, none about itself."""
    return _rod(mass, length, axis, 1, across=mass * length**2 / 4.0, about=0.0)


def _rod(mass: float, length: float, axis: str, sign: int, across: float, about: float) -> Inertial:
    """A body of revolution about `axis` with its centre half a length from the origin."""
    x, y, z = (float(axis == one) for one in "xyz")
    return rigid(mass, scale(sign * 0.5 * length, (x, y, z)), _about(axis, about, across))


def _about(axis: str, about: float, across: float) -> Vector:
    x, y, z = (about if axis == one else across for one in "xyz")
    return (x, y, z)


def block(mass: float, size: Vector, com: Vector = ZERO) -> Inertial:
    """A uniform box."""
    x, y, z = (s**2 for s in size)
    f = mass / 12.0
    return rigid(mass, com, (f * (y + z), f * (x + z), f * (x + y)))


def disc(mass: float, radius: float, thickness: float, axis: str) -> Inertial:
    """A uniform solid cylinder about `axis`."""
    return rigid(mass, ZERO, _about(axis, 0.5 * mass * radius**2, mass * (3.0 * radius**2 + thickness**2) / 12.0))


def joint(
    name: str, kind: str, parent: str, child: str, xyz: Vector = ZERO, rpy: Vector = ZERO, axis: Vector = ZERO,
    lower: float = -2.0 * pi, upper: float = 2.0 * pi, effort: float = 0.0, velocity: float = 50.0,
) -> Joint:  # fmt: skip
    """A joint of the open tree."""
    made = Joint(name, JointType(kind), parent, child, at(xyz, rpy))
    if not made.type.limited:
        return made
    limits = Limits(clean(lower), clean(upper), clean(velocity), clean(effort))
    return Joint(name, made.type, parent, child, made.placement, np.array(axis), limits=limits)


def frame(link: str, xyz: Vector = ZERO) -> Frame:
    """A frame on a link."""
    return Frame(link, at(xyz))


def cut(name: str, kind: str, a: Frame, b: Frame) -> CutJoint:
    """A cut joint between two frames."""
    return CutJoint(name, CutType(kind), a, b)


def posture(name: str, about: str, actuated: Mapping[str, float], passive: Rough) -> Home:
    """A home: exact actuated coordinates, passive ones to four decimals."""
    rough: dict[str, float | tuple[float, ...]] = {
        one: tuple(clean(round(x, 4)) for x in value) if isinstance(value, tuple) else clean(round(value, 4))
        for one, value in passive.items()
    }
    return Home(name, {one: clean(value) for one, value in actuated.items()}, rough, about)
