"""Actuators led along a way of their own, by a robot whose actuators do not determine its motion.

Where something falls or swings freely nothing tells the whole desired motion, and with more actuators than freedoms
their efforts are not told by it.  What can be said is how the actuators should go, and what they feel like at home: the
acceleration of their coordinates under efforts is G effort + a_0 there, so that

    effort = holding(s) + G^+ (a_d + kd e_dot + kp e)

moves them about home as computed torque would.  For actuators that depend on each other the pseudo-inverse G^+ gives
the least efforts.  For robots with fewer actuators than freedoms that is collocated partial feedback linearisation
(M. W. Spong: Partial feedback linearization of underactuated mechanical systems.  IROS 1994), with the inertia of home.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial

from cutjoint.arrays import Array, Values, readonly
from cutjoint.control.pd import NOTHING
from cutjoint.motion import Desired
from cutjoint.motion.timing import there_and_back


@dataclass(frozen=True, eq=False)
class LedActuators(Values):
    """Follows no reference: the way is its own.

    Attributes:
        way: actuated coordinates as polynomials of the part s of the way, lowest power first, shape (k, n), [m], [rad].
        holding: efforts that hold the robot there, shape (k, n), [N] or [N m].
        inertia: G^+ at home, shape (n, n).
        kp, kd: of the error's equation, [1/s2] and [1/s].
        seconds: for the way out and back [s]; after that the actuators rest at home.
    """

    way: Array
    holding: Array
    inertia: Array
    kp: float
    kd: float
    seconds: float

    name = "actuators led about home"

    def __post_init__(self) -> None:
        for name in ("way", "holding", "inertia"):
            object.__setattr__(self, name, readonly(getattr(self, name)))

    @property
    def gains(self) -> dict[str, list[list[float]]]:
        """The gains by name."""
        return {"kp": [[self.kp]], "kd": [[self.kd]]}

    def memory(self, n: int) -> int:
        """No memory."""
        return 0

    def at(self, t: float) -> tuple[Array, Array, Array]:
        """Where the actuators should be at `t` [s], with velocity and acceleration, shape (n,) each."""
        s, rate, change = there_and_back(t, self.seconds)
        slope = polynomial.polyder(self.way)
        first, bend = (np.asarray(polynomial.polyval(s, one)) for one in (slope, polynomial.polyder(slope)))
        place, speed = np.asarray(polynomial.polyval(s, self.way)), np.asarray(rate * first)
        return place, speed, np.asarray(change * first + rate * rate * bend)

    def effort(self, desired: Desired, q: Array, v: Array, memory: Array) -> Array:
        """As the module's head says, shape (n,)."""
        place, speed, acceleration = self.at(desired.t)
        s, _, _ = there_and_back(desired.t, self.seconds)
        wanted = acceleration + self.kd * (speed - v) + self.kp * (place - q)
        return np.asarray(polynomial.polyval(s, self.holding) + self.inertia @ wanted)

    def memory_rate(self, desired: Desired, q: Array, v: Array, asked: Array, given: Array) -> Array:
        """Nothing to remember."""
        return NOTHING
