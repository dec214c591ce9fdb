"""The boundary of a workspace as a closed surface of triangles, and files of it.

Marching cubes (W. E. Lorensen, H. E. Cline, 1987; in the form of T. Lewiner, H. Lopes, A. W. Vieira, G. Tavares:
Efficient implementation of marching cubes' cases with topological guarantees, 2003) on the reached cells.  Every vertex
lies between a cell that is reached and one that is not, and is moved to where that way ends, as far as the workspace
knows.  Where it does not, the cells are spread by a Gauss bell of `SPREAD` steps so that the surface has no stairs, and
the surface is taken at the level with which it encloses the workspace's `extent`.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Values, readonly
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.extras import needed
from cutjoint.files import check_place, write_whole
from cutjoint.reprs import one_line
from cutjoint.workspace.grid_body import Mask
from cutjoint.workspace.level import parts_of
from cutjoint.workspace.region import Workspace, volume_unit

Faces = npt.NDArray[np.int64]
SPREAD = 1.0
"""Of the bell, in steps of the grid."""
AROUND = 6
"""Cells that are not reached around the grid: further than the bell is felt."""
LEVELS = (0.1, 0.9)
"""Of the spread cells, between which the surface is taken: nearer to 0 or 1 it would follow the bell's ends."""
FINE = 1e-4
"""Part of a surface's breadth that the numbers of a file must tell apart."""
SUFFIXES = (".stl", ".ply", ".obj")
TRIES = 12
CLOSE = 1e-4
"""Part of the extent by which the surface's volume may miss it."""


@dataclass(frozen=True, eq=False)
class Surface(Values):
    """A closed surface of triangles.

    Attributes:
        robot: its name.
        names: of the three axes.
        units: of the axes, m or rad.
        vertices: shape (count, 3), in `units`.
        faces: three vertices a triangle, anticlockwise seen from outside, shape (count, 3).
    """

    robot: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    vertices: Array
    faces: Faces

    def __repr__(self) -> str:
        told = f"{len(self.vertices)} vertices", f"{len(self.faces)} triangles", f"volume={self.volume:.6g} {self.unit}"
        return one_line("Surface", [self.robot, *told])

    @property
    def unit(self) -> str:
        """Of its volume."""
        return volume_unit(self.units)

    @property
    def volume(self) -> float:
        """That it encloses, in `unit`."""
        return _enclosed(self.vertices, self.faces)


@door
def surface(space: Workspace) -> Surface:
    """The boundary of a workspace over three axes, as a closed surface.

    Raises:
        InputError: it has fewer axes, or no cell is reached.
        MissingPackageError: scikit-image is not installed.
    """
    if len(space.axes) != 3:
        told = ", ".join(axis.name for axis in space.axes)
        raise InputError(f"a surface needs a workspace over three axes, found {len(space.axes)}: {told}")
    if not space.inside.any():
        raise InputError(f"no cell of the workspace of {space.robot} is reached, so it has no surface; use more cells")
    measure = needed("skimage.measure", "the surface of a workspace")
    steps = np.array([axis.step for axis in space.axes])
    if space.ways is None:
        vertices, faces, around = _spread_surface(measure, space)
    else:
        vertices, faces, around = *_cut(measure, np.pad(space.inside, 1).astype(float), 0.5), 1
        vertices = _moved(vertices, space)
    start = np.array([axis.values[0] for axis in space.axes])
    names, units = tuple(axis.name for axis in space.axes), tuple(axis.unit for axis in space.axes)
    faces.setflags(write=False)
    return Surface(space.robot, names, units, readonly((vertices - around) * steps + start), faces)


def _cut(measure: ModuleType, values: Array, level: float) -> tuple[Array, Faces]:
    """The surface at which values have a level, in cells; its triangles anticlockwise seen from where they are less."""
    points, triangles, _, _ = measure.marching_cubes(values, level)
    vertices, faces = np.asarray(points, dtype=np.float64), np.array(triangles, dtype=np.int64)
    return vertices, faces if _enclosed(vertices, faces) > 0.0 else faces[:, ::-1].copy()


def _moved(vertices: Array, space: Workspace) -> Array:
    """Vertices midway between a cell that is reached and one that is not, moved to where that way ends; those in the
    middle of eight cells stay."""
    inside, parts = np.pad(space.inside, 1), parts_of(space)
    low, high = np.floor(vertices + 1e-3).astype(int), np.ceil(vertices - 1e-3).astype(int)
    between = high - low
    moved = vertices.copy()
    for axis in range(3):
        rows = np.flatnonzero((between[:, axis] == 1) & (between.sum(axis=1) == 1))
        a, b = tuple(low[rows].T), tuple(high[rows].T)
        forwards, backwards = parts[(2 * axis, *a)], parts[(2 * axis + 1, *b)]
        moved[rows, axis] = low[rows, axis] + np.where(inside[a], forwards, 1.0 - backwards)
    return moved


