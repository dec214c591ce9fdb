"""Way-points joined by straight legs with blends, of the tool point or of the actuators: see `timing.Corners`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, Values, positive
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.mechanism import Mechanism
from cutjoint.motion.home import ToolAtHome
from cutjoint.motion.timing import Corners, points_of
from cutjoint.motion.values import JointMotion, ToolMotion
from cutjoint.reprs import line


@door
@dataclass(frozen=True, eq=False)
class Waypoints(Values):
    """The tool point along straight legs with blends, from rest to rest.

    Attributes:
        corners: points of shape (k, 3), [m].
    """

    corners: Corners
    name: str = "way-points"

    __repr__ = line("corners", "duration", "name", duration="s")

    def __post_init__(self) -> None:
        points_of("points", self.corners.points, 3)

    @classmethod
    @door
    def from_home(cls, mechanism: Mechanism, seconds: float, *numbers: float) -> Waypoints:
        """From where the tool is at home over points that are x, y, z [m] away from there, along the axes of the task,
        in `seconds` [s] with quintic blends (C2)."""
        home = ToolAtHome.of(mechanism)
        away = _groups(numbers, 3, "x, y, z")
        return cls(evenly(np.array([home.by(*point) for point in away]), seconds))

    @property
    def duration(self) -> float:
        """From rest to rest [s]."""
        return self.corners.duration

    def at(self, t: float) -> ToolMotion:
        """The desired motion at time `t` [s]."""
        return ToolMotion(*self.corners.at(t))


@door
@dataclass(frozen=True, eq=False)
class JointWaypoints(Values):
    """The actuators along straight legs in their coordinates with blends, from rest to rest.

    Attributes:
        corners: points of shape (k, n), [m] or [rad].
    """

    corners: Corners
    name: str = "joint way-points"

    __repr__ = line("corners", "duration", "name", duration="s")

    @classmethod
    @door
    def from_home(cls, mechanism: Mechanism, seconds: float, *numbers: float) -> JointWaypoints:
        """From home over points of the actuators that are so far away from there, n numbers [m] or [rad] each, in
        `seconds` [s] with quintic blends (C2)."""
        names = ", ".join(one.name for one in mechanism.actuators)
        return cls(evenly(mechanism.home.q + _groups(numbers, mechanism.n, names), seconds))

    @property
    def duration(self) -> float:
        """From rest to rest [s]."""
        return self.corners.duration

    def at(self, t: float) -> JointMotion:
        """The desired motion at time `t` [s]."""
        return JointMotion(*self.corners.at(t))


def evenly(points: Array, seconds: float) -> Corners:
    """Legs in `seconds` [s] from rest to rest, at one speed, with quintic blends of half the shortest leg's time.

    Raises:
        InputError: two neighbours are the same point, or `seconds` is not > 0.
    """
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if lengths.min() <= 0.0:
        number = int(np.argmin(lengths)) + 1
        raise InputError(
            f"way-points {number} and {number + 1} are the same ({points[number].tolist()}); leave one out"
        )
    # The legs take lengths * rate [s], the two blends beyond the ends together half of the shortest leg's time.
    blend = 0.25 * float(lengths.min())
    rate = positive("seconds", seconds, "s") / float(lengths.sum() + 2.0 * blend)
    return Corners(points, lengths * rate, blend * rate)


def _groups(numbers: tuple[float, ...], size: int, what: str) -> Array:
    """The numbers as points, after home itself, shape (1 + count, size)."""
    if not numbers or len(numbers) % size:
        raise InputError(f"way-points are {size} numbers each ({what}); {len(numbers)} numbers are no such points")
    return np.concatenate([np.zeros((1, size)), np.reshape(numbers, (-1, size))])
