"""A workspace in the world: points of its cells and triangles of its boundary, to be shown beside the robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.doors import door
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism.task import Task
from cutjoint.reprs import one_line
from cutjoint.workspace.region import Workspace
from cutjoint.workspace.surface import surface

MOST_POINTS = 20_000


@dataclass(frozen=True, eq=False)
class WorldShape(Frozen):
    """Points and triangles of a workspace in the world.

    Attributes:
        points: middles of reached cells, shape (count, 3) [m].
        values: of the chosen map there, shape (count,), NaN where it has none; none without a map.
        vertices: shape (count, 3) [m].
        faces: three vertices a triangle, as whole numbers, shape (triangles, 3).
    """

    points: Array
    values: Array
    vertices: Array
    faces: Array

    def __repr__(self) -> str:
        return one_line("WorldShape", [f"{len(self.points)} points [m]", f"{len(self.faces)} triangles"])


@door
def in_world(space: Workspace, task: Task, what: str = "") -> WorldShape:
    """A workspace in the world, as its robot's task places it.

    Args:
        space: over some of x, y and z.
        task: of the robot.
        what: name of a map whose values the points get.

    Of a workspace of more cells than `MOST_POINTS` every second, third, ... is taken along all axes.  Over three axes
    the triangles are the closed surface, over two they fill the region, over one there are none.

    Raises:
        InputError: an axis is a rotation, so that its cells are no places; or no cell is reached.
        UnknownNameError: there is no such map.
        MissingPackageError: scikit-image is not installed.
    """
    if turns := [axis.name for axis in space.axes if axis.name not in ("x", "y", "z")]:
        raise InputError(f"a workspace over {turns[0]} has no place in the world; give one over some of x, y and z")
    if what and what not in space.maps:
        raise UnknownNameError("map", what, tuple(space.maps))
    if not space.inside.any():
        raise InputError(f"no cell of the workspace of {space.robot} is reached, so there is nothing to show")
    held = {name: value for name, value in space.held.items() if name in ("x", "y", "z")}
    start = task.pose(held | {axis.name: 0.0 for axis in space.axes}).position
    ways = [
        task.pose(held | {one.name: float(one is axis) for one in space.axes}).position - start for axis in space.axes
    ]

    def placed(coordinates: Array) -> Array:
        return np.asarray(start + coordinates @ np.array(ways))

    every = 1
    while (thinned := _thinned(space, every)).sum() > MOST_POINTS:
        every += 1
    at = np.nonzero(thinned)
    points = np.stack([axis.values[k] for axis, k in zip(space.axes, at, strict=True)], axis=1)
    values = space.maps[what].values[at] if what else np.zeros(0)
    if len(space.axes) == 3:
        boundary = surface(space)
        vertices, faces = boundary.vertices, boundary.faces
    else:
        vertices, faces = _squares(space) if len(space.axes) == 2 else (np.zeros((0, 1)), np.zeros((0, 3), dtype=int))
    return WorldShape(placed(points), values, placed(vertices), faces.astype(float))


def _thinned(space: Workspace, every: int) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """The reached cells, but for those between every so many."""
    kept = np.zeros_like(space.inside)
    pick = (slice(every // 2, None, every),) * space.inside.ndim
    kept[pick] = space.inside[pick]
    return kept


def _squares(space: Workspace) -> tuple[Array, np.ndarray[tuple[int, ...], np.dtype[np.int64]]]:
    """Vertices and triangles of the cells that are reached in a plane: two a cell."""
    rows, columns = (np.append(axis.values, axis.values[-1] + axis.step) - axis.step / 2.0 for axis in space.axes)
    vertices = np.stack(np.meshgrid(rows, columns, indexing="ij"), axis=-1).reshape(-1, 2)
    i, j = np.nonzero(space.inside)
    a = i * len(columns) + j
    b, c, d = a + 1, a + len(columns) + 1, a + len(columns)
    faces = np.concatenate([np.stack([a, d, c], axis=1), np.stack([a, c, b], axis=1)])
    used, numbers = np.unique(faces, return_inverse=True)
    return vertices[used], numbers.reshape(faces.shape)
