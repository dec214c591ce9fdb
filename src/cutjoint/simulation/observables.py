"""What is recorded of a run: a row a column.  A new column: a row here, and no more.

Every row is an attribute of `Result`, an array in an npz file, and columns with titles and units in a CSV file.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.motion import Desired
from cutjoint.simulation.plant import Observation


class Instant(NamedTuple):
    """One instant of a run: time [s], what was seen and desired, effort of the actuators from then on and their work
    since the start [J]."""

    t: float
    seen: Observation
    desired: Desired
    effort: Array
    work: float


@dataclass(frozen=True)
class Observable:
    """One column.

    Attributes:
        size: entries a sample: 1 (a plain number), 2 (distance and angle), 3 (x, y, z), "n" (one an actuator) or "nq"
            (a configuration, which CSV files leave out).
        title: in CSV files; the actuator's name comes before it, the axis after it.
        units: one for all entries, or one for sliding and one for turning actuators, or for distance and angle.
        take: the column of a sample.
        about: what it is.
    """

    size: Literal[1, 2, 3, "n", "nq"]
    title: str
    units: tuple[str, ...]
    take: Callable[[Instant], npt.ArrayLike]
    about: str

    def __str__(self) -> str:
        shape = "(m,)" if self.size == 1 else f"(m, {self.size})"
        units = " or ".join(f"[{unit}]" for unit in self.units)
        return f"{self.about}, shape {shape}{units and f', {units}'}"

    def fits(self, array: Array, m: int, n: int) -> bool:
        """Whether `array` may be this column in a result of m samples and n actuators."""
        if self.size == "nq":
            return array.ndim == 2 and len(array) == m
        return array.shape == (m, *{1: (), 2: (2,), 3: (3,), "n": (n,)}[self.size])

    def titles(self, actuators: Sequence[Sequence[str]]) -> list[str]:
        """Headings in a CSV file, one an entry; `actuators` are names and kinds."""
        if self.size == "n":
            of_kind = {"translation": self.units[0]}
            named = ((f"{name} {self.title}".rstrip(), of_kind.get(kind, self.units[-1])) for name, kind in actuators)
            return [f"{title} [{unit}]" for title, unit in named]
        if self.size == 3:
            return [f"{self.title} {axis} [{self.units[0]}]" for axis in "xyz"]
        return [f"{self.title} [{unit}]" for unit in self.units]


PLACE, SPEED = ("m", "rad"), ("m/s", "rad/s")

OBSERVABLES: dict[str, Observable] = {
    "time": Observable(1, "time", ("s",), lambda at: at.t, "time, strictly increasing"),
    "q": Observable("n", "", PLACE, lambda at: at.seen.q, "actuated coordinates"),
    "v": Observable("n", "speed", SPEED, lambda at: at.seen.v, "actuated velocities"),
    "desired_q": Observable("n", "desired", PLACE, lambda at: at.desired.q, "what `q` should have been"),
    "desired_v": Observable("n", "speed desired", SPEED, lambda at: at.desired.v, "what `v` should have been"),
    "effort": Observable("n", "effort", ("N", "N m"), lambda at: at.effort, "given from each sample on"),
    "tool": Observable(3, "tool", ("m",), lambda at: at.seen.tool, "position of the tool"),
    "tool_velocity": Observable(3, "tool velocity", ("m/s",), lambda at: at.seen.tool_velocity, "its velocity"),
    "desired_tool": Observable(
        3, "desired tool", ("m",), lambda at: at.desired.tool.position, "what `tool` should have been"
    ),
    "desired_tool_velocity": Observable(
        3, "desired tool velocity", ("m/s",), lambda at: at.desired.tool.velocity, "what its velocity should have been"
    ),
    "gap": Observable(2, "loop gap", PLACE, lambda at: at.seen.gap, "worst loop residual"),
    "kinetic": Observable(1, "kinetic", ("J",), lambda at: at.seen.kinetic, "kinetic energy of the plant"),
    "potential": Observable(1, "potential", ("J",), lambda at: at.seen.potential, "potential energy of the plant"),
    "work": Observable(1, "work", ("J",), lambda at: at.work, "work of the actuators since the start"),
    "q_full": Observable("nq", "", (), lambda at: at.seen.q_full, "full configuration"),
}
