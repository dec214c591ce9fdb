"""Shapes of a description (primitives and meshes) as meshcat objects, and their bounding boxes.

meshcat's cylinder stands along y, URDF's along z.  A mesh file is read here, never by the browser: every part of a
mesh with several materials becomes its own object, because meshcat keeps only the first.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from meshcat import geometry as g

from cutjoint.arrays import Array
from cutjoint.description.meshes import read_meshes
from cutjoint.description.model import IDENTITY, Shape
from cutjoint.errors import InputError
from cutjoint.files import is_file

if TYPE_CHECKING:
    from trimesh import Trimesh

Colour = tuple[float, float, float, float]

_UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])


@dataclass(frozen=True, eq=False)
class Part:
    """A meshcat object and its placement (4, 4) in the link frame."""

    thing: g.Object
    placement: Array


def material(colour: Colour, *, flat: bool = False) -> g.Material:
    """A shaded surface of `colour` (red, green, blue, opacity from 0 to 1), `flat` on each triangle or smooth."""
    properties = {"flatShading": True} if flat else {}
    return g.MeshPhongMaterial(color=_number(colour), opacity=colour[3], shininess=40, **properties)


def over(colour: Colour) -> g.Material:
    """A plain colour that is drawn over everything, for what must not be hidden inside the robot."""
    return g.MeshBasicMaterial(color=_number(colour), opacity=colour[3], transparent=True, depthTest=False)


def _number(colour: Colour) -> int:
    red, green, blue = (round(255 * min(max(channel, 0.0), 1.0)) for channel in colour[:3])
    return (red << 16) + (green << 8) + blue


def translation(offset: Array | list[float]) -> Array:
    """The (4, 4) placement that only moves."""
    placement = np.eye(4)
    placement[:3, 3] = offset
    return placement


def along(direction: Array) -> Array:
    """A (4, 4) rotation that takes z to `direction` (any length > 0)."""
    z = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    placement = np.eye(4)
    placement[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    return placement


def parts(shape: Shape, colour: Colour) -> list[Part]:
    """The meshcat objects that show `shape` in `colour`.

    Raises:
        InputError: unknown kind, or a mesh that cannot be read.
    """
    surface = material(colour)
    at = np.asarray(shape.placement)
    if shape.kind == "box":
        return [Part(g.Mesh(g.Box(list(shape.size)), surface), at)]
    if shape.kind == "sphere":
        return [Part(g.Mesh(g.Sphere(shape.size[0]), surface), at)]
    if shape.kind == "cylinder":
        radius, length = shape.size
        return [Part(g.Mesh(g.Cylinder(length, radius), surface), at @ _UPRIGHT)]
    if shape.kind == "capsule":
        radius, length = shape.size
        ends = [Part(g.Mesh(g.Sphere(radius), surface), at @ translation([0, 0, s * length / 2])) for s in (-1, 1)]
        return [Part(g.Mesh(g.Cylinder(length, radius), surface), at @ _UPRIGHT), *ends]
    if shape.kind == "mesh":
        return [_mesh_part(mesh, at, colour, own=shape.colour is None) for mesh in load_mesh(shape)]
    raise InputError(f"cannot draw a shape of kind '{shape.kind}'")


def has_own_colour(shape: Shape) -> bool:
    """Whether a shape has a colour of its own, or each part of its mesh has.

    Raises:
        InputError: a mesh that cannot be read.
    """
    if shape.colour is not None or shape.kind != "mesh":
        return shape.colour is not None
    return all(_own_colour(mesh) is not None for mesh in load_mesh(shape))


def corners(shape: Shape) -> Array:
    """Corners of a box around `shape` in the link frame, shape (8, 3) [m].

    Raises:
        InputError: unknown kind, or a mesh that cannot be read.
    """
    if shape.kind == "box":
        high = np.asarray(shape.size) / 2
        low = -high
    elif shape.kind == "sphere":
        high = np.full(3, shape.size[0])
        low = -high
    elif shape.kind in ("cylinder", "capsule"):
        radius, length = shape.size
        high = np.array([radius, radius, length / 2 + (radius if shape.kind == "capsule" else 0.0)])
        low = -high
    elif shape.kind == "mesh":
        bounds = np.array([mesh.bounds for mesh in load_mesh(shape)])
        low, high = bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)
    else:
        raise InputError(f"cannot draw a shape of kind '{shape.kind}'")
    box = np.array(list(product(*zip(low, high, strict=True))))
    return box @ np.asarray(shape.placement)[:3, :3].T + np.asarray(shape.placement)[:3, 3]


def load_mesh(shape: Shape) -> list[Trimesh]:
    """The parts of a mesh file as `trimesh.Trimesh`, scaled.

    Raises:
        InputError: the file is missing, none, of another kind, too large, or cannot be read.
    """
    if shape.mesh is None:
        raise InputError("a shape of kind 'mesh' without a file; give the file or remove the shape")
    changed = shape.mesh.stat().st_mtime_ns if is_file(shape.mesh) else 0
    return list(_read_mesh(shape.mesh, changed, shape.size if len(shape.size) == 3 else (1.0, 1.0, 1.0)))


@lru_cache(maxsize=64)
def _read_mesh(path: Path, changed: int, scale: tuple[float, ...]) -> tuple[Trimesh, ...]:
    """Parts of a file as it was when it `changed` [ns], read once though bounds and objects both want it."""
    meshes = read_meshes(path)
    for mesh in meshes:
        mesh.apply_scale(np.asarray(scale))
    return meshes


def _mesh_part(mesh: Trimesh, at: Array, colour: Colour, own: bool) -> Part:
    colour = (_own_colour(mesh) or colour) if own else colour
    geometry = g.TriangularMeshGeometry(mesh.vertices, mesh.faces)
    return Part(g.Mesh(geometry, material(colour, flat=True)), at)


def _own_colour(mesh: Trimesh) -> Colour | None:
    """The colour of the mesh's own material, None where it has none."""
    if not getattr(mesh.visual, "defined", False):
        return None
    kind = getattr(mesh.visual, "material", None)
    value = getattr(kind, "main_color", None) if kind is not None else mesh.visual.main_color
    if value is None:
        return None
    channels = np.asarray(value, dtype=float)[:4] / 255.0
    return (float(channels[0]), float(channels[1]), float(channels[2]), float(channels[3]))


