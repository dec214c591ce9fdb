"""PD on actuator position and velocity: effort = kp e + kd e_dot, with e = q_d - q.

Elkady et al. 2008, equation 40.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.control.law import Gain, GainHelp, gains_in, law_in_words
from cutjoint.doors import door
from cutjoint.motion import Desired

Kp = Annotated[npt.ArrayLike, GainHelp("effort per error of position", "N/m or N m/rad")]
Kd = Annotated[npt.ArrayLike, GainHelp("effort per error of velocity", "N s/m or N m s/rad")]
NOTHING: Array = np.zeros(0)
NOTHING.setflags(write=False)


@door
class PD:
    """Proportional and derivative feedback; needs no model of the robot."""

    name = "PD"

    def __init__(self, kp: Kp, kd: Kd) -> None:
        """Gains: scalar, (n,) or (n, n).

        Raises:
            InputError: gains of another shape, not finite or negative.
        """
        self.kp, self.kd = Gain("kp", kp), Gain("kd", kd)

    def __repr__(self) -> str:
        return law_in_words(self)

    @property
    def gains(self) -> dict[str, list[list[float]]]:
        """The gains by name."""
        return {name: gain.listed for name, gain in gains_in(self).items()}

    def memory(self, n: int) -> int:
        """No memory; the gains must fit n actuators."""
        for gain in gains_in(self).values():
            gain.fit(n)
        return 0

    def feedback(self, desired: Desired, q: Array, v: Array) -> Array:
        """kp e + kd e_dot, shape (n,)."""
        return self.kp(desired.q - q) + self.kd(desired.v - v)

    def effort(self, desired: Desired, q: Array, v: Array, memory: Array) -> Array:
        """The feedback alone."""
        return self.feedback(desired, q, v)

    def memory_rate(self, desired: Desired, q: Array, v: Array, asked: Array, given: Array) -> Array:
        """Nothing to remember."""
        return NOTHING
