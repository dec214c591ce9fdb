"""The values that sizing hands out: extremes, the duty of an actuator, one trajectory after the other.

A duty is what an actuator must do along a trajectory; of efforts and speeds the largest size counts, told with its
sign.  All arrays are read-only.  [N], [m/s] of an actuator that slides, [N m], [rad/s] of one that turns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.mechanism import Actuator
from cutjoint.reprs import line


@dataclass(frozen=True)
class Extreme:
    """The largest value of a quantity: itself, in the unit of the quantity, when [s], and along which trajectory."""

    value: float
    time: float
    trajectory: str = ""

    __repr__ = line("value", "time", "trajectory", time="s")


@dataclass(frozen=True)
class Duty:
    """What one actuator must do.

    Attributes:
        actuator: which one.
        effort: the largest, with its sign, [N] or [N m].
        rms_effort: root of the mean square over the time of the trajectory.
        speed: the largest, with its sign, [m/s] or [rad/s].
        rms_speed: root of the mean square.
        power: the largest that the actuator gives [W].
        returned: the largest that comes back into it [W], at least 0.
        given: energy that it gives along the trajectory [J], what comes back not counted.
        back: energy that comes back into it [J], at least 0.
        holding: the largest effort that holds the robot at rest on the way, with its sign: gravity, springs and loads.
    """

    actuator: Actuator
    effort: Extreme
    rms_effort: float
    speed: Extreme
    rms_speed: float
    power: Extreme
    returned: Extreme
    given: float
    back: float
    holding: Extreme

    __repr__ = line(
        "actuator", "rms_effort", "rms_speed", "given", "back", rms_effort="N or N m", rms_speed="m/s or rad/s",
        given="J", back="J",
    )  # fmt: skip

    @property
    def work(self) -> float:
        """Energy that the actuator gives in all, what comes back counted [J]."""
        return self.given - self.back

    def or_worse(self, other: Duty) -> Duty:
        """Of every quantity the worse one of two."""
        larger = {
            name: max(getattr(self, name), getattr(other, name), key=lambda one: abs(one.value))
            for name in ("effort", "speed", "power", "returned", "holding")
        }
        numbers = {name: max(getattr(self, name), getattr(other, name)) for name in _NUMBERS}
        return replace(self, **larger, **numbers)


_NUMBERS = ("rms_effort", "rms_speed", "given", "back")


@dataclass(frozen=True, eq=False)
class Course(Frozen):
    """Actuators at m instants, shape (m, n) each but for the time.

    Attributes:
        t: time, shape (m,) [s].
        q: coordinates [m] or [rad].
        v: velocity [m/s] or [rad/s].
        a: acceleration [m/s2] or [rad/s2].
        effort: that gives the acceleration against friction, weights, springs and loads, [N] or [N m].
        bare: the same without what accelerates the actuators' own rotors.
        holding: that holds the posture at rest: weights, springs and loads.
        lost: power that friction and dampers take, shape (m,) [W].
        received: power that the loads give, shape (m,) [W].
        mass: diagonal of the mass matrix without the actuators' own rotors, [kg] or [kg m2].
    """

    t: Array
    q: Array
    v: Array
    a: Array
    effort: Array
    bare: Array
    holding: Array
    lost: Array
    received: Array
    mass: Array

    __repr__ = line("t", "v", "effort", t="s", v="m/s or rad/s", effort="N or N m")

    @property
    def power(self) -> Array:
        """Mechanical power of the actuators, shape (m, n) [W]."""
        return self.effort * self.v

    @property
    def parts(self) -> tuple[Array, ...]:
        """All of its arrays, in their order."""
        return tuple(getattr(self, name) for name in self._arrays)

    def piece(self, start: int, stop: int) -> Course:
        """The instants from one on, up to another."""
        return Course(*(one[start:stop] for one in self.parts))

    @classmethod
    def joined(cls, several: Sequence[Course]) -> Course:
        """One after the other."""
        return cls(*(np.concatenate(parts) for parts in zip(*(one.parts for one in several), strict=True)))


@dataclass(frozen=True, eq=False)
class SizedCycle(Frozen):
    """One trajectory.

    Attributes:
        name: of the trajectory.
        duration: how long it was followed [s].
        duties: of the actuators, in their order.
        lost: energy that friction and dampers take [J].
        received: energy that the loads give [J].
        gained: kinetic and potential energy at the end less that at the start [J].
        balance: by how much the work of the actuators misses what the energies, losses and loads say, at worst over the
            way, beside the energy that moves: it tells how exact the figures are.
        error: estimate of the relative error of the integrals.
        course: the instants that were evaluated, dense enough to integrate and interpolate.
        highest_mass: largest inertia at each actuator on the way, without its rotor, shape (n,), [kg] or [kg m2].
    """

    name: str
    duration: float
    duties: tuple[Duty, ...]
    lost: float
    received: float
    gained: float
    balance: float
    error: float
    course: Course
    highest_mass: Array

    __repr__ = line("name", "duration", "duties", "lost", "balance", duration="s", lost="J")
