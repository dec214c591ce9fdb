"""The summary of a study: of every quantity its mean, spread and quantiles, and what it depends on most.

Blocks are read one after another in their order, so that it does not matter who simulated them when.  Means, variances
and ends are of all runs.  Quantiles and rankings are too, up to `MOST` runs of a case; of more they are of every
second, third, ... run, which is told.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from cutjoint.arrays import Array, Values
from cutjoint.compile.many.statistics import Statistics
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.extras import needed
from cutjoint.findings import clip
from cutjoint.reprs import line, one_line, quoted
from cutjoint.studies.folder import StudyFolder, opened
from cutjoint.studies.ranking import Ranking, ranked

if TYPE_CHECKING:
    import pyarrow as pa

MOST = 2**18
"""Numbers of a column and case that quantiles and rankings are made of."""
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
BINS = 40
MOST_REASONS = 5


@dataclass(frozen=True, eq=False)
class ColumnSummary(Values):
    """A column of the table in one case.

    Attributes:
        case: number of the case.
        column: its name.
        unit: of its numbers.
        runs: that did not fail.
        mean, deviation: mean and standard deviation (over runs - 1; not a number of one run).
        least, largest: its ends.
        quantiles: at `QUANTILES`, shape (5,).
        counts: runs in `BINS` bins of equal breadth from least to largest, of those that quantiles are made of.
    """

    case: int
    column: str
    unit: str
    runs: int
    mean: float
    deviation: float
    least: float
    largest: float
    quantiles: Array
    counts: Array

    def __repr__(self) -> str:
        return one_line(
            "ColumnSummary", [quoted(self.column), f"mean={self.mean:.4g} {self.unit}", f"runs={self.runs}"]
        )


@dataclass(frozen=True, eq=False)
class StudySummary(Values):
    """What a study, or what there is of it, comes to.

    Attributes:
        name: of the study.
        folder: where it is.
        method: how its runs were chosen.
        runs, wanted: runs that are done, and all.
        failed, slow: runs that could not be simulated to their end, and those that the model itself did.
        cases: their names.
        columns: a summary a column and case.
        rankings: of the columns that depend on what varied.
        reasons: why runs failed, with how many did; the most frequent ones.
        told: what a reader must know.
    """

    name: str
    folder: Path
    method: str
    runs: int
    wanted: int
    failed: int
    slow: int
    cases: tuple[str, ...]
    columns: tuple[ColumnSummary, ...]
    rankings: tuple[Ranking, ...]
    reasons: tuple[tuple[str, int], ...]
    told: tuple[str, ...]

    __repr__ = line("name", "runs", "wanted", "failed")


@door
def summary_of(folder: str | os.PathLike[str]) -> StudySummary:
    """The summary of a study in a folder.

    Raises:
        InputError: there is none, or its manifest is damaged.
        StudyError: a block is not as it was written.
    """
    found, about = opened(folder)
    return _Blocks(found, about).summary()


@door
def table_of(folder: str | os.PathLike[str], columns: Sequence[str] | None = None) -> Mapping[str, Array]:
    """All runs of a study that are done: column -> its numbers, shape (runs,).

    Args:
        folder: of the study.
        columns: some of `run`, `case`, what varied, and what was kept; default all of them.

    Raises:
        InputError: there is no study or no such column.
        StudyError: a block is not as it was written.
    """
    found, _ = opened(folder)
    known: list[str] = []
    parts: dict[str, list[Array]] = {}
    for block in sorted(found.done):
        table = read_part(found, block)
        known = known or [name for name in table.column_names if name not in ("failed", "slow")]
        for name in known if columns is None else columns:
            if name not in known:
                raise InputError(f"the study in '{found.path}' has no column '{clip(name)}'; it has {', '.join(known)}")
            parts.setdefault(name, []).append(table.column(name).to_numpy())
    return {name: np.concatenate(one) for name, one in parts.items()}


def read_part(folder: StudyFolder, block: int) -> pa.Table:
    """A block as a table.

    Raises:
        StudyError: it is not as it was written.
        InputError: it cannot be read.
    """
    needed("pyarrow", "a study")
    from pyarrow import ArrowException
    from pyarrow.parquet import ParquetFile

    try:
        with ParquetFile(BytesIO(folder.content(block)), pre_buffer=False) as file:
            # Threads of Arrow end a process that has Pinocchio in it with an abort.
            return file.read(use_threads=False)
    except (OSError, ArrowException) as error:
        raise InputError(f"block {block} in '{folder.path}' cannot be read: {str(error)[:200]}") from error


class _Blocks:
    """Reads the blocks of a study once."""

    def __init__(self, folder: StudyFolder, about: Mapping[str, object]) -> None:
        try:
            self.folder, self.method = folder, str(about["method"])
            self.paths = [str(one) for one in cast("list[str]", about["paths"])]
            self.units = {str(name): str(unit) for name, unit in cast("dict[str, str]", about["units"]).items()}
            self.cases = tuple(str(one) for one in cast("list[str]", about["cases"]))
            self.samples, self.wanted = int(cast(int, about["samples"])), int(cast(int, about["runs"]))
            self.size, self.name = int(cast(int, about["block"])), str(about["study"])
            if min(self.samples, self.size) < 1:
                raise ValueError
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise InputError(f"the manifest in '{folder.path}' is damaged") from error
        self.group = len(self.paths) + 2 if self.method == "saltelli" else 1
        self.stride = -(-self.samples // MOST)
        self.runs = self.failed = self.slow = 0
        self.reasons: dict[str, int] = {}

    def summary(self) -> StudySummary:
        """See `summary_of`."""
        columns: list[ColumnSummary] = []
        rankings: list[Ranking] = []
        per_case = -(-self.samples // self.size)
        for case in range(len(self.cases)):
            own = [block for block in sorted(self.folder.done) if block // per_case == case]
            statistics, chosen = self._case(own)
            if not statistics.count:
                continue
            x = np.stack([chosen[path] for path in self.paths], axis=1) if self.paths else np.zeros((0, 0))
            for k, (name, unit) in enumerate(self.units.items()):
                columns.append(_column(case, name, unit, statistics, k, chosen[name]))
                if self.paths and (self.method != "saltelli" or len(own) == per_case):
                    found = ranked(self.method, case, name, self.paths, x, chosen[name])
                    rankings += [] if found is None else [found]
        told = []
        if self.runs < self.wanted:
            told.append(f"{self.runs} of {self.wanted} runs are done; the same command goes on")
        if self.stride > 1:
            told.append(f"quantiles and rankings are of one run in {self.stride}")
        if self.failed:
            told.append("runs that failed are left out of all figures")
        most = sorted(self.reasons.items(), key=lambda one: (-one[1], one[0]))[:MOST_REASONS]
        return StudySummary(
            self.name, self.folder.path, self.method, self.runs, self.wanted, self.failed, self.slow, self.cases,
            tuple(columns), tuple(rankings), tuple(most), tuple(told),
        )  # fmt: skip

    def _case(self, blocks: Sequence[int]) -> tuple[Statistics, dict[str, Array]]:
        """Statistics of all columns, and the numbers of the runs that are chosen for quantiles."""
        statistics, parts = Statistics(), dict[str, list[Array]]()
        for block in blocks:
            table = read_part(self.folder, block)
            runs = table.column("run").to_numpy() % self.samples
            try:
                numbers = {name: table.column(name).to_numpy() for name in (*self.paths, *self.units)}
            except KeyError as error:
                raise InputError(f"block {block} in '{self.folder.path}' lacks a column: {error}") from error
            why = [one for one in table.column("failed").to_pylist() if one is not None]
            for one in why:
                self.reasons[clip(one, 120)] = self.reasons.get(clip(one, 120), 0) + 1
            self.runs, self.failed = self.runs + len(runs), self.failed + len(why)
            self.slow += int(np.count_nonzero(table.column("slow").to_numpy(zero_copy_only=False)))
            kept = np.stack([numbers[name] for name in self.units], axis=1)
            statistics = statistics.extended(kept[np.isfinite(kept).all(axis=1)])
            some = (runs // self.group) % self.stride == 0
            for name, values in numbers.items():
                parts.setdefault(name, []).append(values[some])
        return statistics, {name: np.concatenate(parts.pop(name)) for name in list(parts)}


def _column(case: int, name: str, unit: str, statistics: Statistics, k: int, values: Array) -> ColumnSummary:
    good = values[np.isfinite(values)]
    least, largest = float(statistics.smallest[k]), float(statistics.largest[k])
    quantiles = np.quantile(good, QUANTILES) if len(good) else np.full(len(QUANTILES), np.nan)
    edges = (least, largest) if largest > least else (least - 0.5, least + 0.5)
    counts = np.histogram(good, BINS, edges)[0].astype(np.float64)
    deviation = float(np.sqrt(statistics.variance[k]))
    return ColumnSummary(
        case, name, unit, statistics.count, float(statistics.mean[k]), deviation, least, largest, quantiles, counts
    )
