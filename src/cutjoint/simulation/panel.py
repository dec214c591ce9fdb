"""A panel: quantities of one run over time in one frame, as a value, and the run that panels are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutjoint.arrays import Array, Values, readonly
from cutjoint.errors import InputError
from cutjoint.reprs import line, told
from cutjoint.simulation.result import Result
from cutjoint.simulation.summary import actuators_of

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain


SAME_TIME = 1e-12
"""Part of the time at which samples and the ends of a stretch are the same: sums of steps round."""


@dataclass(frozen=True, eq=False)
class Panel(Values):
    """Quantities over time.

    Attributes:
        title: what is shown.
        time: shape (m,), [s].
        values: shape (m, n), in `unit`.
        unit: SI unit; small lengths are shown in mm or µm.
        quantity: what the vertical axis measures.
        names: of the n curves.
        bound: a limit to draw at plus and minus this value, in `unit`.
        since: time from which the bound counts [s].
        zoom: stretch of time [s] that is shown again, enlarged, or None.
        limits: lower and upper limit of each curve, shape (n, 2), in `unit`, infinite where there is none; or None.
    """

    title: str
    time: Array
    values: Array
    unit: str
    quantity: str
    names: Sequence[str]
    bound: float | None = None
    since: float = 0.0
    zoom: tuple[float, float] | None = None
    limits: Array | None = None

    __repr__ = line("title", "quantity", "unit", "names", "time", time="s")

    def __post_init__(self) -> None:
        for name in ("time", "values", "limits"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, readonly(getattr(self, name)))


def scaled(values: Array, unit: str) -> tuple[float, str]:
    """Factor and unit in which the values have handy digits."""
    largest = float(np.abs(values).max(initial=0.0))
    if unit.startswith("m") and unit != "m2":
        rest = unit[1:]
        for limit, factor, prefix in ((1e-10, 1e12, "pm"), (1e-7, 1e9, "nm"), (1e-4, 1e6, "µm"), (0.09, 1e3, "mm")):
            if 0.0 < largest < limit:
                return factor, prefix + rest
    return 1.0, unit


class Shown(NamedTuple):
    """A run, and the robot that it was made with, where that is known."""

    run: Result
    robot: ClosedChain | None = None

    def __repr__(self) -> str:
        return told(self, "run", "robot")

    def panel(self, title: str, column: Array, unit: str, quantity: str, names: Sequence[str]) -> Panel:
        """A panel of a column of the run."""
        return Panel(title, self.run.time, column.reshape(len(self.run), -1), unit, quantity, names)

    @property
    def actuators(self) -> list[tuple[str, str]]:
        """Name and kind of each."""
        return actuators_of(self.run)


def between(panels: Sequence[Panel], start: float | None, end: float | None) -> list[Panel]:
    """The samples of panels from `start` to `end` [s]; None for the run's own start or end.

    Raises:
        InputError: that is no stretch of time, or there are no samples in it.
    """
    for one in (start, end):
        if one is not None and not np.isfinite(one):
            raise InputError(f"times to show are finite numbers [s], found {one}")
    if start is not None and end is not None and not start < end:
        raise InputError(f"the stretch of time from {start:g} s to {end:g} s is none; give a start before its end")
    found = []
    for panel in panels:
        kept = np.ones(len(panel.time), dtype=bool)
        slack = SAME_TIME * float(np.abs(panel.time).max())
        if start is not None:
            kept &= panel.time >= start - slack
        if end is not None:
            kept &= panel.time <= end + slack
        if not kept.any():
            raise InputError(
                f"there are no samples from {panel.time[0] if start is None else start:g} s to "
                f"{panel.time[-1] if end is None else end:g} s; the run has them from {panel.time[0]:g} s to "
                f"{panel.time[-1]:g} s"
            )
        found.append(replace(panel, time=panel.time[kept], values=panel.values[kept]))
    return found
