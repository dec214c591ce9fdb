"""PID on actuator position: kp e + kd e_dot + ki times the integral of e, with anti-windup by clamping.

While an actuator saturates its integral stands still, unless the error would drive it out of saturation: there is no
further gain to choose.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.control.law import Gain, GainHelp
from cutjoint.control.pd import PD, Kd, Kp
from cutjoint.doors import door
from cutjoint.motion import Desired


@door
class PID(PD):
    """Proportional, integral and derivative feedback; needs no model.  Its memory is the integral of e, shape (n,)."""

    name = "PID"

    def __init__(
        self,
        kp: Kp,
        ki: Annotated[npt.ArrayLike, GainHelp("effort per integral of the error", "N/(m s) or N m/(rad s)")],
        kd: Kd,
    ) -> None:
        """Gains as in `PD`."""
        super().__init__(kp, kd)
        self.ki = Gain("ki", ki)

    def memory(self, n: int) -> int:
        """One integral an actuator."""
        super().memory(n)
        return n

    def effort(self, desired: Desired, q: Array, v: Array, memory: Array) -> Array:
        """Feedback with the integral in `memory`, shape (n,)."""
        return self.feedback(desired, q, v) + self.ki(memory)

    def memory_rate(self, desired: Desired, q: Array, v: Array, asked: Array, given: Array) -> Array:
        """The error, or 0 where the actuator saturates and the error pushes further."""
        error = desired.q - q
        pushes = (asked - given) * self.ki(error) > 0.0
        return np.where(pushes, 0.0, error)
