"""Simple paths of the tool point: hold, lines, circle and Lissajous curve.

The laws of time of the lines are those of `timing`; the circle is that of the Cartesian Parallel Manipulator (Elkady et
al. 2008, section 5.3), the Lissajous curve that of the Omega-3 (equation 43).  The last two start at full speed: a
robot at rest meets a step of the desired velocity.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import numpy as np

from cutjoint.arrays import Array, Values, as_vector, positive, readonly
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.mechanism import Mechanism
from cutjoint.motion.home import ToolAtHome, orthonormal
from cutjoint.motion.timing import Progress, minimum_jerk, trapezoid
from cutjoint.motion.values import ToolMotion
from cutjoint.reprs import line


@door
@dataclass(frozen=True, eq=False)
class Hold(Values):
    """The tool stays at `position`, shape (3,) [m]."""

    position: Array
    duration: float = 1.0
    name: str = "hold"

    __repr__ = line(position="m", duration="s")

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", readonly(as_vector("position", self.position, 3, "m")))
        positive("duration", self.duration, "s")

    @classmethod
    @door
    def at_home(cls, mechanism: Mechanism, seconds: float) -> Hold:
        """Where the tool is at home."""
        return cls(mechanism.tool(mechanism.home).position, seconds)

    def at(self, t: float) -> ToolMotion:
        """The same point at every time `t` [s]."""
        return ToolMotion(self.position, np.zeros(3), np.zeros(3))


@door
@dataclass(frozen=True, eq=False)
class PointToPoint(Values):
    """A straight line from `start` to `goal`, shape (3,) [m], in `duration` [s], at rest at both ends.

    The way has the least mean squared jerk between two points at rest: position, velocity and acceleration are
    continuous (C2).  Before 0 it rests at `start`, after `duration` at `goal`.
    """

    start: Array
    goal: Array
    duration: float = 1.0
    name: str = "point to point"

    __repr__ = line(start="m", goal="m", duration="s")

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", readonly(as_vector("start", self.start, 3, "m")))
        object.__setattr__(self, "goal", readonly(as_vector("goal", self.goal, 3, "m")))
        positive("duration", self.duration, "s")

    @classmethod
    @door
    def from_home(cls, mechanism: Mechanism, x: float, y: float, z: float, seconds: float) -> Self:
        """From where the tool is at home to the point that is (x, y, z) [m] away from there, along the axes of the
        task."""
        home = ToolAtHome.of(mechanism)
        return cls(home.pose.position, home.by(x, y, z), seconds)

    def progress(self, t: float) -> Progress:
        """How far along its way it is at time `t` [s]."""
        return minimum_jerk(t, self.duration)

    def at(self, t: float) -> ToolMotion:
        """The desired motion at time `t` [s]."""
        s, rate, change = self.progress(t)
        way = self.goal - self.start
        return ToolMotion(self.start + s * way, rate * way, change * way)


@door
@dataclass(frozen=True, eq=False)
class Trapezoidal(PointToPoint):
    """The same line with a trapezoidal velocity: it speeds up for a `ramp` of the duration, and slows down for as long.

    Only C1: the acceleration jumps at both ends of both ramps.  A ramp of 1/3 is usual; with 1/2 no part has constant
    speed.
    """

    name: str = "trapezoidal"
    ramp: float = 1.0 / 3.0

    __repr__ = line(start="m", goal="m", duration="s")

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < positive("ramp", self.ramp, "of the duration") <= 0.5:
            raise InputError(f"ramp must be at most half of the duration, found {self.ramp!r}")

    def progress(self, t: float) -> Progress:
        """How far along its way it is at time `t` [s]."""
        return trapezoid(t, self.duration, self.ramp * self.duration)


@door
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

    __repr__ = line(centre="m", radius="m", rate="rad/s")

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", readonly(as_vector("centre", self.centre, 3, "m")))
        positive("radius", self.radius, "m")
        positive("|rate|", abs(self.rate), "rad/s")
        for name in ("first", "second"):
            object.__setattr__(self, name, readonly(as_vector(name, getattr(self, name), 3)))
        orthonormal("first and second", np.column_stack([self.first, self.second]), 2)

    @classmethod
    @door
    def through_home(cls, mechanism: Mechanism, radius: float, seconds: float) -> Circle:
        """From where the tool is at home, in the plane in which it moves most easily, a turn in `seconds` [s].

        Raises:
            InputError: the tool can only move along a line, or an argument is not > 0.
        """
        positive("radius", radius, "m")
        positive("seconds", seconds, "s")
        home = ToolAtHome.of(mechanism)
        first, second = home.plane("a circle")
        return cls(home.pose.position - radius * first, radius, 2.0 * np.pi / seconds, first, second)

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


@door
@dataclass(frozen=True, eq=False)
class Lissajous(Values):
    """centre + axes @ (amplitude cos(rate t + phase)), each of shape (3,): [m], [m], [rad/s], [rad].

    `duration` [s] is one period of the whole curve; the caller states it, because rates need not be commensurable.
    `axes` are orthonormal columns, shape (3, 3); those of the world if nothing is said.
    """

    centre: Array
    amplitude: Array
    rate: Array
    phase: Array
    duration: float
    name: str = "lissajous"
    axes: Array = field(default_factory=lambda: readonly(np.eye(3)))

    __repr__ = line(centre="m", amplitude="m", rate="rad/s", phase="rad", duration="s")

    def __post_init__(self) -> None:
        for name, unit in (("centre", "m"), ("amplitude", "m"), ("rate", "rad/s"), ("phase", "rad")):
            object.__setattr__(self, name, readonly(as_vector(name, getattr(self, name), 3, unit)))
        object.__setattr__(self, "axes", readonly(orthonormal("axes", self.axes, 3)))
        positive("duration", self.duration, "s")

    @classmethod
    @door
    def through_home(cls, mechanism: Mechanism, width: float, height: float, seconds: float) -> Lissajous:
        """A figure of eight through where the tool is at home, `width` across and `height` up [m], in `seconds` [s].

        Raises:
            InputError: the tool can only move along a line, or an argument is not > 0.
        """
        home = ToolAtHome.of(mechanism)
        up, across = home.upright("a Lissajous curve")
        size = np.array([0.5 * positive("width", width, "m"), 0.5 * positive("height", height, "m"), 0.0])
        rate = 2.0 * np.pi / positive("seconds", seconds, "s") * np.array([1.0, 2.0, 0.0])
        axes = np.column_stack([across, up, np.cross(across, up)])
        return cls(home.pose.position, size, rate, np.full(3, -0.5 * np.pi), seconds, axes=axes)

    def at(self, t: float) -> ToolMotion:
        """The desired motion at time `t` [s]."""
        angle = self.rate * t + self.phase
        swing = self.amplitude * np.cos(angle)
        speed = -self.rate * self.amplitude * np.sin(angle)
        axes = self.axes
        return ToolMotion(self.centre + axes @ swing, axes @ speed, axes @ (-self.rate * self.rate * swing))
