"""Geoms in MJCF as shapes, and the inertia of a body whose file gives geoms but no `<inertial>`.

MJCF counts half lengths: a box of size a is 2 a long.  Without mass a geom has density 1000 kg/m3, as in MuJoCo.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.findings import Findings
from cutjoint.description.formats.mjcf.pose import AngleUnits, read_placement
from cutjoint.description.model import Inertial, Shape
from cutjoint.description.numbers import LARGEST_MASS, read_numbers
from cutjoint.description.transforms import frame_along, from_rotation
from cutjoint.description.xml import Element

WATER = "1000"
_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}


@dataclass(frozen=True, eq=False)
class Geom:
    """A geom in the frame of its body; an ellipsoid, which is not drawn, has its three half axes as size."""

    shape: Shape
    mass: float | None
    density: float
    visual: bool


@dataclass(frozen=True)
class Mesh:
    """A mesh of `<asset>`."""

    file: Path
    scale: tuple[float, ...]


def read_geom(
    element: Element,
    get: dict[str, str],
    meshes: Mapping[str, Mesh | None],
    units: AngleUnits,
    body: str,
    findings: Findings,
) -> Geom | None:
    """One `<geom>`; None for planes, height fields and what cannot be read."""
    kind = get.get("type", "mesh" if "mesh" in get else "sphere")
    what = f"geom of body '{body}'" if "name" not in get else f"geom '{get['name']}'"
    line = element.sourceline
    if kind in ("plane", "hfield", "sdf"):
        return None
    if kind != "mesh" and kind not in _SIZES:
        findings.error(f"type '{kind}' of {what}", f"one of {', '.join([*_SIZES, 'mesh', 'plane'])}", "", line)
        return None
    mass = read_numbers(get["mass"], 1, f"mass of {what}", findings, line, LARGEST_MASS) if "mass" in get else None
    density = read_numbers(get.get("density", WATER), 1, f"density of {what}", findings, line) or (0.0,)
    colour = _colour(get, what, findings, line)
    placement = read_placement(element, get, units, what, findings)
    visual = get.get("contype", "1") == "0" and get.get("conaffinity", "1") == "0"
    mesh: Mesh | None = None
    if kind == "mesh":
        if get.get("mesh", "") not in meshes:
            findings.error(f"{what} names the unknown mesh '{get.get('mesh', '')}'", "a <mesh> of <asset>", "", line)
            return None
        mesh = meshes[get["mesh"]]
        if mesh is None:
            return None
        size: tuple[float, ...] | None = mesh.scale
    else:
        size, placement = _size(element, get, kind, placement, what, findings)
    if size is None:
        return None
    shape = Shape(kind, size, placement, colour, mesh.file if mesh else None, plain_name(get.get("name", "")))
    return Geom(shape, None if mass is None else mass[0], density[0], visual)


def plain_name(name: str) -> str:
    """A name without the #2, #3, ... that keeps the names of a file apart."""
    return re.sub(r"#\d+$", "", name)


def _size(
    element: Element, get: dict[str, str], kind: str, placement: Array, what: str, findings: Findings
) -> tuple[tuple[float, ...] | None, Array]:
    line = element.sourceline
    count = _SIZES[kind]
    if "fromto" in get and kind in ("capsule", "cylinder", "box", "ellipsoid"):
        ends = read_numbers(get["fromto"], 6, f"fromto of {what}", findings, line)
        half = _numbers(get.get("size"), 1, f"size of {what}", findings, line)
        if ends is None or half is None:
            return None, placement
        start, end = np.array(ends[:3]), np.array(ends[3:])
        length = float(np.linalg.norm(end - start))
        if length < 1e-9:
            findings.error(f"fromto of {what} has no length", "two points", "", line)
            return None, placement
        placement = from_rotation(frame_along(end - start), 0.5 * (start + end))
        half = (half[0], 0.5 * length) if kind in ("capsule", "cylinder") else (half[0], half[0], 0.5 * length)
    else:
        half = _numbers(get.get("size"), count, f"size of {what}", findings, line)
    if half is None:
        return None, placement
    if min(half) < 0.0:
        findings.error(f"size of {what} is {half}", "no negative length", "", line)
        return None, placement
    if kind == "box":
        return tuple(2.0 * value for value in half), placement
    if kind in ("capsule", "cylinder"):
        return (half[0], 2.0 * half[1]), placement
    return half, placement


