"""A workspace as a value: cells of a grid over task coordinates, which of them are reached, and maps over them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Frozen, Values
from cutjoint.reprs import line


def volume_unit(units: tuple[str, ...]) -> str:
    """Unit of a length, area or volume over axes with `units`, such as m3 or m2 rad."""
    parts = [(unit, units.count(unit)) for unit in dict.fromkeys(units)]
    return " ".join(unit if count == 1 else f"{unit}{count}" for unit, count in parts)


@dataclass(frozen=True, eq=False)
class GridAxis(Frozen):
    """One led coordinate of the tool over a grid.

    Attributes:
        name: of the task's coordinate, such as x or rz.
        unit: m or rad.
        values: centres of the cells, evenly spread and growing, shape (cells,), in `unit`.
    """

    name: str
    unit: str
    values: Array

    __repr__ = line("name", "unit", "values")

    @property
    def step(self) -> float:
        """Breadth of a cell, in `unit`."""
        return float(self.values[-1] - self.values[0]) / (len(self.values) - 1)


@dataclass(frozen=True, eq=False)
class FieldMap(Frozen):
    """One quantity over the cells of a workspace.

    Attributes:
        title: what it is, in words.
        unit: SI unit; "" for a ratio.
        values: of every cell, NaN where it is not reached; shape as the workspace's `inside`.
        best: "high" or "low": which values are the good ones.
    """

    title: str
    unit: str
    values: Array
    best: str = "high"

    __repr__ = line("title", "unit", "best")


@dataclass(frozen=True, eq=False)
class Workspace(Values):
    """Where the tool can be: one connected region, on one working mode and one assembly mode.

    Attributes:
        robot: its name.
        axes: 1 to 3 led coordinates that the grid is over.
        held: the other led coordinates, where they are held -> [m] or [rad].
        inside: whether the centre of a cell is reached, shape (cells of axis 1, ...).
        extent: length, area or volume of the region, boundary cells counted in part: [m], [m2], [m3] (or with [rad]).
        q: actuated coordinates of every cell, NaN where it is not reached, shape (*inside.shape, n).
        maps: name -> quantity over the cells.
        told: what was chosen or left out, in sentences.
        ways: what part of the way from every cell to the next one is reached, forwards and backwards along axis 1, then
            axis 2 and so on, shape (2 axes, *inside.shape): where the boundary lies between cells; None if not known.
    """

    robot: str
    axes: tuple[GridAxis, ...]
    held: Mapping[str, float]
    inside: npt.NDArray[np.bool_]
    extent: float
    q: Array
    maps: Mapping[str, FieldMap]
    told: tuple[str, ...] = ()
    ways: Array | None = None

    __repr__ = line("robot", "axes", "extent")

    @property
    def unit(self) -> str:
        """Of the extent, such as m3 or m2 rad."""
        return volume_unit(tuple(axis.unit for axis in self.axes))

    @property
    def cell(self) -> float:
        """Length, area or volume of one cell."""
        return math.prod(axis.step for axis in self.axes)

    @property
    def points(self) -> Array:
        """Coordinates of the centres of all cells that are reached, shape (count, axes)."""
        where = np.nonzero(self.inside)
        return np.stack([axis.values[index] for axis, index in zip(self.axes, where, strict=True)], axis=1)
