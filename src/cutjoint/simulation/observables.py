"""What is recorded of a run: a row a column.  A new column: a row here, and no more.

Every row is an attribute of `Result`, an array in an npz file, and columns with titles and units in a CSV file.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.mechanism.rotations import matrix_of, quaternion_of, vector_of
from cutjoint.motion import Desired
from cutjoint.simulation.hardware.electronics import Signals
from cutjoint.simulation.plant import Observation


class Works(NamedTuple):
    """Work since the start of a run [J]: of the actuators; of loads from outside, and what friction took, where there
    are any."""

    actuators: float
    loads: float | None = None
    friction: float | None = None


class Instant(NamedTuple):
    """One instant of a run: time [s], what was seen, what was desired (None where nothing is followed), effort of the
    actuators from then on, work since the start, and what passed between law and joints (None of runs without
    hardware)."""

    t: float
    seen: Observation
    desired: Desired | None
    effort: Array
    work: Works
    signals: Signals | None = None


@dataclass(frozen=True)
class Observable:
    """One column.

    Attributes:
        size: entries a sample: 1 (a plain number), 2 (distance and angle), 3 (x, y, z), 4 (quaternion x, y, z, w),
            "n" (one an actuator) or "nq" (a configuration, which CSV files leave out).
        title: in CSV files; the actuator's name comes before it, the axis after it.
        units: one for all entries, or one for sliding and one for turning actuators, or for distance and angle.
        take: the column of a sample; None where the run has no such column.
        about: what it is.
    """

    size: Literal[1, 2, 3, 4, "n", "nq"]
    title: str
    units: tuple[str, ...]
    take: Callable[[Instant], npt.ArrayLike | None]
    about: str

    def __str__(self) -> str:
        shape = "(m,)" if self.size == 1 else f"(m, {self.size})"
        units = " or ".join(f"[{unit}]" for unit in self.units)
        return f"{self.about}, shape {shape}{units and f', {units}'}"

    def fits(self, shape: tuple[int, ...], m: int, n: int) -> bool:
        """Whether an array of that shape may be this column in a result of m samples and n actuators."""
        if self.size == "nq":
            return len(shape) == 2 and shape[0] == m
        return shape == (m, *{1: (), 2: (2,), 3: (3,), 4: (4,), "n": (n,)}[self.size])

    def titles(self, actuators: Sequence[Sequence[str]]) -> list[str]:
        """Headings in a CSV file, one an entry; `actuators` are names and kinds."""
        if self.size == "n":
            of_kind = {"translation": self.units[0]}
            named = ((f"{name} {self.title}".rstrip(), of_kind.get(kind, self.units[-1])) for name, kind in actuators)
            return [f"{title} [{unit}]" for title, unit in named]
        if self.size in (3, 4):
            return [f"{self.title} {axis} [{self.units[0]}]" for axis in "xyzw"[: self.size]]
        return [f"{self.title} [{unit}]" for unit in self.units]


PLACE, SPEED, EFFORT = ("m", "rad"), ("m/s", "rad/s"), ("N", "N m")


def _of_desired(value: Callable[[Desired], npt.ArrayLike]) -> Callable[[Instant], npt.ArrayLike | None]:
    """`value` of what was desired, where anything was."""
    return lambda at: None if at.desired is None else value(at.desired)


def _of_signals(value: Callable[[Signals], Array | None]) -> Callable[[Instant], npt.ArrayLike | None]:
    """`value` of what passed between law and joints, where hardware was between them."""
    return lambda at: None if at.signals is None else value(at.signals)


def _desired_orientation(at: Instant) -> npt.ArrayLike | None:
    if at.desired is None or at.desired.tool.rotation is None or at.seen.orientation is None:
        return None
    return quaternion_of(at.desired.tool.rotation)


def _turned_away(at: Instant) -> float | None:
    if at.desired is None or at.desired.tool.rotation is None or at.seen.orientation is None:
        return None
    return float(np.linalg.norm(vector_of(at.desired.tool.rotation @ matrix_of(at.seen.orientation).T)))


OBSERVABLES: dict[str, Observable] = {
    "time": Observable(1, "time", ("s",), lambda at: at.t, "time, strictly increasing"),
    "q": Observable("n", "", PLACE, lambda at: at.seen.q, "actuated coordinates"),
    "v": Observable("n", "speed", SPEED, lambda at: at.seen.v, "actuated velocities"),
    "desired_q": Observable("n", "desired", PLACE, _of_desired(lambda one: one.q), "what `q` should have been"),
    "desired_v": Observable("n", "speed desired", SPEED, _of_desired(lambda one: one.v), "what `v` should have been"),
    "effort": Observable("n", "effort", EFFORT, lambda at: at.effort, "given at the joints from each sample on"),
    "measured_q": Observable(
        "n", "measured", PLACE, _of_signals(lambda one: one.measured_q), "what the law saw last of `q`"
    ),
    "measured_v": Observable(
        "n", "speed measured", SPEED, _of_signals(lambda one: one.measured_v), "what the law saw last of `v`"
    ),
    "asked": Observable("n", "asked", EFFORT, _of_signals(lambda one: one.asked), "effort the law asked for last"),
    "command": Observable(
        "n", "command", EFFORT, _of_signals(lambda one: one.command), "command in effect from each sample on"
    ),
    "rotor_q": Observable(
        "n", "rotor", PLACE, _of_signals(lambda one: one.rotor_q), "rotors before play, as seen from the joints"
    ),
    "rotor_v": Observable("n", "speed of rotor", SPEED, _of_signals(lambda one: one.rotor_v), "their velocities"),
    "tool": Observable(3, "tool", ("m",), lambda at: at.seen.tool, "position of the tool"),
    "tool_velocity": Observable(3, "tool velocity", ("m/s",), lambda at: at.seen.tool_velocity, "its velocity"),
    "desired_tool": Observable(
        3, "desired tool", ("m",), _of_desired(lambda one: one.tool.position), "what `tool` should have been"
    ),
    "desired_tool_velocity": Observable(
        3,
        "desired tool velocity",
        ("m/s",),
        _of_desired(lambda one: one.tool.velocity),
        "what its velocity should have been",
    ),
    "orientation": Observable(
        4, "orientation", ("1",), lambda at: at.seen.orientation, "quaternion x, y, z, w of a tool that can turn"
    ),
    "angular_velocity": Observable(
        3, "angular velocity", ("rad/s",), lambda at: at.seen.angular_velocity, "of a tool that can turn, in the world"
    ),
    "desired_orientation": Observable(
        4, "desired orientation", ("1",), _desired_orientation, "what `orientation` should have been"
    ),
    "orientation_error": Observable(
        1, "orientation error", ("rad",), _turned_away, "angle between the two orientations"
    ),
    "gap": Observable(2, "loop gap", PLACE, lambda at: at.seen.gap, "worst loop residual"),
    "kinetic": Observable(1, "kinetic", ("J",), lambda at: at.seen.kinetic, "kinetic energy of the plant"),
    "potential": Observable(1, "potential", ("J",), lambda at: at.seen.potential, "potential energy of the plant"),
    "work": Observable(1, "work", ("J",), lambda at: at.work.actuators, "work of the actuators since the start"),
    "load_work": Observable(
        1, "load work", ("J",), lambda at: at.work.loads, "work of the loads from outside since the start"
    ),
    "dissipated": Observable(
        1, "dissipated", ("J",), lambda at: at.work.friction, "work that dampers and friction took since the start"
    ),
    "q_full": Observable("nq", "", (), lambda at: at.seen.q_full, "full configuration"),
}

DESIRED = ("desired_q", "desired_v", "desired_tool", "desired_tool_velocity", "desired_orientation")
"""The columns of what was desired."""


def gathered(samples: Mapping[str, Sequence[npt.ArrayLike]]) -> dict[str, Array]:
    """The columns of a run by name.  Of a quaternion and its negative, which are one rotation, the nearer to the sample
    before is taken, and at the start the one of the desired orientation nearer to the actual one."""
    columns = {name: np.array(column, dtype=np.float64) for name, column in samples.items()}
    actual, desired = columns.get("orientation"), columns.get("desired_orientation")
    if actual is not None and desired is not None and actual[0] @ desired[0] < 0.0:
        desired *= -1.0
    for name, column in columns.items():
        if OBSERVABLES[name].size == 4:
            turned = np.einsum("ij,ij->i", column[1:], column[:-1]) < 0.0
            column[1:] *= np.where(np.cumsum(turned) % 2, -1.0, 1.0)[:, None]
    return columns