def _numbers(text: str | None, count: int, what: str, findings: Findings, line: int | None) -> tuple[float, ...] | None:
    """The first `count` numbers: MJCF lets sizes be longer than the geom needs."""
    words = (text or "").split()
    return read_numbers(" ".join(words[:count]) if len(words) > count else text, count, what, findings, line)


def _colour(
    get: dict[str, str], what: str, findings: Findings, line: int | None
) -> tuple[float, float, float, float] | None:
    if "rgba" not in get:
        return None
    values = read_numbers(get["rgba"], 4, f"rgba of {what}", findings, line)
    if values is None or not all(0.0 <= value <= 1.0 for value in values):
        return None
    return values[0], values[1], values[2], values[3]


def inertia_of_geoms(geoms: list[Geom], body: str, findings: Findings, line: int | None) -> Inertial | None:
    """The inertia of a body from its geoms; None where they have no mass."""
    parts = []
    for geom in geoms:
        if geom.shape.kind == "mesh":
            if geom.mass != 0.0 and not (geom.mass is None and geom.density == 0.0):
                findings.error(
                    f"the inertia of body '{body}' would come from a mesh", "<inertial>", 'add it, or mass="0"', line
                )
            continue
        volume, squares = _moments(geom.shape.kind, geom.shape.size)
        mass = geom.density * volume if geom.mass is None else geom.mass
        if mass > 0.0:
            tensor = mass * np.diag([squares[1] + squares[2], squares[0] + squares[2], squares[0] + squares[1]])
            rotation = geom.shape.placement[:3, :3]
            parts.append((mass, geom.shape.placement[:3, 3], rotation @ tensor @ rotation.T))
    total = sum(mass for mass, _, _ in parts)
    if total <= 0.0:
        return None
    com = sum((mass * at for mass, at, _ in parts), np.zeros(3)) / total
    inertia = np.zeros((3, 3))
    for mass, at, tensor in parts:
        arm = at - com
        inertia += tensor + mass * (float(arm @ arm) * np.eye(3) - np.outer(arm, arm))
    return Inertial(total, com, 0.5 * (inertia + inertia.T))


def _moments(kind: str, size: tuple[float, ...]) -> tuple[float, tuple[float, float, float]]:
    """Volume [m3], and the mean squares of x, y, z over it [m2]."""
    if kind == "box":
        x, y, z = size
        return x * y * z, (x * x / 12.0, y * y / 12.0, z * z / 12.0)
    if kind == "ellipsoid":
        a, b, c = size
        return 4.0 / 3.0 * math.pi * a * b * c, (a * a / 5.0, b * b / 5.0, c * c / 5.0)
    if kind == "sphere":
        r = size[0]
        return 4.0 / 3.0 * math.pi * r**3, (r * r / 5.0, r * r / 5.0, r * r / 5.0)
    r, length = size
    tube = math.pi * r * r * length
    side, end = r * r / 4.0, length * length / 12.0
    if kind == "cylinder":
        return tube, (side, side, end)
    ball = 4.0 / 3.0 * math.pi * r**3
    share = tube / (tube + ball) if tube + ball > 0.0 else 0.0
    half = 0.5 * length
    cap = r * r / 5.0 + half * half + 0.75 * half * r  # two half balls, their flat sides at the ends of the tube
    across = share * side + (1.0 - share) * r * r / 5.0
    return tube + ball, (across, across, share * end + (1.0 - share) * cap)
