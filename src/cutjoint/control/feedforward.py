"""PD with the whole inverse dynamics of the desired motion fed forward (Elkady et al. 2008, equation 42).

effort = M(q_d) a_d + c(q_d, v_d) + g(q_d) + kp e + kd e_dot
"""

from __future__ import annotations

from cutjoint.arrays import Array
from cutjoint.control.pd import PD, Kd, Kp
from cutjoint.doors import door
from cutjoint.mechanism import Mechanism
from cutjoint.motion import Desired


@door
class Feedforward(PD):
    """PD and full feedforward by `model`, which need not be the plant's."""

    name = "PD + feedforward"

    def __init__(self, model: Mechanism, kp: Kp, kd: Kd) -> None:
        """Gains as in `PD`."""
        super().__init__(kp, kd)
        self.model = model

    def effort(self, desired: Desired, q: Array, v: Array, memory: Array) -> Array:
        """Feedback and inverse dynamics of the desired motion, shape (n,)."""
        ahead = self.model.inverse_dynamics(desired.posture_of(self.model), desired.v, desired.a)
        return self.feedback(desired, q, v) + ahead