def _spread_surface(measure: ModuleType, space: Workspace) -> tuple[Array, Faces, int]:
    """The surface of the spread cells that encloses the extent, in cells, and how many there are around the grid."""
    spread = spread_cells(space.inside)
    wanted = space.extent / space.cell
    least, most = LEVELS[0], min(LEVELS[1], 0.99 * float(spread.max()))
    level = min(0.5, most)
    for _ in range(TRIES):
        vertices, faces = _cut(measure, spread, level)
        volume = _enclosed(vertices, faces)
        if abs(volume - wanted) <= CLOSE * wanted or most - least < 1e-4:
            break
        least, most = (least, level) if volume < wanted else (level, most)
        level = (least + most) / 2.0
    return vertices, faces, AROUND


def spread_cells(inside: Mask) -> Array:
    """Reached cells as 1 and others as 0, spread by a bell, with `AROUND` cells more at every side: 1/2 about at the
    boundary."""
    from scipy.ndimage import gaussian_filter

    return np.asarray(gaussian_filter(np.pad(inside, AROUND).astype(float), SPREAD))


def _enclosed(vertices: Array, faces: Faces) -> float:
    """Volume inside, positive where the triangles are anticlockwise seen from outside."""
    a, b, c = np.moveaxis((vertices - vertices.mean(axis=0))[faces], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def check_surface(path: str | os.PathLike[str]) -> Path:
    """A place where a surface can be written; worth asking before the work.

    Raises:
        InputError: the suffix is no format of a surface, or nothing can be written there.
    """
    target = check_place(path)
    if target.suffix.lower() not in SUFFIXES:
        raise InputError(f"'{target}': surfaces are written as {', '.join(SUFFIXES)}; found '{target.suffix}'")
    return target


@door
def write_surface(made: Surface, path: str | Path) -> Path:
    """Write a surface; the suffix picks the format: .stl (binary), .ply (binary, in doubles) or .obj (text).

    STL keeps numbers in 32 bits.  None of the three formats has units; PLY and OBJ name them in a comment.

    Raises:
        InputError: as of `check_surface`, or numbers that STL cannot keep apart.
    """
    target = check_surface(path)
    suffix = target.suffix.lower()
    return write_whole(target, _stl(made) if suffix == ".stl" else _ply(made) if suffix == ".ply" else _obj(made))


def _about(made: Surface) -> str:
    axes = ", ".join(f"{name} [{unit}]" for name, unit in zip(made.names, made.units, strict=True))
    robot = "".join(one if one.isascii() and one.isprintable() else "_" for one in made.robot)
    return f"workspace of {robot}; {axes}"


def _stl(made: Surface) -> bytes:
    corners = made.vertices.astype(np.float32)
    least = float(np.ptp(made.vertices, axis=0).min()) * FINE
    if float(np.spacing(np.abs(corners).max())) > least:
        raise InputError(
            "so small and so far from the origin, the 32-bit numbers of STL cannot hold it; write .ply or .obj"
        )
    triangles = corners[made.faces]
    a, b, c = np.moveaxis(made.vertices[made.faces], 1, 0)
    normals = np.cross(b - a, c - a)
    sizes = np.linalg.norm(normals, axis=1, keepdims=True)
    rows = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    rows["normal"], rows["corners"] = (
        np.divide(normals, sizes, out=np.zeros_like(normals), where=sizes > 0.0),
        triangles,
    )
    head = f"cutjoint: {_about(made)}"[:80].ljust(80).encode()  # nor may it begin with "solid"
    return head + len(rows).to_bytes(4, "little") + rows.tobytes()


def _ply(made: Surface) -> bytes:
    head = ["ply", "format binary_little_endian 1.0", f"comment {_about(made)}", f"element vertex {len(made.vertices)}"]
    head += [f"property double {axis}" for axis in "xyz"]
    head += [f"element face {len(made.faces)}", "property list uchar int vertex_indices", "end_header", ""]
    rows = np.zeros(len(made.faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, made.faces
    return "\n".join(head).encode() + made.vertices.astype("<f8").tobytes() + rows.tobytes()


def _obj(made: Surface) -> str:
    lines = [f"# {_about(made)}", *("v {!r} {!r} {!r}".format(*row) for row in made.vertices.tolist())]
    lines += ["f {} {} {}".format(*row) for row in (made.faces + 1).tolist()]
    return "\n".join(lines) + "\n"
