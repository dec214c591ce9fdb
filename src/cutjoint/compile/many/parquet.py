"""Many runs as a Parquet file: a row a run, a row group a chunk.

The file is written beside its place and takes its name when it is whole.  What stops before leaves all chunks until
then in a whole file of the same name with `.stopped` behind it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Self

import numpy as np

from cutjoint import interrupts
from cutjoint.arrays import Array
from cutjoint.compile.many.grid import TimeGrid
from cutjoint.compile.many.results import SAMPLED, Many
from cutjoint.compile.many.traced import TracedLoop
from cutjoint.compile.many.variation import Variation
from cutjoint.extras import needed
from cutjoint.files import Draft, check_place
from cutjoint.simulation.hardware.parts import parts_of

if TYPE_CHECKING:
    import pyarrow as pa
    from pyarrow.parquet import ParquetWriter

PER_RUN = ("error_rms", "error_max", "effort_max")


class ParquetSink:
    """A file that takes chunks.

    Columns: `run`; what varies, by the name of the gain or parameter; `error_rms`, `error_max` and `effort_max`; the
    `samples` of `Many` as a list a run, if there are any between the first and the last; `failed`, the reason or
    nothing; `slow`.  What is one number an actuator has a column each, the name with the actuator's behind it.  The
    metadata `cutjoint` are JSON: robot, law, method, hardware, and the `time` of the samples [s].

    Args:
        path: of the file.
        loop: what is run.
        variation: what varies in it.
        grid: its steps and samples.

    Raises:
        MissingPackageError: pyarrow is not installed.
        InputError: the file cannot be written there.
    """

    def __init__(self, path: str | os.PathLike[str], loop: TracedLoop, variation: Variation, grid: TimeGrid) -> None:
        pa = needed("pyarrow", "a Parquet file")
        self.path = check_place(path)
        self._arrow, self._variation = pa, variation
        self._names = [one.name for one in loop.plant.actuators]
        self._samples = SAMPLED if len(grid.chosen) > 2 else ()
        hardware = loop.hardware
        about = {
            "robot": loop.plant.name,
            "law": loop.law.name,
            "gains": loop.law.gains,
            "method": loop.method,
            "step": grid.step,
            "time": [grid.step * k for k in grid.chosen],
            "hardware": None if hardware is None else parts_of(hardware),
        }
        self._about = {"cutjoint": json.dumps(about)}
        self._draft: Draft | None = None
        self._writer: ParquetWriter | None = None
        self._taken = 0

    def take(self, first: int, many: Many) -> None:
        """A chunk, and the number of its first run."""
        from pyarrow.parquet import ParquetWriter

        table = self._arrow.table(self._columns(first, many)).replace_schema_metadata(self._about)
        if self._writer is None:
            self._draft = Draft(self.path)
            self._writer = ParquetWriter(self._draft.path, table.schema)
        with interrupts.held():
            self._writer.write_table(table, row_group_size=max(1, len(many.q)))
            self._taken = first + len(many.q)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Give the file its name, or what there is of it the name of a stopped one."""
        if self._writer is None or self._draft is None:
            return
        with interrupts.held(), self._draft as draft:
            self._writer.close()
            draft.finish()
            if error is None:
                draft.take_place()
                return
            kept = self.path.with_name(f"{self.path.name}.stopped")
            draft.take_place(kept)
        error.add_note(f"runs 0 to {self._taken - 1} are kept in {kept}")

    def _columns(self, first: int, many: Many) -> Mapping[str, pa.Array]:
        """The columns of a chunk."""
        pa, count = self._arrow, len(many.q)
        part = self._variation.given(first, first + count)
        columns = {"run": pa.array(self._variation.first + np.arange(first, first + count))}
        for name, own in part.items():
            columns |= {name: pa.array(own)} if own.ndim == 1 else self._each(name, own)
        for name in PER_RUN:
            columns |= self._each(name, getattr(many, name))
        for name in self._samples:
            values: Array = getattr(many, name)
            if name == "positions":
                columns[name] = self._lists(values.reshape(count, -1))
            elif values.shape[2]:
                columns |= {f"{name}_{one}": self._lists(values[:, :, k]) for k, one in enumerate(self._names)}
        columns["failed"] = pa.array([many.failed.get(k) for k in range(count)], pa.string())
        columns["slow"] = pa.array(np.isin(np.arange(count), many.slow))
        return columns

    def _each(self, name: str, values: Array) -> dict[str, pa.Array]:
        """(N, n) as a column an actuator."""
        found = {}
        for k, one in enumerate(self._names):
            found[f"{name}_{one}"] = self._arrow.array(np.ascontiguousarray(values[:, k]))
        return found

    def _lists(self, values: Array) -> pa.Array:
        """(N, m) as lists of m numbers."""
        return self._arrow.FixedSizeListArray.from_arrays(self._arrow.array(values.ravel()), values.shape[1])
