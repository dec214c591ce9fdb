"""When the hardware of many runs captures, computes and applies, in steps of the integrator."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.compile.many.grid import TimeGrid
from cutjoint.simulation.hardware import Hardware
from cutjoint.simulation.hardware.noise import Jitter, Noise
from cutjoint.simulation.hardware.schedule import STAGES, Stage
from cutjoint.simulation.hardware.ticks import Ticks

Bytes = npt.NDArray[np.uint8]


def together(ticks: Ticks) -> list[list[Stage]]:
    """The stages of a sample; those that always come at one instant stand in one list."""
    capture, compute, apply = STAGES
    found = [[capture]]
    for late, stage in ((ticks.seen_late, compute), (ticks.acts_late, apply)):
        if late:
            found.append([stage])
        else:
            found[-1].append(stage)
    return found


class Chances:
    """Instants and noise of runs.

    Args:
        hardware: of the loop.
        grid: its steps.
        channels: random numbers a sample.
    """

    def __init__(self, hardware: Hardware, grid: TimeGrid, channels: int) -> None:
        self.hardware, self.grid, self.channels = hardware, grid, channels
        self.samples = grid.steps // (grid.beat * hardware.ticks.period) + 3

    def due(self, run: int) -> Bytes:
        """What falls due before each step of a run and at its end, shape (steps + 1,): bit k for list k of
        `together`."""
        ticks, steps = self.hardware.ticks, self.grid.steps
        edges = ticks.period * np.arange(self.samples)
        if ticks.jitter:
            edges = edges + Jitter(self.hardware.seed, run, ticks.jitter).ticks(self.samples)
        found = np.zeros(steps + 1, dtype=np.uint8)
        for bit, stages in enumerate(together(ticks)):
            late = {"capture": 0, "compute": ticks.seen_late, "apply": ticks.seen_late + ticks.acts_late}[stages[0]]
            at = (edges + late) * self.grid.beat
            found[at[at <= steps]] |= np.uint8(1 << bit)
        return found

    @property
    def alike(self) -> bool:
        """Whether all runs have the same instants."""
        return self.hardware.ticks.jitter == 0

    def noise(self, run: int) -> Array:
        """Standard normal numbers of a run, shape (samples, channels): a row more than it draws."""
        return Noise(self.hardware.seed, run, self.channels).rows(self.samples)
