"""What elements of MJCF share: attributes taken from a class of defaults (their own, that of the body around them, or
main), and placements: pos with quat, axisangle, xyaxes, zaxis or euler, in degrees or radians."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.findings import Findings, nearest
from cutjoint.description.numbers import read_numbers
from cutjoint.description.transforms import from_rotation, rotation_from_quaternion
from cutjoint.description.xml import Element, children


class Defaults:
    """The tree of `<default>` classes of a file."""

    def __init__(self, root: Element, findings: Findings) -> None:
        self.findings = findings
        self._classes: dict[str, dict[str, dict[str, str]]] = {"main": {}}
        for element in children(root, "default"):
            self._read(element, str(element.get("class") or "main"), {})

    def _read(self, element: Element, name: str, above: dict[str, dict[str, str]]) -> None:
        own = {tag: dict(values) for tag, values in (above or self._classes.get(name, {})).items()}
        for child in children(element):
            if child.tag != "default":
                tag = _shared(child)
                own[tag] = own.get(tag, {}) | {str(k): str(v) for k, v in child.attrib.items()}
        self._classes[name] = own
        for child in children(element, "default"):
            inner = str(child.get("class") or "")
            if not inner:
                self.findings.error("<default> without class", '<default class="...">', "", child.sourceline)
                continue
            self._read(child, inner, own)

    def attributes(self, element: Element, childclass: str) -> dict[str, str]:
        """The attributes of an element with those of its class filled in."""
        name = str(element.get("class") or childclass or "main")
        if name not in self._classes:
            found = f"unknown class '{name}'"
            self.findings.error(found, "a class of <default>", nearest(name, self._classes), element.sourceline)
            name = "main"
        own = {str(key): str(value) for key, value in element.attrib.items()}
        inherited = self._classes[name].get(_shared(element), {})
        if set(own) & _ORIENTED:
            inherited = {key: value for key, value in inherited.items() if key not in _ORIENTED}
        return inherited | own


_ACTUATORS = {"general", "motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "adhesion"}


def _shared(element: Element) -> str:
    """What an element's defaults are kept under: all kinds of actuators have the same ones, as have tendons."""
    if element.tag in _ACTUATORS:
        return "general"
    return "tendon" if element.tag in ("spatial", "fixed") else str(element.tag)


_ORIENTED = {"quat", "axisangle", "xyaxes", "zaxis", "euler"}


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
