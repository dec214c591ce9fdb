"""Computed torque: M(q) (a_d + kd e_dot + kp e) + c(q, v) + g(q) (Elkady et al. 2008, equation 43).

With an exact model every actuator's error obeys e_ddot + kd e_dot + kp e = 0; it is critically damped at
kd = 2 sqrt(kp).
"""

from __future__ import annotations

from typing import Annotated

import numpy.typing as npt

from cutjoint.arrays import Array, positive
from cutjoint.control.law import GainHelp
from cutjoint.control.pd import PD
from cutjoint.doors import door
from cutjoint.mechanism import Mechanism
from cutjoint.motion import Desired


@door
class ComputedTorque(PD):
    """Feedback linearisation by `model`, which need not be the plant's."""

    name = "computed torque"

    def __init__(
        self,
        model: Mechanism,
        kp: Annotated[npt.ArrayLike, GainHelp("stiffness of the error's equation", "1/s2")],
        kd: Annotated[npt.ArrayLike, GainHelp("damping of the error's equation", "1/s")],
    ) -> None:
        """Gains of the linear error equation: scalar, (n,) or (n, n)."""
        super().__init__(kp, kd)
        self.model = model

    @classmethod
    @door
    def critically_damped(cls, model: Mechanism, kd: float) -> ComputedTorque:
        """kp = kd^2 / 4 (equation 46): the fastest error without overshoot.

        Raises:
            InputError: `kd` [1/s] is not a finite number > 0.
        """
        positive("kd", kd, "1/s")
        return cls(model, kd * kd / 4.0, kd)

    def effort(self, desired: Desired, q: Array, v: Array, memory: Array) -> Array:
        """Inverse dynamics at the measured state, shape (n,)."""
        near = desired.posture if self.model is desired.mechanism else None
        at = self.model.close(q, near, limits="ignore")  # where it is, it is
        return self.model.inverse_dynamics(at, v, desired.a + self.feedback(desired, q, v))
