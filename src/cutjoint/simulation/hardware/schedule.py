"""When a sampled loop captures, computes and applies: instants in the order of time."""

from __future__ import annotations

from typing import Literal

from cutjoint.simulation.hardware.noise import Jitter
from cutjoint.simulation.hardware.ticks import Ticks

Stage = Literal["capture", "compute", "apply"]
STAGES: tuple[Stage, ...] = ("capture", "compute", "apply")
AT_ONCE = 256
"""Edges that are drawn at a time."""


class Schedule:
    """The instants of one run.  At one tick the stages are in the order of `STAGES`."""

    def __init__(self, ticks: Ticks, jitter: Jitter) -> None:
        self.ticks = ticks
        self._jitter = jitter
        self._edges: list[int] = []
        self._after = (0, ticks.seen_late, ticks.seen_late + ticks.acts_late)
        self._samples = [0, 0, 0]
        self._next = [self._edge(0) + after for after in self._after]

    @property
    def next(self) -> float:
        """The next instant [s]."""
        return self.ticks.time(min(self._next))

    def due(self) -> list[Stage]:
        """The stages of the next instant, which is then over."""
        now = min(self._next)
        found = [index for index in range(len(STAGES)) if self._next[index] == now]
        for index in found:
            self._samples[index] += 1
            self._next[index] = self._edge(self._samples[index]) + self._after[index]
        return [STAGES[index] for index in found]

    def _edge(self, sample: int) -> int:
        """Tick of the edge of a sample."""
        if self.ticks.jitter == 0:
            return sample * self.ticks.period
        while sample >= len(self._edges):
            begun = len(self._edges)
            late = self._jitter.ticks(AT_ONCE).tolist()
            self._edges += [(begun + i) * self.ticks.period + one for i, one in enumerate(late)]
        return self._edges[sample]
