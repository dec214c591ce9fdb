"""What retiming answers: the quickest motion that was found, what it asks of the actuators, and which limit is active
where."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.errors import InputError
from cutjoint.files import write_whole
from cutjoint.mechanism import Actuator
from cutjoint.motion import JointSpline
from cutjoint.reprs import line
from cutjoint.retiming.limits import MotionLimits
from cutjoint.tables import TextTable

ACTIVE = 0.98
"""The part of a limit from which on it is said to be active."""


@dataclass(frozen=True)
class LimitPeak:
    """The largest of one limited quantity along a motion.

    Attributes:
        quantity: what it is, such as `effort of arm1`.
        largest: in its `unit`.
        limit: in the same unit.
        unit: N, m/s, ...
        t: when [s].
        active: the part of the time for which it is at 98 % of its limit or more.
    """

    quantity: str
    largest: float
    limit: float
    unit: str
    t: float
    active: float

    __repr__ = line("quantity", "largest", "limit", "unit", "t", t="s")

    @property
    def part(self) -> float:
        """The largest beside its limit."""
        return self.largest / self.limit


@dataclass(frozen=True, eq=False)
class Retimed(Frozen):
    """The quickest motion along a way that was found.

    Attributes:
        name: of the robot.
        trajectory: the motion of the actuators: the spline through its rows.
        actuators: of the robot, in the order of its columns.
        limits: that it keeps.
        duration: of the motion [s].
        shortest: the time of the quickest motion within the limits but that of jerk, whose acceleration jumps, as it
            follows from the times that more and more samples of the way give [s].
        former: how long the trajectory took [s].
        closed: whether it ends where it begins.
        goes_round: whether it does so at speed, without a rest.
        ramp: the time in which the acceleration goes from one limit to another [s].
        peaks: of all limited quantities, found by inverse dynamics of the trajectory at `checked` instants.
        checked: at how many instants, which are not those of the rows.
        deviation: how far the motion leaves the way, in the coordinates of the actuators [m] or [rad].
        time: instants for a picture, shape (k,) [s].
        place: way length then, shape (k,), 0 to 1.
        speed: its rate, shape (k,) [1/s].
        used: parts of the limits of the quantities of `peaks`, with their signs, shape (k, len(peaks)).
        ceiling: way lengths and the largest rates that the limits leave there, shape (m, 2), [1] and [1/s].
        told: where the limits are from, and what is odd.
    """

    name: str
    trajectory: JointSpline
    actuators: tuple[Actuator, ...]
    limits: MotionLimits
    duration: float
    shortest: float
    former: float
    closed: bool
    goes_round: bool
    ramp: float
    peaks: tuple[LimitPeak, ...]
    checked: int
    deviation: float
    time: Array
    place: Array
    speed: Array
    used: Array
    ceiling: Array
    told: tuple[str, ...] = ()

    __repr__ = line("name", "duration", "shortest", "former", "peaks", duration="s", shortest="s", former="s")

    @property
    def cycles_per_minute(self) -> float | None:
        """How often it is gone in a minute, without a rest between; None where it does not end where it begins."""
        return 60.0 / self.duration if self.closed else None

    @property
    def gap(self) -> float:
        """By what part the motion is longer than the shortest."""
        return self.duration / self.shortest - 1.0

    @property
    def active(self) -> tuple[str, ...]:
        """At each instant of `time` a quantity that is at 98 % of its limit or more, or nothing."""
        parts = np.abs(self.used)
        found, last = [], 0
        for row, most in zip(parts.tolist(), parts.argmax(axis=1).tolist(), strict=True):
            last = last if row[last] >= ACTIVE else most  # where several are, it stays the same one
            found.append(self.peaks[last].quantity if row[last] >= ACTIVE else "")
        return tuple(found)

    def table(self) -> TextTable:
        """The peaks beside their limits."""
        rows = [
            (
                one.quantity,
                f"{one.largest:.5g}",
                f"{one.limit:.5g}",
                one.unit,
                f"{100.0 * one.part:.2f} %",
                f"{one.t:.4g} s",
                f"{100.0 * one.active:.0f} %",
            )
            for one in self.peaks
        ]
        columns = ("quantity", "largest", "limit", "", "part", "at", "active")
        return TextTable(
            f"{self.name}, peaks of {self.checked} instants", columns, rows, right=columns[1:3] + columns[4:]
        )

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the motion as a file that is a trajectory: t and the actuators, the rows of the spline, all digits.

        Raises:
            InputError: the suffix is not .csv, or nothing can be written there.
        """
        path = Path(path)
        if path.suffix.lower() != ".csv":
            raise InputError(f"'{path}': a motion is written as .csv, found '{path.suffix}'")
        names = [f"joint.{one.name}" for one in self.actuators]
        if any(mark in name for name in names for mark in ',;\t"\n'):
            raise InputError(f"actuators of {self.name} have separators in their names, which headings cannot have")
        rows = np.column_stack([self.trajectory.times, self.trajectory.q])
        text = ",".join(["t", *names]) + "\n"
        text += "".join(",".join(map(repr, row)) + "\n" for row in rows.tolist())
        return write_whole(path, text.encode())
