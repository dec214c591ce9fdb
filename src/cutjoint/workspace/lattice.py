"""A lattice of points over coordinates of a tool: the centres of the cells of a workspace, by one number each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Frozen
from cutjoint.reprs import line

Numbers = npt.NDArray[np.int64]
"""Numbers of cells, in the order of a flat array."""


@dataclass(frozen=True, eq=False)
class Lattice(Frozen):
    """Cells in rows along 1 to 3 coordinates.

    Attributes:
        first: coordinates of the centre of the first cell, shape (axes,), [m] or [rad].
        steps: breadth of a cell along every axis, shape (axes,).
        shape: cells along every axis.
        ends: whether an axis ends at half a cell before its first centre and behind its last, and is not only as long
            as was needed.
    """

    first: Array
    steps: Array
    shape: tuple[int, ...]
    ends: tuple[bool, ...]

    __repr__ = line("first", "steps", "shape")

    @classmethod
    def around(cls, middle: Array, steps: Array, count: int) -> Self:
        """`count` cells (odd) along every axis, with a point in the centre of the middle one."""
        return cls(middle - steps * (count // 2), steps, (count,) * len(steps), (False,) * len(steps))

    @property
    def size(self) -> int:
        """Number of cells."""
        return math.prod(self.shape)

    @property
    def cell(self) -> float:
        """Length, area or volume of a cell."""
        return float(np.prod(self.steps))

    def values(self, axis: int) -> Array:
        """Centres along an axis."""
        return np.asarray(self.first[axis] + self.steps[axis] * np.arange(self.shape[axis]))

    def coordinates(self, cells: Numbers) -> Array:
        """Of the centres of cells, shape (N, axes)."""
        where = np.stack(np.unravel_index(cells, self.shape), axis=-1)
        return np.asarray(self.first + self.steps * where)

    def centres(self) -> Array:
        """Coordinates of all centres, shape (size, axes)."""
        return self.coordinates(np.arange(self.size))

    def neighbours(self, cells: Numbers, way: int) -> Numbers:
        """The next cells along one of the 2 axes ways (axis 0 forwards, backwards, axis 1 ...); -1 where there is
        none."""
        axis, back = divmod(way, 2)
        stride = math.prod(self.shape[axis + 1 :])
        place = (cells // stride) % self.shape[axis]
        within = place > 0 if back else place < self.shape[axis] - 1
        return np.where(within, cells + (-stride if back else stride), -1)

    def shifted(self, cells: Numbers, by: Sequence[int]) -> Numbers:
        """The cells so many cells away along every axis; -1 where there is none."""
        where = np.array(np.unravel_index(cells, self.shape)) + np.array(by)[:, None]
        within = ((where >= 0) & (where < np.array(self.shape)[:, None])).all(axis=0)
        return np.where(within, np.ravel_multi_index(tuple(where), self.shape, mode="clip"), -1)

    def offset(self, way: int) -> Array:
        """From a centre to the next one along a way, shape (axes,)."""
        axis, back = divmod(way, 2)
        found = np.zeros(len(self.shape))
        found[axis] = -self.steps[axis] if back else self.steps[axis]
        return found

    def corners(self, point: Array) -> Numbers:
        """The cells around a point, nearest first, of which there are at most 2 to the number of axes."""
        within = (point - self.first) / self.steps
        low = np.floor(within).astype(int)
        around = np.array(np.meshgrid(*([0, 1],) * len(low), indexing="ij")).reshape(len(low), -1).T + low
        inside = ((around >= 0) & (around < np.array(self.shape))).all(axis=1)
        around = around[inside]
        around = around[np.argsort(((around - within) ** 2).sum(axis=1), kind="stable")]
        return np.asarray(np.ravel_multi_index(tuple(around.T), self.shape), dtype=np.int64)
