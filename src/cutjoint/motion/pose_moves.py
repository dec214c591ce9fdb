"""Moves of the whole tool: its point along a line while it turns about one axis, from rest to rest.

The rotation is exp([s turn]) R_0 with the rotation vector `turn`, which does not change: so the angular velocity is
s_dot turn, and the angular acceleration s_ddot turn, exactly, also over more than half a turn.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cutjoint.arrays import Array, Values, as_vector, positive, readonly
from cutjoint.doors import door, door_but
from cutjoint.mechanism import Mechanism, Pose
from cutjoint.mechanism.rotations import turned
from cutjoint.motion.home import ToolAtHome
from cutjoint.motion.timing import Progress, minimum_jerk
from cutjoint.motion.values import ROTATION, ToolMotion
from cutjoint.reprs import line


@door_but("start")
@dataclass(frozen=True, eq=False)
class PoseMove(Values):
    """From a pose by a way, turned about one axis, in `duration` [s], with the least jerk (C2), at rest at both ends.

    Attributes:
        start: the pose at 0.
        by: the way of the tool point along the axes of the world, shape (3,), [m].
        turn: rotation vector along the axes of the world, shape (3,), [rad].
        duration: [s].
        given: which coordinates of the task are prescribed (see `ToolMotion`); None for all.
    """

    start: Pose
    by: Array = field(default_factory=lambda: readonly(np.zeros(3)))
    turn: Array = field(default_factory=lambda: readonly(np.zeros(3)))
    duration: float = 1.0
    given: tuple[str, ...] | None = None
    name: str = "pose move"

    __repr__ = line(by="m", turn="rad", duration="s")

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", Pose.of(self.start))
        object.__setattr__(self, "by", readonly(as_vector("by", self.by, 3, "m")))
        object.__setattr__(self, "turn", readonly(as_vector("turn", self.turn, 3, "rad")))
        positive("duration", self.duration, "s")
        self.at(0.0)  # says what is wrong with `given`

    @classmethod
    @door
    def from_home(
        cls, mechanism: Mechanism, x: float, y: float, z: float, rx: float, ry: float, rz: float, seconds: float
    ) -> PoseMove:
        """From where the tool is at home, by a way [m] and a rotation vector [deg] along the axes of the task."""
        home = ToolAtHome.of(mechanism)
        turn = home.basis @ np.radians([rx, ry, rz])
        return cls(home.pose, home.basis @ np.array([x, y, z]), turn, seconds)

    @classmethod
    @door
    def turn_at_home(cls, mechanism: Mechanism, rx: float, ry: float, rz: float, seconds: float) -> PoseMove:
        """Turned by a rotation vector [deg] along the axes of the task.

        Prescribed are the rotations that the robot leads and those that are not zero.  The point stays where the robot
        leads it, and goes where the turn takes it otherwise.
        """
        home, vector = ToolAtHome.of(mechanism), np.radians([rx, ry, rz])
        wanted = dict(zip(ROTATION, vector.tolist(), strict=True))
        given = tuple(name for name, angle in wanted.items() if angle or name in mechanism.task.names)
        return cls(home.pose, turn=home.basis @ vector, duration=seconds, given=given, name="turn")

    def progress(self, t: float) -> Progress:
        """How far along its way it is at time `t` [s]."""
        return minimum_jerk(t, self.duration)

    def at(self, t: float) -> ToolMotion:
        """The desired motion at time `t` [s]."""
        s, rate, change = self.progress(t)
        return ToolMotion(
            self.start.position + s * self.by,
            rate * self.by,
            change * self.by,
            turned(s * self.turn) @ self.start.rotation,
            rate * self.turn,
            change * self.turn,
            self.given,
        )
