"""Motions of the actuators themselves: sines and chirps, all actuators at once, each in its own coordinate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, Values, as_vector, positive, readonly
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.mechanism import Mechanism
from cutjoint.motion.timing import minimum_jerk
from cutjoint.motion.values import JointMotion
from cutjoint.reprs import line

OPENING = 0.1
"""Part of a chirp in which it swells up from rest, and in which it dies away at the end."""


@door
@dataclass(frozen=True, eq=False)
class JointSine(Values):
    """centre + amplitude sin(rate t + phase), each of shape (n,): [m] or [rad], [rad/s], [rad].

    It starts at full speed.  `duration` [s] is one period of the whole; rates need not be commensurable.
    """

    centre: Array
    amplitude: Array
    rate: Array
    phase: Array
    duration: float
    name: str = "joint sine"

    __repr__ = line(centre="m or rad", amplitude="m or rad", rate="rad/s", phase="rad", duration="s")

    def __post_init__(self) -> None:
        size = np.size(self.centre)
        for name, unit in (("centre", ""), ("amplitude", ""), ("rate", "rad/s"), ("phase", "rad")):
            object.__setattr__(self, name, readonly(as_vector(name, getattr(self, name), size, unit)))
        positive("duration", self.duration, "s")

    @classmethod
    @door
    def from_home(cls, mechanism: Mechanism, amplitude: float, hertz: float) -> JointSine:
        """All actuators about home in step, by one amplitude [m] or [rad], so many times a second."""
        rate = 2.0 * np.pi * positive("hertz", hertz, "Hz")
        every = np.ones(mechanism.n)
        return cls(mechanism.home.q, amplitude * every, rate * every, 0.0 * every, 1.0 / hertz)

    def at(self, t: float) -> JointMotion:
        """The desired motion at time `t` [s]."""
        angle = self.rate * t + self.phase
        swing = self.amplitude * np.sin(angle)
        return JointMotion(
            self.centre + swing, self.amplitude * self.rate * np.cos(angle), -self.rate * self.rate * swing
        )


@door
@dataclass(frozen=True, eq=False)
class JointChirp(Values):
    """centre + w(t) amplitude sin(phi(t)): a sine whose frequency rises evenly from one to the other.

    The window w opens in the first tenth and closes in the last with the least jerk: it starts and ends at rest at the
    centre, and is C2.

    Attributes:
        centre, amplitude: shape (n,), [m] or [rad].
        hertz: frequencies at the start and at the end, >= 0, shape (2,), [Hz].
        duration: [s].
    """

    centre: Array
    amplitude: Array
    hertz: Array
    duration: float
    name: str = "joint chirp"

    __repr__ = line(centre="m or rad", amplitude="m or rad", hertz="Hz", duration="s")

    def __post_init__(self) -> None:
        size = np.size(self.centre)
        for name, count, unit in (("centre", size, ""), ("amplitude", size, ""), ("hertz", 2, "Hz")):
            object.__setattr__(self, name, readonly(as_vector(name, getattr(self, name), count, unit)))
        if self.hertz.min() < 0.0:
            raise InputError(f"hertz must be >= 0, found {self.hertz.tolist()}")
        positive("duration", self.duration, "s")

    @classmethod
    @door
    def from_home(cls, mechanism: Mechanism, amplitude: float, low: float, high: float, seconds: float) -> JointChirp:
        """All actuators about home in step, by one amplitude [m] or [rad], from one frequency to the other [Hz]."""
        return cls(mechanism.home.q, np.full(mechanism.n, amplitude), np.array([low, high]), seconds)

    def at(self, t: float) -> JointMotion:
        """The desired motion at time `t` [s]."""
        opening = OPENING * self.duration
        near, side = (t, 1.0) if t < 0.5 * self.duration else (self.duration - t, -1.0)
        w, w_rate, w_change = minimum_jerk(near, opening)
        w_rate *= side
        low, high = self.hertz
        bend = 2.0 * np.pi * (high - low) / self.duration
        angle, speed = 2.0 * np.pi * low * t + 0.5 * bend * t * t, 2.0 * np.pi * low + bend * t
        sine, cosine = np.sin(angle), np.cos(angle)
        return JointMotion(
            self.centre + w * sine * self.amplitude,
            (w_rate * sine + w * speed * cosine) * self.amplitude,
            (w_change * sine + 2.0 * w_rate * speed * cosine + w * (bend * cosine - speed * speed * sine))
            * self.amplitude,
        )
