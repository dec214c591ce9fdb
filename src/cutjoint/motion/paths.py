"""The trajectories: hold, point to point, circle and Lissajous curve.

The circle is that of the Cartesian Parallel Manipulator (Elkady et al. 2008, section 5.3), the Lissajous curve that of
the Omega-3 (equation 43).  Both start at full speed: a robot at rest meets a step of the desired velocity.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cutjoint.arrays import Array, Values, as_vector, positive, readonly
from cutjoint.errors import InputError
from cutjoint.motion.trajectory import ToolMotion


@dataclass(frozen=True, eq=False)
class Hold(Values):
    """The tool stays at `position`, shape (3,) [m]."""

    position: Array
    duration: float = 1.0
    name: str = "hold"

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", readonly(as_vector("position", self.position, 3, "m")))
        positive("duration", self.duration, "s")

    def at(self, t: float) -> ToolMotion:
        """The same point at every time `t` [s]."""
        return ToolMotion(self.position, np.zeros(3), np.zeros(3))


@dataclass(frozen=True, eq=False)
class PointToPoint(Values):
    """A straight line from `start` to `goal`, shape (3,) [m], in `duration` [s], at rest at both ends.

    The fraction of the way is the quintic 10 s^3 - 15 s^4 + 6 s^5 of s = t / duration: position, velocity and
    acceleration are continuous.  Before 0 it rests at `start`, after `duration` at `goal`.
    """

    start: Array
    goal: Array
    duration: float = 1.0
    name: str = "point to point"

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", readonly(as_vector("start", self.start, 3, "m")))
        object.__setattr__(self, "goal", readonly(as_vector("goal", self.goal, 3, "m")))
        positive("duration", self.duration, "s")

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
