"""The workspace of a published model, whose inverse kinematics are in closed form: every point of a lattice is asked by
itself, and what is joined with home is kept."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.ndimage import label

from cutjoint.arrays import Array
from cutjoint.compile import CompiledPaper
from cutjoint.mechanism import Posture
from cutjoint.workspace.filling import Filled
from cutjoint.workspace.goals import Goals
from cutjoint.workspace.lattice import Lattice

HALVINGS = 6
"""How often the way from a cell that is reached to one that is not is halved."""


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
        points = np.ascontiguousarray(self._goals.frames(at)[:, :3])
        return self._robot.batch.reached_in_any(points) if self._across else self._robot.batch.reached(points)

    def fill(self, lattice: Lattice) -> Filled:
        """The cells that are joined with the start."""
        states, good = self.reached(lattice.centres())
        shape = lattice.shape
        parts, _ = label(good.reshape(shape), structure=np.ones((3,) * len(shape)))
        flat = parts.ravel()
        first = [cell for cell in lattice.corners(self.at) if flat[cell]]
        inside = flat == flat[first[0]] if first else np.zeros(lattice.size, dtype=bool)
        states[~inside] = np.nan
        return Filled(lattice, inside, states, self._ways(lattice, inside))

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
        found = self._edges(np.concatenate(begin), np.concatenate(to))
        ways.reshape(-1)[np.concatenate(where)] = found * np.concatenate(scale)
        return ways

    def _edges(self, begin: Array, to: Array) -> Array:
        """What part of ways from reached points is reached, by halving."""
        low, high = np.zeros(len(begin)), np.ones(len(begin))
        _, whole = self.reached(to)
        low[whole] = 1.0
        rows = np.flatnonzero(~whole)
        for _ in range(HALVINGS):
            middle = 0.5 * (low[rows] + high[rows])
            _, good = self.reached(begin[rows] + middle[:, None] * (to[rows] - begin[rows]))
            low[rows[good]], high[rows[~good]] = middle[good], middle[~good]
        return np.where(low == 1.0, 1.0, 0.5 * (low + high))
