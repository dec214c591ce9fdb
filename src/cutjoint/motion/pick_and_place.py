"""Pick and place: up, across, down, and the same way back.

The cycle by which makers state the speed of pick-and-place robots is 25 mm up, 305 mm across and 25 mm down, there and
back (one inch, twelve inches, one inch).  Lift and crossing each have the least jerk; they overlap, which rounds the
corners, so that the whole is C2 and rests at both ends.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, Values, as_vector, positive, readonly
from cutjoint.doors import door
from cutjoint.errors import ClosureError, InputError, SingularError, UnreachableError
from cutjoint.mechanism import Mechanism, Pose
from cutjoint.motion.home import ToolAtHome
from cutjoint.motion.timing import minimum_jerk
from cutjoint.motion.values import ToolMotion
from cutjoint.reprs import line

UP, ACROSS = 0.025, 0.305
"""The cycle of the industry [m]."""
LIFT, EARLY = 0.4, 0.2
"""Parts of a way over: that of the lift, as of the descent, and that after which the crossing begins."""
MARGIN = 0.8
"""How much of the largest cycle that a robot can go is gone."""
HALVINGS, REFINED, LOOKS = 24, 4, 12
"""How far a cycle is made smaller, how finely it is fitted, and at how many places it is looked at."""


@door
@dataclass(frozen=True, eq=False)
class PickAndPlace(Values):
    """From `start` up, across and down, and back, in `duration` [s]; then again.

    Attributes:
        start: where it picks, shape (3,), [m].
        up: the lift, shape (3,), [m].
        across: from where it picks to where it places, shape (3,), [m].
        duration: of a cycle [s].
    """

    start: Array
    up: Array
    across: Array
    duration: float

    __repr__ = line(start="m", up="m", across="m", duration="s")

    def __post_init__(self) -> None:
        for name in ("start", "up", "across"):
            object.__setattr__(self, name, readonly(as_vector(name, getattr(self, name), 3, "m")))
        positive("duration", self.duration, "s")

    @property
    def name(self) -> str:
        """With its size, and how often it goes."""
        up, across = (1e3 * float(np.linalg.norm(one)) for one in (self.up, self.across))
        return f"pick and place {up:.3g}-{across:.3g}-{up:.3g} mm, {self.cycles_per_minute:.4g} cycles a minute"

    @property
    def cycles_per_minute(self) -> float:
        """How often it picks and places [1/min]."""
        return 60.0 / self.duration

    @classmethod
    @door
    def from_home(cls, mechanism: Mechanism, seconds: float, width: float = 0.0) -> PickAndPlace:
        """Picks where the tool is at home, and places beside it, with a lift of 25/305 of the width [m].

        Without a width it is 305 mm, and where the robot does not reach that, four fifths of the most that it reaches.

        Raises:
            InputError: an argument is not > 0, or the tool can only move along a line.
            UnreachableError: there is no width that the robot reaches.
        """
        home = ToolAtHome.of(mechanism)
        up, across = home.upright("pick and place")

        def sized(width: float) -> PickAndPlace:
            return cls(home.pose.position, UP / ACROSS * abs(width) * up, width * across, seconds)

        if width:
            return sized(positive("width", width, "m"))
        here, there = (_most(mechanism, sized, sign * ACROSS) for sign in (1.0, -1.0))
        most = here if abs(here) >= abs(there) else there
        if most == 0.0:
            raise InputError(f"{mechanism.name} reaches nothing beside home; it cannot pick and place from there")
        return sized(most if abs(most) == ACROSS else MARGIN * most)

    def at(self, t: float) -> ToolMotion:
        """The desired motion at time `t` [s]."""
        half = 0.5 * self.duration
        since = t % self.duration
        back = since >= half
        since -= half if back else 0.0
        rise = np.array(minimum_jerk(since, LIFT * half)) - minimum_jerk(since - (1.0 - LIFT) * half, LIFT * half)
        over = np.array(minimum_jerk(since - EARLY * half, (1.0 - 2.0 * EARLY) * half))
        if back:
            over = (1.0, 0.0, 0.0) - over
        place, velocity, acceleration = np.outer(rise, self.up) + np.outer(over, self.across)
        return ToolMotion(self.start + place, velocity, acceleration)


def _most(mechanism: Mechanism, sized: Callable[[float], PickAndPlace], width: float) -> float:
    """As much of a width as a mechanism can go, to a few percent; 0 where that is nothing."""

    def fits(part: float) -> bool:
        cycle, near, task = sized(part * width), mechanism.home, mechanism.task
        try:
            for t in np.linspace(0.0, 0.5 * cycle.duration, LOOKS + 1)[1:].tolist():
                near = mechanism.reach(Pose(cycle.at(t).position, task.home.rotation), near, free=True)
        except (UnreachableError, ClosureError, SingularError):
            return False
        return True

    if fits(1.0):
        return width
    low = next((0.5**k for k in range(1, HALVINGS) if fits(0.5**k)), 0.0)
    high = 2.0 * low
    for _ in range(REFINED if low else 0):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low * width
