"""Runs side by side through the compiled loop, block by block and on several cores."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.compile.machine.kernel import Runs, Sizes
from cutjoint.compile.many.grid import TimeGrid
from cutjoint.compile.many.instants import Bytes, Chances
from cutjoint.compile.many.variation import SomeRuns

EVALUATIONS = 250_000
"""Steps of runs in a block: often enough to report, seldom enough not to matter."""
BRIEF = 100_000
"""Steps of runs that take no longer than anybody notices: done at once, without a thread."""
NOISE = 2**20
"""Most bytes of noise of a block, unless a single group has more."""


class Blocks:
    """The runs of one call.

    Args:
        runs: the compiled loop.
        sizes: its numbers.
        part: what the runs begin with and have of their own.
        rows: the reference.
        grid: steps and samples.
        chances: instants and noise; None under continuous control.

    Attributes:
        records: shape (N, samples, width).
        sums: shape (N, totals).
    """

    def __init__(
        self, runs: Runs, sizes: Sizes, part: SomeRuns, rows: Array, grid: TimeGrid, chances: Chances | None
    ) -> None:
        self.count, self.grid, self.chances, self._numbers = len(part.state), grid, chances, part.numbers
        self.lanes = 1 if self.count == 1 else runs.lanes
        self.groups = -(-self.count // self.lanes)
        self._call = runs.loop(self.lanes)
        self._given = [self._grouped(part.state), self._grouped(part.given), np.ascontiguousarray(rows)]
        shape = (self.groups, len(grid.chosen), sizes.width, self.lanes)
        self._records, self._sums = _aligned(shape), _aligned((self.groups, sizes.totals, self.lanes))
        self._chance = np.zeros((2, self.groups, self.lanes), dtype=np.int64)
        self._due = None if chances is None or not chances.alike else chances.due(part.numbers[0])
        arrays = (*self._given, self._records, self._sums)
        self._flag, self._sizes = np.zeros(1, dtype=np.int64), sizes
        self._sums[:, 2 * sizes.watched] = np.nan
        addresses = [*(x.ctypes.data for x in arrays), len(grid.chosen), *(x.ctypes.data for x in self._chance)]
        addresses.append(self._flag.ctypes.data)
        self._table = np.array(addresses, dtype=np.int64)

    def go(self, threads: int, progress: Callable[[float], None] | None) -> None:
        """Simulate all runs; `progress` is called with the fraction that is done.  Whatever is raised meanwhile, such
        as a `KeyboardInterrupt`, ends them all within a step.
        """
        workers = min(threads, self.groups)
        size = max(1, min(-(-self.groups // workers), EVALUATIONS // (self.grid.steps * self.lanes) + 1))
        if self.chances is not None and self.chances.channels:
            size = max(1, min(size, NOISE // (8 * self.lanes * self.chances.samples * self.chances.channels)))
        edges = range(0, self.groups, size)

        def work(begin: int) -> None:
            self._work(begin, min(begin + size, self.groups))

        def done(count: int) -> None:
            if progress is not None:
                progress(count / len(edges))

        if workers == 1 and self.groups * self.lanes * self.grid.steps <= BRIEF:
            for number, begin in enumerate(edges, start=1):
                work(begin)
                done(number)
            return
        with ThreadPoolExecutor(workers) as pool:
            try:
                for number, _ in enumerate(pool.map(work, edges), start=1):
                    done(number)
            except BaseException:
                self._flag[0] = 1
                pool.shutdown(cancel_futures=True)
                raise

    @property
    def whole(self) -> int:
        """How many of the first runs are done to their ends."""
        done = ~np.isnan(self._sums[:, 2 * self._sizes.watched, 0])
        groups = self.groups if done.all() else int(np.argmin(done))
        return min(groups * self.lanes, self.count)

    @property
    def records(self) -> Array:
        """See the class."""
        flat = self._records.transpose(0, 3, 1, 2)
        return flat.reshape(self.groups * self.lanes, *flat.shape[2:])[: self.count]

    @property
    def sums(self) -> Array:
        """See the class."""
        return self._sums.transpose(0, 2, 1).reshape(self.groups * self.lanes, -1)[: self.count]

    def _work(self, begin: int, end: int) -> None:
        """The groups from `begin` to `end`; Python's lock is free while noise is drawn and while they run."""
        kept = self._chances(begin, end)
        grid = self.grid
        self._call(begin, end, grid.steps, grid.stride, grid.step, STRAIN_LIMIT, self._table.ctypes.data)
        del kept  # until here the loop reads it

    def _chances(self, begin: int, end: int) -> list[Array | Bytes]:
        """Instants and noise of some groups: their addresses go into the table, they themselves to the caller."""
        chances, kept = self.chances, list[Array | Bytes]()
        if chances is None:
            return kept
        if self._due is not None:
            self._chance[0, begin:end] = self._due.ctypes.data
        for group in range(begin, end):
            for lane in range(self.lanes):
                number = min(group * self.lanes + lane, self.count - 1)
                if number != group * self.lanes + lane:
                    self._chance[:, group, lane] = self._chance[:, group, lane - 1]
                    continue
                if self._due is None:
                    kept.append(chances.due(self._numbers[number]))
                    self._chance[0, group, lane] = kept[-1].ctypes.data
                if chances.channels:
                    kept.append(chances.noise(self._numbers[number]))
                    self._chance[1, group, lane] = kept[-1].ctypes.data
        return kept

    def _grouped(self, values: Array) -> Array:
        """(N, k) as (groups, k, lanes); the last group is filled up with its last run."""
        index = np.minimum(np.arange(self.groups * self.lanes), len(values) - 1)
        made = _aligned((self.groups, values.shape[1], self.lanes))
        made[:] = values[index].reshape(self.groups, self.lanes, values.shape[1]).transpose(0, 2, 1)
        return made


def _aligned(shape: tuple[int, ...]) -> Array:
    """Zeros that start at a multiple of 64 bytes."""
    size = math.prod(shape)
    raw = np.zeros(size + 8)
    first = (-raw.ctypes.data % 64) // 8
    return raw[first : first + size].reshape(shape)
