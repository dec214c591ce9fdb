"""Geoms in MJCF as shapes.  MJCF counts half lengths: a box of size a is 2 a long."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from cutjoint.description.formats.mjcf.compiled import GeomRow, MeshRow
from cutjoint.description.formats.mjcf.source import MjcfText
from cutjoint.description.model import Place, Shape
from cutjoint.description.numbers import parse_number
from cutjoint.description.transforms import from_rotation, rotation_from_quaternion
from cutjoint.findings import Findings

_DRAWN = ("sphere", "capsule", "cylinder", "box", "mesh")


def check_meshes(meshes: tuple[MeshRow, ...], source: MjcfText, findings: Findings) -> None:
    """Note the meshes whose files are not there."""
    for mesh in meshes:
        place = source.place(mesh.line, "mesh") or Place(findings.file)
        if mesh.needed:
            found = f"the inertia of body '{mesh.needed}' would come from the mesh '{mesh.shown}', which is not there"
            findings.error(found, f"<inertial>, or the file {mesh.file}", "", place)
        elif not mesh.there:
            findings.doubt(f"mesh '{mesh.shown}' not found", f"a file, such as {mesh.file}", "", place)


def shape_of(geom: GeomRow, meshes: Mapping[str, MeshRow], source: MjcfText) -> Shape | None:
    """One geom; None for planes, height fields, ellipsoids and what has no file."""
    mesh = meshes.get(geom.mesh)
    if geom.kind not in _DRAWN or (mesh is not None and not (mesh.there and mesh.file)):
        return None
    if geom.kind == "mesh" and mesh is None:
        return None
    sizes = {
        "sphere": geom.size[:1],
        "box": tuple(2.0 * value for value in geom.size),
        "mesh": () if mesh is None else mesh.scale,
    }
    size = sizes.get(geom.kind, (geom.size[0], 2.0 * geom.size[1]))
    at = from_rotation(rotation_from_quaternion(geom.quaternion), geom.position)
    file = Path(mesh.file) if geom.kind == "mesh" and mesh is not None else None
    return Shape(geom.kind, size, at, _colour(geom, source), file, plain_name(geom.name))


def _colour(geom: GeomRow, source: MjcfText) -> tuple[float, float, float, float] | None:
    """That of the file where it stands there, which MuJoCo keeps in single precision."""
    element = source.element(geom.line, "geom")
    words = [] if element is None else [parse_number(word) for word in str(element.get("rgba", "")).split()]
    own = [value for value in words if value is not None]
    values = own if len(own) == 4 else geom.colour
    return None if values is None else (values[0], values[1], values[2], values[3])


def plain_name(name: str) -> str:
    """A name without the #2, #3, ... that keeps the names of a file apart."""
    return re.sub(r"#\d+$", "", name)
