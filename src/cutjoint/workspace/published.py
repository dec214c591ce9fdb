"""The workspace of a published model, whose inverse kinematics are in closed form: every point of a lattice is asked by
itself, and what is joined with home is kept.

Of cells at the boundary further points are asked for what part of them is reached: those of the additive recurrence of
the numbers 1 / g, 1 / g^2, ... with g^(axes + 1) = g + 1 (M. Roberts, *The unreasonable effectiveness of quasirandom
sequences*, 2018), which goes on from cell to cell, so that a few points a cell fill all of them evenly.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy.ndimage import binary_dilation, binary_erosion, label

from cutjoint.arrays import Array
from cutjoint.compile import CompiledPaper
from cutjoint.mechanism import Posture
from cutjoint.workspace.filling import Filled
from cutjoint.workspace.goals import Goals
from cutjoint.workspace.lattice import Lattice

HALVINGS = 3
"""How often the way from a cell that is reached to one that is not is halved."""


WITHIN = {1: 32, 2: 16, 3: 4}
"""Axes of a lattice -> points that are asked of a cell at the boundary."""
GOLDEN = {1: 1.618033988749895, 2: 1.324717957244746, 3: 1.2207440846057596}
"""Axes -> the root g of g^(axes + 1) = g + 1."""


class ClosedForm:
    """Asks a published model.

    Args:
        robot: the model, at home in the working mode that is asked of.
        goals: what coordinates ask of the tool.
        start: posture with which the workspace is joined.
        across: whether type-2 singularities may be crossed.
    """

    def __init__(self, robot: CompiledPaper, goals: Goals, start: Posture, *, across: bool = False) -> None:
        self._robot, self._goals, self._across = robot, goals, across
        self.at = goals.of(start, robot)

    def reached(self, at: Array) -> tuple[Array, npt.NDArray[np.bool_]]:
        """Actuated coordinates with the tool at coordinates (N, axes), and whether it comes there."""
        points = self._goals.places(at)
        return self._robot.batch.reached_in_any(points) if self._across else self._robot.batch.reached(points)

    def fill(self, lattice: Lattice, *, edges: bool = True) -> Filled:
        """The cells that are joined with the start; `edges` for what part of the ways out of them is reached."""
        states, good = self.reached(lattice.centres())
        shape = lattice.shape
        parts, _ = label(good.reshape(shape), structure=np.ones((3,) * len(shape)))
        flat = parts.ravel()
        first = [cell for cell in lattice.corners(self.at) if flat[cell]]
        inside = flat == flat[first[0]] if first else np.zeros(lattice.size, dtype=bool)
        states[~inside] = np.nan
        filled = Filled(lattice, inside, states, np.zeros((2 * len(shape), lattice.size)))
        if not edges or filled.touched.any():  # a lattice that is too small is asked of anew, and larger
            return filled
        return replace(filled, ways=self._ways(lattice, inside), shares=self._shares(lattice, inside))

    def _shares(self, lattice: Lattice, inside: npt.NDArray[np.bool_]) -> Array:
        """What part of every cell is reached."""
        axes, block = len(lattice.shape), inside.reshape(lattice.shape)
        around = np.ones((3,) * axes)
        inner = binary_erosion(block, around, border_value=1)
        rim = np.flatnonzero(binary_dilation(block, around) & ~inner)
        count = WITHIN[axes]
        steps = 1.0 / GOLDEN[axes] ** np.arange(1, axes + 1)
        within = (0.5 + np.arange(1, count * len(rim) + 1)[:, None] * steps) % 1.0 - 0.5
        _, good = self.reached(np.repeat(lattice.coordinates(rim), count, axis=0) + within * lattice.steps)
        shares: Array = np.asarray(inner.ravel(), dtype=float)
        shares[rim] = good.reshape(-1, count).mean(axis=1)
        return shares

    def _ways(self, lattice: Lattice, inside: npt.NDArray[np.bool_]) -> Array:
        ways = np.zeros((2 * len(lattice.shape), lattice.size))
        cells = np.flatnonzero(inside)
        begin, to, where, scale = [], [], [], []
        for way in range(len(ways)):
            beside = lattice.neighbours(cells, way)
            joined = (beside >= 0) & inside[beside]
            ways[way, cells[joined]] = 1.0
            ended = ~joined & ((beside >= 0) | lattice.ends[way // 2])
            part = np.where(beside[ended] >= 0, 1.0, 0.5)
            begin.append(lattice.coordinates(cells[ended]))
            to.append(begin[-1] + part[:, None] * lattice.offset(way))
            where.append(way * lattice.size + cells[ended])
            scale.append(part)
        # the next cell is not reached, or it would be joined
        found = self._edges(np.concatenate(begin), np.concatenate(to), np.concatenate(scale) < 1.0)
        ways.reshape(-1)[np.concatenate(where)] = found * np.concatenate(scale)
        return ways

    def _edges(self, begin: Array, to: Array, open_ends: npt.NDArray[np.bool_]) -> Array:
        """What part of ways from reached points is reached, by halving; of ways with `open_ends` the whole may be."""
        low, high = np.zeros(len(begin)), np.ones(len(begin))
        ends = np.flatnonzero(open_ends)
        if len(ends):
            low[ends[self.reached(to[ends])[1]]] = 1.0
        rows = np.flatnonzero(low == 0.0)
        for _ in range(HALVINGS):
            middle = 0.5 * (low[rows] + high[rows])
            _, good = self.reached(begin[rows] + middle[:, None] * (to[rows] - begin[rows]))
            low[rows[good]], high[rows[~good]] = middle[good], middle[~good]
        return np.where(low == 1.0, 1.0, 0.5 * (low + high))
