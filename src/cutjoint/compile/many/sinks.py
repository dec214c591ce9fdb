"""Where many runs go, a chunk at a time: to a function, or into a Parquet file."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from cutjoint.arrays import Array
from cutjoint.compile.many.grid import TimeGrid
from cutjoint.compile.many.results import Many
from cutjoint.compile.many.traced import TracedLoop
from cutjoint.compile.many.variation import Variation
from cutjoint.errors import InputError
from cutjoint.motion import Reference

Into: TypeAlias = Callable[[int, Many], object] | str | os.PathLike[str]
"""A function of the number of the first run of a chunk and the chunk, or the path of a Parquet file."""


@dataclass(frozen=True, eq=False)
class Asked:
    """What a call of a loop asks for: the reference and its table, steps and samples, and what varies."""

    reference: Reference | Array
    rows: Array
    grid: TimeGrid
    variation: Variation


class Sink(Protocol):
    """Takes chunks."""

    def take(self, first: int, many: Many) -> None:
        """A chunk, and the number of its first run."""


@dataclass(frozen=True)
class _Function:
    function: Callable[[int, Many], object]

    def take(self, first: int, many: Many) -> None:
        self.function(first, many)


def sink_of(into: Into, loop: TracedLoop, asked: Asked) -> AbstractContextManager[Sink]:
    """Where `into` says; to be left when all chunks are taken.

    Raises:
        InputError: it is neither function nor path, or the file cannot be written.
    """
    if isinstance(into, str | os.PathLike):
        if not os.fspath(into).endswith(".parquet"):
            raise InputError(
                f"what many runs are written into is a Parquet file, NAME.parquet; found {os.fspath(into)!r}"
            )
        from cutjoint.compile.many.parquet import ParquetSink

        return ParquetSink(into, loop, asked.variation, asked.grid)
    if not callable(into):
        raise InputError(
            f"into must be a function of a run's number and a chunk, or the path of a file, found {into!r}"
        )
    return nullcontext(_Function(into))
