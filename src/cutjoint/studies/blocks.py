"""Blocks: so many runs of one case in a row, the unit of a study.  A block is made of the recipe and its number alone,
by whoever has time, and is one Parquet file, the same to the last bit on processors of one kind.
"""

from __future__ import annotations

import hashlib
import threading
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutjoint.compile.batch import cores
from cutjoint.compile.machine.llvm.native import host
from cutjoint.extras import needed
from cutjoint.reprs import line
from cutjoint.studies.cases import Recipe
from cutjoint.studies.loops import BlockRows, PreparedCase, Told
from cutjoint.studies.sampling import drawn

if TYPE_CHECKING:
    import pyarrow as pa


class BlockSpan(NamedTuple):
    """Which runs a block has: of which case, and its samples from `begin` to before `end`."""

    case: int
    begin: int
    end: int


@dataclass(frozen=True)
class BlockPlan:
    """How the runs of a study are cut into blocks.

    Attributes:
        cases: how many.
        samples: runs of each.
        size: runs of a block; the last one of a case may have fewer.
    """

    cases: int
    samples: int
    size: int

    __repr__ = line()

    @property
    def per_case(self) -> int:
        """Blocks of a case."""
        return -(-self.samples // self.size)

    @property
    def count(self) -> int:
        """Blocks of all cases."""
        return self.cases * self.per_case

    @property
    def runs(self) -> int:
        """Runs of all cases."""
        return self.cases * self.samples

    def span(self, block: int) -> BlockSpan:
        """The runs of a block."""
        case, number = divmod(block, self.per_case)
        return BlockSpan(case, number * self.size, min((number + 1) * self.size, self.samples))


class Prepared:
    """The cases of a recipe, each compiled when first asked for; may be asked by several threads."""

    def __init__(self, recipe: Recipe) -> None:
        self.recipe = recipe
        self._cases: dict[int, PreparedCase] = {}
        self._lock = threading.Lock()

    def case(self, k: int) -> PreparedCase:
        """Case number `k`; errors as of `PreparedCase`."""
        with self._lock:
            if k not in self._cases:
                self._cases[k] = PreparedCase(self.recipe.study, self.recipe.cases[k])
                _ = self._cases[k].table
            return self._cases[k]

    def plan(self) -> BlockPlan:
        """How the study is cut into blocks: it says so, or as suits its first case."""
        study = self.recipe.study
        return BlockPlan(study.cases, study.samples, study.block or self.case(0).block(study.samples))

    def rows(self, span: BlockSpan, told: Told | None = None) -> pa.Table:
        """The runs of a block as a table."""
        study, case = self.recipe.study, self.case(span.case)
        spreads = self.recipe.cases[span.case].spreads
        values = drawn(study.method, spreads, study.samples, study.seed, span.begin, span.end)
        return _table(case, span, values, case.run(values, span.begin, told), study.samples)

    def block(self, plan: BlockPlan, number: int, told: Told | None = None) -> bytes:
        """A block as a Parquet file."""
        return written(self.rows(plan.span(number), told))


def _table(case: PreparedCase, span: BlockSpan, values: np.ndarray, rows: BlockRows, samples: int) -> pa.Table:
    pa = needed("pyarrow", "a study")
    columns = {
        "run": pa.array(span.case * samples + np.arange(span.begin, span.end)),
        "case": pa.array(np.full(len(values), span.case, dtype=np.int32)),
    }
    columns |= {path: pa.array(np.ascontiguousarray(values[:, k])) for k, path in enumerate(case.paths)}
    columns |= {name: pa.array(np.ascontiguousarray(x)) for name, x in rows.columns.items()}
    columns["failed"] = pa.array(rows.failed, pa.string())
    columns["slow"] = pa.array(rows.slow, pa.bool_())
    return pa.table(columns)


def written(table: pa.Table) -> bytes:
    """A table as a Parquet file."""
    from pyarrow.parquet import write_table

    file = BytesIO()
    write_table(table, file, row_group_size=max(1, table.num_rows), use_dictionary=False, compression="zstd")
    return file.getvalue()


def digest(content: bytes) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(content).hexdigest()


def processor() -> str:
    """The kind of this processor: on another one a product and a sum may be rounded otherwise."""
    own = host()
    return f"{own.name} {hashlib.sha256(str(own).encode()).hexdigest()[:8]}"


def workers_here() -> int:
    """Threads that simulate in this process."""
    return cores()
