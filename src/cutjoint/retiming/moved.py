"""What moves from point to point are: when the robot stands, what is asked of the actuators, and how far loops gape."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from cutjoint.arrays import Array, Frozen
from cutjoint.mechanism import Actuator
from cutjoint.motion import JointSpline
from cutjoint.reprs import line
from cutjoint.retiming.limit_peaks import LimitPeak, table_of, write_motion
from cutjoint.retiming.limits import MotionLimits
from cutjoint.tables import TextTable


@dataclass(frozen=True, eq=False)
class Moved(Frozen):
    """Moves from home through points, at rest at each.

    Attributes:
        name: of the robot.
        trajectory: the motion of the actuators; the jerk is constant between its rows.
        actuators: of the robot, in the order of its columns.
        limits: that it keeps.
        stops: when the robot stands, at home first, shape (moves + 1,) [s].
        points: coordinates there, shape (moves + 1, n) [m] or [rad].
        slowed: by what factor each move takes longer than jerk, acceleration and speed alone would let it, shape
            (moves,); 1 where they are all that limits it, and the move is the quickest then.
        peaks: of all limited quantities.
        checked: at how many instants the robot was looked at.
        gap: how far the loops were open at worst at these instants, ([m], [rad]).
        time: those instants, shape (checked,) [s].
        used: parts of the limits of the quantities of `peaks` then, with their signs, shape (checked, len(peaks)).
        told: where the limits are from, and what is odd.
    """

    name: str
    trajectory: JointSpline
    actuators: tuple[Actuator, ...]
    limits: MotionLimits
    stops: Array
    points: Array
    slowed: Array
    peaks: tuple[LimitPeak, ...]
    checked: int
    gap: tuple[float, float]
    time: Array
    used: Array
    told: tuple[str, ...] = ()

    __repr__ = line("name", "duration", "stops", "peaks", duration="s", stops="s")

    @property
    def duration(self) -> float:
        """Of the whole motion [s]."""
        return float(self.stops[-1])

    @property
    def closed(self) -> bool:
        """Whether it ends at home."""
        return self.trajectory.closed

    def table(self) -> TextTable:
        """The peaks beside their limits."""
        return table_of(self.name, self.checked, self.peaks)

    def stops_table(self) -> TextTable:
        """When each move begins and how long it takes."""
        rows = [
            (f"{k + 1}", f"{start:.5g} s", f"{end - start:.5g} s", f"{by:.4g}")
            for k, (start, end, by) in enumerate(
                zip(self.stops[:-1].tolist(), self.stops[1:].tolist(), self.slowed.tolist(), strict=True)
            )
        ]
        columns = ("move", "begins at", "takes", "slowed by")
        return TextTable(f"{self.name}, moves", columns, rows, right=columns)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the motion as a file that is a trajectory: t and the actuators, the rows of the spline, all digits.

        Raises:
            InputError: the suffix is not .csv, or nothing can be written there.
        """
        return write_motion(path, self.trajectory, self.actuators, self.name)
