"""Flood filling of a lattice: from one posture to all cells that the tool can be led to, cell by cell.

All ways out of the cells that are new are tried side by side.  A way that ends between two centres tells where the edge
of the workspace crosses it; lengths, areas and volumes are sums over those parts of cells, not over whole cells.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.reprs import line
from cutjoint.workspace.lattice import Lattice, Numbers
from cutjoint.workspace.walking import FINEST, CellWalker, march

Told = Callable[[float], None]
"""Called with the number of cells that are reached."""


@dataclass(frozen=True, eq=False)
class Filled:
    """Cells that are reached.

    Attributes:
        lattice: the cells.
        inside: which are reached, shape (cells,).
        states: of every cell that is, NaN elsewhere, shape (cells, state).
        ways: what part of the way to the next centre is reached, shape (2 axes, cells): 1 where that is too, 0 from
            cells that are not.
        shares: what part of every cell is reached, shape (cells,), where that was asked; else None.
    """

    lattice: Lattice
    inside: npt.NDArray[np.bool_]
    states: Array
    ways: Array
    shares: Array | None = None

    __repr__ = line("lattice")

    @property
    def extent(self) -> float:
        """Length, area or volume: the sum of the shares; where they were not asked, along every axis the rows of cells
        are as long as they are reached, and the mean of the axes is taken."""
        if self.shares is not None:
            return float(self.shares.sum()) * self.lattice.cell
        axes = range(len(self.lattice.shape))
        return float(np.mean([self._along(axis) for axis in axes])) * self.lattice.cell

    def _along(self, axis: int) -> float:
        """Cells of all rows along an axis, in part where they are reached in part.

        A run that is shorter than a cell is met by a centre as often as it is long, so where it is met it counts as one
        cell.
        """
        joined, ends = [], []
        for way in (2 * axis, 2 * axis + 1):
            beside = self.lattice.neighbours(np.arange(self.lattice.size), way)
            on = self.inside & (beside >= 0) & self.inside[beside]
            joined.append(on)
            ends.append(np.where(self.inside & ~on, self.ways[way], 0.0))
        length = 0.5 * (joined[0].astype(float) + joined[1]) + ends[0] + ends[1]
        alone = self.inside & ~joined[0] & ~joined[1]
        return float(np.where(alone, np.maximum(length, 1.0), length).sum())

    @property
    def touched(self) -> npt.NDArray[np.bool_]:
        """Whether the cells come to the first or last of an axis that does not end there, shape (axes,)."""
        block = self.inside.reshape(self.lattice.shape)
        found = []
        for axis, ends in enumerate(self.lattice.ends):
            first, last = block.take(0, axis), block.take(-1, axis)
            found.append(not ends and bool(first.any() or last.any()))
        return np.array(found)


def seeds(walker: CellWalker, lattice: Lattice) -> tuple[Numbers, Array]:
    """Cells around the posture that the walker starts from, which it comes to, and its states there."""
    cells = lattice.corners(walker.at)
    states = np.tile(walker.start, (len(cells), 1))
    begin = np.tile(walker.at, (len(cells), 1))
    found, done = march(walker, states, begin, lattice.coordinates(cells), FINEST + 2)
    return cells[done == 1.0], found[done == 1.0]


def fill(
    walker: CellWalker, lattice: Lattice, finest: int = FINEST, told: Told | None = None, begun: Filled | None = None
) -> Filled:
    """All cells that the tool can be led to from cell to cell: to the next ones along the axes, and where those end,
    along diagonals too, so that a thin part of the workspace that lies askew is not cut off.

    Args:
        walker: who leads.
        lattice: the cells.
        finest: how often a way is halved to find where it ends.
        told: called now and then with the number of cells that are reached.
        begun: what was reached on a part of the lattice.
    """
    flood = _Flood(walker, lattice, finest, told)
    new = flood.begin() if begun is None else flood.go_on(begun)
    while len(new):
        flood.spread(new)
        new = flood.to_the_edge()
        if not len(new):
            new = flood.along_diagonals()
    return Filled(lattice, flood.inside, flood.states, flood.parts)


def embedded(filled: Filled, lattice: Lattice) -> Filled:
    """The same cells in a larger lattice of the same breadths."""
    old, cells = filled.lattice, np.flatnonzero(filled.inside)
    moved = np.round((old.first - lattice.first) / lattice.steps).astype(int)
    where = np.array(np.unravel_index(cells, old.shape)) + moved[:, None]
    now = np.ravel_multi_index(tuple(where), lattice.shape)
    inside, ways = np.zeros(lattice.size, dtype=bool), np.zeros((len(filled.ways), lattice.size))
    states = np.full((lattice.size, filled.states.shape[1]), np.nan)
    inside[now], states[now], ways[:, now] = True, filled.states[cells], filled.ways[:, cells]
    return Filled(lattice, inside, states, ways)


class _Flood:
    """A filling under way."""

    def __init__(self, walker: CellWalker, lattice: Lattice, finest: int, told: Told | None) -> None:
        self._walker, self._lattice, self._finest, self._told = walker, lattice, finest, told
        self._ways = 2 * len(lattice.shape)
        self.inside = np.zeros(lattice.size, dtype=bool)
        self.states = np.full((lattice.size, len(walker.start)), np.nan)
        self.parts = np.zeros((self._ways, lattice.size))
        steps = product((-1, 0, 1), repeat=len(lattice.shape))
        self._askew = [one for one in steps if np.count_nonzero(one) > 1]
        self._seen = np.zeros(lattice.size, dtype=bool)
        self._failed = np.zeros((0, 3), dtype=np.int64)

    def begin(self) -> Numbers:
        """Reach the cells around the start."""
        new, found = seeds(self._walker, self._lattice)
        self._take(new, found)
        return new

    def go_on(self, begun: Filled) -> Numbers:
        """Take what was reached on a part of the lattice; returns the cells whose ways are not all known."""
        whole = embedded(begun, self._lattice)
        now = np.flatnonzero(whole.inside)
        self._take(now, whole.states[now])
        self.parts[:, now] = whole.ways[:, now]
        new = (whole.ways[:, now] == 0.0).any(axis=0)
        self._seen[now[~new]] = True
        return np.asarray(now[new])

    def _take(self, cells: Numbers, states: Array) -> None:
        self.inside[cells], self.states[cells] = True, states
        if self._told is not None:
            self._told(float(self.inside.sum()))

    def spread(self, new: Numbers) -> None:
        """Go on from new cells by whole cells until nothing new is reached."""
        waiting = self._unknown(new)
        while len(waiting):
            tried, waiting = _one_each(waiting)
            cells, way, beside = tried.T
            begin, ends = self._lattice.coordinates(cells), _ends(self._lattice, cells, way, beside)
            reached, good = self._walker.step(self.states[cells], begin, ends)
            self.parts[way[good], cells[good]] = np.where(beside[good] >= 0, 1.0, 0.5)
            self._failed = np.concatenate([self._failed, tried[~good]])
            good &= beside >= 0
            self._take(beside[good], reached[good])
            waiting = self._open(np.concatenate([waiting, self._unknown(beside[good])]))

    def to_the_edge(self) -> Numbers:
        """Follow all ways that did not lead to the next cell to where they end; returns the cells that came after
        all."""
        tried = self._open(self._failed)
        self._failed = self._failed[:0]
        if not len(tried):
            return tried[:, 0]
        cells, way, beside = tried.T
        ends = _ends(self._lattice, cells, way, beside)
        reached, done = march(self._walker, self.states[cells], self._lattice.coordinates(cells), ends, self._finest)
        self.parts[way, cells] = np.where(beside >= 0, done, 0.5 * done)
        came = np.flatnonzero((done == 1.0) & (beside >= 0))
        came = came[np.unique(beside[came], return_index=True)[1]]
        self._take(beside[came], reached[came])
        return np.asarray(beside[came])

    def _unknown(self, cells: Numbers) -> Numbers:
        """Ways out of cells of which nothing is known yet."""
        ways = _ways_out(self._lattice, cells, self._ways)
        return self._open(ways[self.parts[ways[:, 1], ways[:, 0]] == 0.0])

    def _open(self, ways: Numbers) -> Numbers:
        """Those of ways that do not lead to a cell that is reached by now, which need no walk."""
        cells, way, beside = ways.T
        known = (beside >= 0) & self.inside[beside]
        self.parts[way[known], cells[known]] = 1.0
        return np.asarray(ways[~known])

    def along_diagonals(self) -> Numbers:
        """Reach further cells from those at the edge; returns which came."""
        lattice, edge = self._lattice, np.flatnonzero(self.inside & (self.parts < 1.0).any(axis=0) & ~self._seen)
        self._seen[edge] = True
        found: list[Numbers] = []
        for by in self._askew:
            beside = lattice.shifted(edge, by)
            free = (beside >= 0) & ~self.inside[beside]
            cells, beside = edge[free], beside[free]
            begin, to = lattice.coordinates(cells), lattice.coordinates(beside)
            reached, done = march(self._walker, self.states[cells], begin, to, 1)
            self._take(beside[done == 1.0], reached[done == 1.0])
            found.append(beside[done == 1.0])
        return np.concatenate(found) if found else np.zeros(0, dtype=np.int64)


def _ways_out(lattice: Lattice, cells: Numbers, ways: int) -> Numbers:
    """Ways out of cells, shape (ways, 3): cell, way, and the cell that it leads to, -1 for half a way out of a lattice
    that ends there."""
    found = []
    for way in range(ways):
        beside = lattice.neighbours(cells, way)
        kept = (beside >= 0) | lattice.ends[way // 2]
        found.append(np.stack([cells[kept], np.full(int(kept.sum()), way), beside[kept]], axis=1))
    return np.concatenate(found).astype(np.int64)


def _one_each(ways: Numbers) -> tuple[Numbers, Numbers]:
    """Ways out, one to every cell, and the others."""
    single = np.where(ways[:, 2] >= 0, ways[:, 2], -1 - np.arange(len(ways)))
    first = np.zeros(len(ways), dtype=bool)
    first[np.unique(single, return_index=True)[1]] = True
    return ways[first], ways[~first]


def _ends(lattice: Lattice, cells: Numbers, way: Numbers, beside: Numbers) -> Array:
    """Where ways lead to: the next centre, or the end of the lattice half a cell away."""
    offsets = np.array([lattice.offset(one) for one in range(2 * len(lattice.shape))])
    half = np.where(beside >= 0, 1.0, 0.5)[:, None]
    return np.asarray(lattice.coordinates(cells) + half * offsets[way])
