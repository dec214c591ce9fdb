"""What retiming answers: the quickest motion that was found, what it asks of the actuators, and which limit is active
where."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.mechanism import Actuator
from cutjoint.motion import JointSpline
from cutjoint.reprs import line
from cutjoint.retiming.limit_peaks import ACTIVE, LimitPeak, table_of, write_motion
from cutjoint.retiming.limits import MotionLimits
from cutjoint.tables import TextTable


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
        return table_of(self.name, self.checked, self.peaks)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the motion as a file that is a trajectory: t and the actuators, the rows of the spline, all digits.

        Raises:
            InputError: the suffix is not .csv, or nothing can be written there.
        """
        return write_motion(path, self.trajectory, self.actuators, self.name)
