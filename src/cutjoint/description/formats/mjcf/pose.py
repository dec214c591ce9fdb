"""Positions and orientations in MJCF: pos with quat, axisangle, xyaxes, zaxis or euler, in degrees or radians."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.findings import Findings
from cutjoint.description.numbers import read_numbers
from cutjoint.description.transforms import from_rotation, rotation_from_quaternion
from cutjoint.description.xml import Element

ORIENTATIONS = {"quat": 4, "axisangle": 4, "xyaxes": 6, "zaxis": 3, "euler": 3}
_TINY = 1e-9


@dataclass(frozen=True)
class AngleUnits:
    """What `<compiler>` says about angles.  `order` is the Euler sequence: lower case turns about the moved axes."""

    degrees: bool = True
    order: str = "xyz"

    def angle(self, value: float) -> float:
        """An angle of the file in radians."""
        return math.radians(value) if self.degrees else value


def read_placement(element: Element, get: dict[str, str], units: AngleUnits, what: str, findings: Findings) -> Array:
    """The placement (4, 4) that pos and one orientation give; `get` holds the attributes with defaults filled in."""
    line = element.sourceline
    position = read_numbers(get.get("pos", "0 0 0"), 3, f"pos of {what}", findings, line) or (0.0, 0.0, 0.0)
    given = [key for key in ORIENTATIONS if key in get]
    if len(given) > 1:
        findings.error(f"{what} with {' and '.join(given)}", "one orientation", "keep one", line)
    if not given:
        return from_rotation(np.eye(3), position)
    values = read_numbers(get[given[0]], ORIENTATIONS[given[0]], f"{given[0]} of {what}", findings, line)
    rotation = None if values is None else _rotation(given[0], np.array(values), units)
    if values is not None and rotation is None:
        shown = " ".join(f"{value:g}" for value in values)
        findings.error(f"{given[0]} of {what} is {shown}", "a rotation", "", line)
    return from_rotation(np.eye(3) if rotation is None else rotation, position)


def _rotation(kind: str, values: Array, units: AngleUnits) -> Array | None:
    match kind:
        case "quat":
            return rotation_from_quaternion(values) if np.linalg.norm(values) > _TINY else None
        case "axisangle":
            if np.linalg.norm(values[:3]) < _TINY:
                return None
            return turn(values[:3], units.angle(float(values[3])))
        case "zaxis":
            return _shortest(values) if np.linalg.norm(values) > _TINY else None
        case "xyaxes":
            return _from_axes(values[:3], values[3:])
    rotation = np.eye(3)
    for letter, value in zip(units.order, values, strict=True):
        step = turn(np.eye(3)["xyz".index(letter.lower())], units.angle(float(value)))
        rotation = rotation @ step if letter.islower() else step @ rotation
    return rotation


def turn(axis: Array, angle: float) -> Array:
    """Rotation (3, 3) by an angle [rad] about an axis of any length but zero."""
    unit = axis / np.linalg.norm(axis)
    return rotation_from_quaternion([math.cos(0.5 * angle), *(math.sin(0.5 * angle) * unit)])


def _shortest(direction: Array) -> Array:
    """The smallest turn that brings z to `direction`."""
    z = direction / np.linalg.norm(direction)
    axis = np.cross([0.0, 0.0, 1.0], z)
    sine = float(np.linalg.norm(axis))
    if sine < _TINY:
        return np.eye(3) if z[2] > 0.0 else turn(np.array([1.0, 0.0, 0.0]), math.pi)
    return turn(axis, math.atan2(sine, float(z[2])))


def _from_axes(x: Array, y: Array) -> Array | None:
    if np.linalg.norm(x) < _TINY:
        return None
    x = x / np.linalg.norm(x)
    y = y - (y @ x) * x
    if np.linalg.norm(y) < _TINY:
        return None
    y = y / np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])
