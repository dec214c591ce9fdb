"""What a back end offers that simulates many runs in one loop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeAlias


@dataclass(frozen=True)
class Sizes:
    """Numbers of a run: state, columns of the reference table, per-run arguments, watched values, residuals."""

    state: int
    columns: int
    given: int
    watched: int
    settled: int
    """Leading part of the state that the settling function rewrites; 0 where there is none."""


RunLoop: TypeAlias = Callable[[int, int, int, int, float, float, int], None]
"""(first group, group after the last, steps, steps from record to record, step [s], limit of the strain, address of the
table of addresses); see `cutjoint.compile.machine.llvm.run_loop`."""


class Runs(Protocol):
    """A loop over runs that is compiled when asked for.

    Attributes:
        lanes: runs that go side by side, a group.
    """

    @property
    def lanes(self) -> int:
        """See the class."""

    def loop(self, lanes: int) -> RunLoop:
        """The loop over groups of so many runs: 1, or `lanes` of them."""
