"""A robot's files as plain numbers: robot.urdf and loops.toml, read with nothing but the standard library and numpy.

Lengths in metres, angles in radians.  A frame is a rotation (3, 3) and a position (3,).  What is read here is what
docs/description.md promises: types of joints that only [joint.NAME] can say, mimics, inertias turned in their link,
variants.  A slip in a file is an assertion: this is a judge of right descriptions, not a checker of wrong ones.
"""

from __future__ import annotations

import tomllib
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from oracles.curves import Curve, natural_spline, power_series

Array = np.ndarray

COORDINATES = {
    "fixed": 0,
    "revolute": 1,
    "continuous": 1,
    "prismatic": 1,
    "universal": 2,
    "spherical": 3,
    "planar": 3,
    "floating": 6,
}
"""Velocities of every type of joint."""


@dataclass(frozen=True)
class Frame:
    """A rotation (3, 3) and a position (3,) in a link."""

    link: str
    rotation: Array = field(default_factory=lambda: np.eye(3))
    position: Array = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True)
class Body:
    """Mass [kg], centre of mass (3,) [m] in the link frame, inertia (3, 3) [kg m2] about it along the link axes."""

    mass: float = 0.0
    com: Array = field(default_factory=lambda: np.zeros(3))
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))


@dataclass(frozen=True)
class Joint:
    """A joint of the tree; `axis` and `axis2` are unit vectors in the child's frame."""

    name: str
    kind: str
    parent: str
    child: str
    rotation: Array
    position: Array
    axis: Array
    axis2: Array


@dataclass(frozen=True)
class Cut:
    """A cut joint between frames a and b; `length` [m] is that of a distance."""

    name: str
    kind: str
    a: Frame
    b: Frame
    length: float = 0.0


@dataclass(frozen=True)
class Coupling:
    """coordinate of `joint` = sum of curves of the drivers' coordinates + offset."""

    name: str
    joint: str
    curves: dict[str, Curve]
    offset: float


@dataclass(frozen=True)
class Robot:
    """All that the files say about the motion; joints from the root outwards."""

    name: str
    root: str
    bodies: dict[str, Body]
    joints: tuple[Joint, ...]
    cuts: tuple[Cut, ...]
    couplings: tuple[Coupling, ...]
    actuators: tuple[str, ...]
    gravity: Array
    tool: Frame | None