def lines(points: Array, colour: int, pairs: bool = False) -> g.Object:
    """A line through `points` (k, 3) [m], or separate segments between pairs of them."""
    kind = g.LineSegments if pairs else g.Line
    return kind(g.PointsGeometry(np.asarray(points, dtype=np.float32).T), g.LineBasicMaterial(color=colour))


def tube(points: Array, radius: float, surface: g.Material, sides: int = 5) -> g.Object:
    """A thin tube along `points` (k, 3) [m]; its triangles are in the order of the points, so a part can be shown.

    WebGL draws lines one pixel wide whatever is asked, so a path that must be seen is a tube.
    """
    path = np.asarray(points, dtype=float)
    tangents = np.gradient(path, axis=0)
    lengths = np.linalg.norm(tangents, axis=1)
    tangents[lengths > 0] /= lengths[lengths > 0, None]
    tangents[lengths == 0] = [1.0, 0.0, 0.0]
    normal = np.cross(tangents[0], np.eye(3)[np.argmin(np.abs(tangents[0]))])
    rings, angles = [], np.linspace(0, 2 * np.pi, sides, endpoint=False)
    for point, tangent in zip(path, tangents, strict=True):
        normal = normal - tangent * (normal @ tangent)
        size = float(np.linalg.norm(normal))
        if size < 1e-9:
            normal, size = np.cross(tangent, np.eye(3)[np.argmin(np.abs(tangent))]), 1.0
        normal = normal / np.linalg.norm(normal)
        binormal = np.cross(tangent, normal)
        rings.append(point + radius * (np.outer(np.cos(angles), normal) + np.outer(np.sin(angles), binormal)))
    faces = []
    for ring in range(len(path) - 1):
        for side in range(sides):
            a, b = ring * sides + side, ring * sides + (side + 1) % sides
            faces += [[a, b, a + sides], [b, b + sides, a + sides]]
    return g.Mesh(g.TriangularMeshGeometry(np.concatenate(rings), np.array(faces)), surface)


def arrow(length: float, radius: float, surface: g.Material) -> list[Part]:
    """An arrow from the origin along z, `length` long [m]."""
    head = min(0.3 * length, 5 * radius)
    shaft, tip = arrow_parts(head, radius, surface)
    stretch = np.diag([1.0, 1.0, length - head, 1.0])
    return [
        Part(shaft.thing, stretch @ shaft.placement),
        Part(tip.thing, translation([0, 0, length - head]) @ tip.placement),
    ]


def arrow_parts(head: float, radius: float, surface: g.Material) -> tuple[Part, Part]:
    """Shaft of unit length from the origin along z, and a tip `head` long [m] from the origin along z."""
    shaft = g.Mesh(g.Cylinder(1.0, radius), surface)
    tip = g.Mesh(g.Cylinder(head, radiusTop=0.0, radiusBottom=2.4 * radius), surface)
    return Part(shaft, translation([0, 0, 0.5]) @ _UPRIGHT), Part(tip, translation([0, 0, head / 2]) @ _UPRIGHT)


def turn_arrow(radius: float, thickness: float, surface: g.Material) -> list[Part]:
    """An arrow bent to a three-quarter circle about z, anticlockwise."""
    angles = np.linspace(0.0, 1.5 * np.pi, 32)
    ring = tube(radius * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles]), thickness, surface, sides=8)
    tip = g.Mesh(g.Cylinder(6 * thickness, radiusTop=0.0, radiusBottom=2.6 * thickness), surface)
    along = np.eye(4)  # the cone's y axis points along +x, the direction of motion at three quarters of the circle
    along[:3, :3] = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    return [Part(ring, IDENTITY), Part(tip, translation([2 * thickness, -radius, 0.0]) @ along)]
