"""When things happen in a run: steps, samples of the record, and sample instants of the controller."""

from __future__ import annotations

from dataclasses import dataclass

from cutjoint.arrays import positive
from cutjoint.errors import InputError
from cutjoint.simulation.integrators import steps_within

WHOLE = 1e-9
"""A span that is a whole number of steps up to this part of it is one."""


@dataclass(frozen=True)
class TimeGrid:
    """Steps of `step` [s] from time 0, and samples every `stride` of them and at the end.

    `beat` is the number of steps in a tick of the controller's clock; 0 where it acts continuously.
    """

    step: float
    steps: int
    stride: int
    beat: int = 0

    @property
    def chosen(self) -> list[int]:
        """The steps that are samples."""
        return [*range(0, self.steps, self.stride), self.steps]


def time_grid(span: float, step: float, tick: float | None, every: float | None) -> TimeGrid:
    """The grid of a run.

    Args:
        span: how long it is [s].
        step: longest step [s]; it is cut so that whole ones fill the span, or a tick.
        tick: of the controller's clock [s]; None acts continuously.
        every: distance of the samples [s]; None: only the first and the last.

    Raises:
        InputError: not positive, or a sampled run whose span is no whole number of steps.
    """
    size = positive("step", step, "s")
    if tick is None:
        beat, steps = 0, max(1, round(span / size))
        size = span / steps
    else:
        beat = steps_within(tick, size)
        size = tick / beat
        steps = round(span / size)
        if steps < 1 or abs(steps * size - span) > WHOLE * span:
            raise InputError(
                f"a run of {span:g} s is no whole number of steps of {size:g} s, which fill the controller's tick of "
                f"{tick:g} s; take {max(1, steps) * size:.9g} s"
            )
    stride = steps if every is None else max(1, round(positive("every", every, "s") / size))
    return TimeGrid(size, steps, stride, beat)
