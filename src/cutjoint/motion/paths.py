"""The paths of the tool point that there are: hold, point to point, circle and Lissajous curve.

Point to point is the minimum-jerk quintic (T. Flash, N. Hogan: The coordination of arm movements. J. Neurosci. 5 (1985)
1688-1703), the circle that of the Cartesian Parallel Manipulator (Elkady et al. 2008, section 5.3), the Lissajous curve
that of the Omega-3 (equation 43).  The last two start at full speed: a robot at rest meets a step of the desired
velocity.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cutjoint.arrays import Array, Values, as_vector, positive, readonly
from cutjoint.errors import InputError
from cutjoint.mechanism import Mechanism
from cutjoint.motion.values import ToolMotion


@dataclass(frozen=True, eq=False)
class Hold(Values):
    """The tool stays at `position`, shape (3,) [m]."""

    position: Array
    duration: float = 1.0
    name: str = "hold"

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", readonly(as_vector("position", self.position, 3, "m")))
        positive("duration", self.duration, "s")

    @classmethod
    def at_home(cls, mechanism: Mechanism, seconds: float) -> Hold:
        """Where the tool is at home."""
        return cls(mechanism.tool(mechanism.home).position, seconds)

    def at(self, t: float) -> ToolMotion:
        """The same point at every time `t` [s]."""
        return ToolMotion(self.position, np.zeros(3), np.zeros(3))


@dataclass(frozen=True, eq=False)
class PointToPoint(Values):
    """A straight line from `start` to `goal`, shape (3,) [m], in `duration` [s], at rest at both ends.

    The fraction of the way is the quintic 10 s^3 - 15 s^4 + 6 s^5 of s = t / duration, which has the least mean squared
    jerk between two points at rest: position, velocity and acceleration are continuous.  Before 0 it rests at `start`,
    after `duration` at `goal`.
    """

    start: Array
    goal: Array
    duration: float = 1.0
    name: str = "point to point"

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", readonly(as_vector("start", self.start, 3, "m")))
        object.__setattr__(self, "goal", readonly(as_vector("goal", self.goal, 3, "m")))
        positive("duration", self.duration, "s")

    @classmethod
    def from_home(cls, mechanism: Mechanism, x: float, y: float, z: float, seconds: float) -> PointToPoint:
        """From where the tool is at home to the point that is (x, y, z) [m] away from there."""
        home = mechanism.tool(mechanism.home).position
        return cls(home, home + np.array([x, y, z]), seconds)

    def at(self, t: float) -> ToolMotion:
        """The desired motion at time `t` [s]."""
        s = min(max(t / self.duration, 0.0), 1.0)
        way = self.goal - self.start
        return ToolMotion(
            self.start + s**3 * (10.0 - 15.0 * s + 6.0 * s * s) * way,
            30.0 * s * s * (1.0 - s) ** 2 / self.duration * way,
            60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / self.duration**2 * way,
        )


@dataclass(frozen=True, eq=False)
class Circle(Values):
    """centre + radius (cos(rate t) first + sin(rate t) second), at constant speed.

    Attributes:
        centre: shape (3,), [m].
        radius: [m], > 0.
        rate: [rad/s], not 0; negative turns the other way.
        first, second: orthogonal unit vectors that span its plane, shape (3,).
    """

    centre: Array
    radius: float
    rate: float
    first: Array = field(default_factory=lambda: readonly([1.0, 0.0, 0.0]))
    second: Array = field(default_factory=lambda: readonly([0.0, 1.0, 0.0]))
    name: str = "circle"

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", readonly(as_vector("centre", self.centre, 3, "m")))
        positive("radius", self.radius, "m")
        positive("|rate|", abs(self.rate), "rad/s")
        for name in ("first", "second"):
            object.__setattr__(self, name, readonly(as_vector(name, getattr(self, name), 3)))
        axes = np.array([self.first, self.second])
        if not np.allclose(axes @ axes.T, np.eye(2), rtol=0.0, atol=1e-12):
            raise InputError(f"first and second must be orthogonal unit vectors, found {axes.tolist()}")

    @classmethod
    def through_home(cls, mechanism: Mechanism, radius: float, seconds: float) -> Circle:
        """From where the tool is at home, in the plane in which it moves most easily, a turn in `seconds` [s].

        Raises:
            InputError: the tool can only move along a line, or an argument is not > 0.
        """
        positive("radius", radius, "m")
        positive("seconds", seconds, "s")
        tool = mechanism.tool(mechanism.home)
        directions, sizes, _ = np.linalg.svd(tool.jacobian)
        if mechanism.n < 2 or sizes[1] < 1e-9 * sizes[0]:
            raise InputError(f"the tool of {mechanism.name} moves along a line; it cannot follow a circle")
        first, second = (axis * np.sign(axis[np.argmax(np.abs(axis))]) for axis in directions.T[:2])
        return cls(tool.position - radius * first, radius, 2.0 * np.pi / seconds, first, second)

    @property
    def duration(self) -> float:
        """One turn [s]."""
        return float(2.0 * np.pi / abs(self.rate))

    def at(self, t: float) -> ToolMotion:
        """The desired motion at time `t` [s]."""
        cosine, sine = np.cos(self.rate * t), np.sin(self.rate * t)
        out = self.radius * (cosine * self.first + sine * self.second)
        along = self.radius * self.rate * (cosine * self.second - sine * self.first)
        return ToolMotion(self.centre + out, along, -(self.rate**2) * out)


@dataclass(frozen=True, eq=False)
class Lissajous(Values):
    """centre + amplitude cos(rate t + phase), each of shape (3,): [m], [m], [rad/s], [rad].

    `duration` [s] is one period of the whole curve; the caller states it, because rates need not be commensurable.
    """

    centre: Array
    amplitude: Array
    rate: Array
    phase: Array
    duration: float
    name: str = "lissajous"

    def __post_init__(self) -> None:
        for name, unit in (("centre", "m"), ("amplitude", "m"), ("rate", "rad/s"), ("phase", "rad")):
            object.__setattr__(self, name, readonly(as_vector(name, getattr(self, name), 3, unit)))
        positive("duration", self.duration, "s")

    def at(self, t: float) -> ToolMotion:
        """The desired motion at time `t` [s]."""
        angle = self.rate * t + self.phase
        swing = self.amplitude * np.cos(angle)
        return ToolMotion(
            self.centre + swing, -self.rate * self.amplitude * np.sin(angle), -self.rate * self.rate * swing
        )
