"""The body that a grid of cells tells for sure, and what stands around it.

Whether a point is reached is known at the centres of the cells, and how far the ways between them are reached; the
latter is put onto a finer grid first.  A *block* is the box between 2^d neighbouring
centres; it is *full* where all of them are reached, and the full blocks together are the body: for a convex region it
lies inside, elsewhere it leaves it by no more than the square of a step over the radius of the boundary.  Blocks that
are not full, those beyond the grid among them, are the *obstacles* of every shape that is to be inside.

The distance between two boxes of one grid is that between two of its points, the centres.  So distances from a centre
to the obstacles are exact by the transform of C. R. Maurer, R. Qi, V. Raghavan: A linear time algorithm for computing
exact Euclidean distance transforms of binary images in arbitrary dimensions (2003), as scipy has it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.workspace.level import level_of
from cutjoint.workspace.region import Workspace

Mask = npt.NDArray[np.bool_]
FINEST, FINEST_CELLS = 4, 4_000_000
"""A finer grid has at most so many cells a step, and about so many in all."""
TOUCHING = 1e-9
"""Boxes that overlap by less than this part of a step only touch."""


@dataclass(frozen=True, eq=False)
class GridBody:
    """The full blocks of a workspace, and the obstacles around them.

    Attributes:
        inside: whether a centre is reached, shape (cells of axis 1, ...).
        start: coordinates of the first centre, shape (axes,), [m] or [rad].
        steps: between centres, shape (axes,), [m] or [rad].
    """

    inside: Mask
    start: Array
    steps: Array

    @property
    def full(self) -> Mask:
        """Whether all corners of a block are reached, shape (cells of axis 1 - 1, ...)."""
        return full_blocks(self.inside)

    @cached_property
    def distance(self) -> Array:
        """From every centre to the nearest obstacle, 0 for those at one, shape as `inside`."""
        return distances(self.inside, self.steps)

    @cached_property
    def obstacles(self) -> tuple[Array, Array]:
        """Lowest and highest corners of the obstacles that touch the body, shapes (count, axes)."""
        from scipy.ndimage import binary_dilation

        full = np.pad(self.full, 1)
        touching = binary_dilation(full, np.ones((3,) * full.ndim, dtype=bool)) & ~full
        low = self.start + (np.argwhere(touching) - 1) * self.steps
        return low, low + self.steps

    def narrowed(self, margin: float) -> Mask:
        """The centres that are `margin` or more from every obstacle; blocks between such are so everywhere."""
        return self.inside & (self.distance >= margin * (1.0 - TOUCHING)) if margin > 0.0 else self.inside


def body_of(space: Workspace) -> GridBody:
    """The body that the grid of `space` tells; where it is known how far the ways between cells are reached, that of a
    finer grid of up to `FINEST_CELLS`, on which the level is interpolated."""
    start, steps = np.array([axis.values[0] for axis in space.axes]), np.array([axis.step for axis in space.axes])
    if space.ways is None:
        return GridBody(np.asarray(space.inside, dtype=bool), start, steps)
    from scipy.ndimage import zoom

    level = level_of(space)
    finer = int(np.clip(round((FINEST_CELLS / level.size) ** (1.0 / level.ndim)), 1, FINEST))
    counts = [(count - 1) * finer + 1 for count in level.shape]
    fine = zoom(level, [a / b for a, b in zip(counts, level.shape, strict=True)], order=1)
    return GridBody(np.asarray(fine >= 0.0), start - steps, steps / finer)


def full_blocks(inside: Mask) -> Mask:
    """Whether all 2^d corners of each block are in."""
    for axis in range(inside.ndim):
        before = inside.take(range(inside.shape[axis] - 1), axis)
        inside = before & inside.take(range(1, inside.shape[axis]), axis)
    return inside


def distances(inside: Mask, steps: Array) -> Array:
    """From every centre to the nearest block that is not full, shape as `inside`."""
    from scipy.ndimage import binary_erosion, distance_transform_edt

    deep = binary_erosion(inside, np.ones((3,) * inside.ndim, dtype=bool))  # a centre beyond the grid is not reached
    if not deep.any():
        return np.zeros(inside.shape)
    return np.asarray(distance_transform_edt(np.pad(deep, 1), sampling=steps))[(slice(1, -1),) * inside.ndim]