def rpy_rotation(rpy: Any) -> Array:
    """Rz(yaw) Ry(pitch) Rx(roll), shape (3, 3)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def read(path: Path | str, variant: str | None = None) -> Robot:
    """The robot of a folder with a loops.toml, of such a file, or of a plain URDF (a chain without cuts)."""
    path = Path(path)
    path = path / "loops.toml" if path.is_dir() else path
    loops: dict[str, Any] = {}
    if path.suffix == ".toml":
        loops = tomllib.loads(path.read_text(encoding="utf-8"))
        path = path.parent / loops["urdf"]
    tree = ET.parse(path).getroot()
    bodies = {link.get("name"): _body(link.find("inertial")) for link in tree.findall("link")}
    if variant is not None:
        for link, values in loops["variant"][variant].get("inertial", {}).items():
            com = np.array(values.get("com", [0.0] * 3))
            bodies[link] = Body(float(values["mass"]), com, _moments(values["inertia"]))
    changes = loops.get("joint", {})
    joints = [_joint(element, changes.get(element.get("name"), {})) for element in tree.findall("joint")]
    assert set(changes) <= {joint.name for joint in joints}
    mimics = [one for element in tree.findall("joint") if (one := _mimic(element)) is not None]
    gears = [_coupling(one) for one in loops.get("coupling", [])]
    driven = {one.joint for one in (*mimics, *gears)}
    plain = [j.name for j in joints if COORDINATES[j.kind] == 1 and j.name not in driven]
    root, ordered = _outwards(bodies, joints)
    return Robot(
        name=loops.get("name", tree.get("name")),
        root=root,
        bodies=bodies,
        joints=ordered,
        cuts=tuple(
            Cut(c["name"], c["type"], *map(_frame, c["frames"]), float(c.get("length", 0.0)))
            for c in loops.get("cut", [])
        ),
        couplings=(*mimics, *gears),
        actuators=tuple(loops.get("actuators", plain)),
        gravity=np.array(loops.get("gravity", [0.0, 0.0, -9.81]), dtype=float),
        tool=_frame(loops["tool"]["frame"]) if "tool" in loops else None,
    )


def _numbers(text: str) -> Array:
    return np.array([float(word) for word in text.split()])


def _origin(element: ET.Element | None) -> tuple[Array, Array]:
    origin = None if element is None else element.find("origin")
    if origin is None:
        return np.eye(3), np.zeros(3)
    return rpy_rotation(_numbers(origin.get("rpy", "0 0 0"))), _numbers(origin.get("xyz", "0 0 0"))


def _moments(values: Any) -> Array:
    xx, yy, zz, xy, xz, yz = (float(value) for value in values)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _body(inertial: ET.Element | None) -> Body:
    if inertial is None or not float(inertial.find("mass").get("value")):
        return Body()
    rotation, position = _origin(inertial)
    inertia = inertial.find("inertia")
    moments = _moments([inertia.get(key, "0") for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")])
    return Body(float(inertial.find("mass").get("value")), position, rotation @ moments @ rotation.T)


def _unit(values: Any) -> Array:
    vector = np.array(values, dtype=float)
    return vector / np.linalg.norm(vector)


def _joint(element: ET.Element, change: dict[str, Any]) -> Joint:
    rotation, position = _origin(element)
    kind = change.get("type", element.get("type"))
    axis = element.find("axis")
    own = _numbers(axis.get("xyz")) if axis is not None else [1.0, 0.0, 0.0]
    joint = Joint(
        name=element.get("name"),
        kind=kind,
        parent=element.find("parent").get("link"),
        child=element.find("child").get("link"),
        rotation=rotation,
        position=position,
        axis=_unit(change.get("axis", own)),
        axis2=_unit(change.get("axis2", [0.0, 1.0, 0.0])),
    )
    assert kind in COORDINATES, kind
    assert kind != "universal" or abs(joint.axis @ joint.axis2) < 1e-12
    return joint


def _mimic(element: ET.Element) -> Coupling | None:
    mimic = element.find("mimic")
    if mimic is None or element.get("type") == "fixed":
        return None
    name = element.get("name")
    ratio, offset = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
    return Coupling(f"{name}_mimic", name, {mimic.get("joint"): power_series(0.0, ratio)}, offset)


def _coupling(given: dict[str, Any]) -> Coupling:
    """A [[coupling]]: one driver with a ratio, a polynomial or a table; several with a ratio each; `drives`; or none."""
    drivers = given.get("driver", [])
    if "drives" in given:
        curves = {one["driver"]: _curve(one) for one in given["drives"]}
    elif isinstance(drivers, list):
        ratios = given.get("ratio", [1.0] * len(drivers))
        curves = {name: power_series(0.0, ratio) for name, ratio in zip(drivers, ratios, strict=True)}
    else:
        curves = {drivers: _curve(given)}
    return Coupling(given["name"], given["joint"], curves, float(given.get("offset", 0.0)))


def _curve(given: dict[str, Any]) -> Curve:
    if "table" in given:
        return natural_spline(given["table"])
    return power_series(*given.get("polynomial", (0.0, given.get("ratio", 1.0))))


def _frame(value: Any) -> Frame:
    if isinstance(value, str):
        return Frame(value)
    return Frame(value["link"], rpy_rotation(value.get("rpy", [0.0] * 3)), np.array(value.get("xyz", [0.0] * 3), float))


def _outwards(bodies: dict[str, Body], joints: list[Joint]) -> tuple[str, tuple[Joint, ...]]:
    children = {joint.child for joint in joints}
    (root,) = (link for link in bodies if link not in children)
    reached, ordered, left = {root}, [], list(joints)
    while left:
        ready = [joint for joint in left if joint.parent in reached]
        assert ready, "joints that no link of the tree carries"
        ordered += ready
        reached |= {joint.child for joint in ready}
        left = [joint for joint in left if joint.child not in reached]
    return root, tuple(ordered)
