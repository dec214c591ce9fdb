"""PD with the gravity of the desired posture fed forward: effort = kp e + kd e_dot + g(q_d), g with that of springs.

Elkady et al. 2008, equation 41.
"""

from __future__ import annotations

from cutjoint.arrays import Array
from cutjoint.control.pd import PD, Kd, Kp
from cutjoint.doors import door
from cutjoint.mechanism import Mechanism
from cutjoint.motion import Desired


@door
class PDGravity(PD):
    """PD and gravity compensation by `model`, which need not be the plant's."""

    name = "PD + gravity"

    def __init__(self, model: Mechanism, kp: Kp, kd: Kd) -> None:
        """Gains as in `PD`."""
        super().__init__(kp, kd)
        self.model = model

    def effort(self, desired: Desired, q: Array, v: Array, memory: Array) -> Array:
        """Feedback, and what holds weights and springs, shape (n,)."""
        return self.feedback(desired, q, v) + self.model.terms(desired.posture_of(self.model)).holding
