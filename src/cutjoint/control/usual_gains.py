"""Gains for a robot of which none are known: those of the error of computed torque, with the inertia at home.

With the inertia M_ii that actuator i feels at home, and w = 20 rad/s, which is kp = 400 and kd = 40 of computed torque,

    kp_i = w^2 M_ii,  kd_i = 2 w M_ii,  ki_i = w^3 M_ii / 8

so that each actuator by itself is critically damped (with the integral still well damped: it is stable below 2 w^3).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cutjoint.arrays import Array
from cutjoint.mechanism import Mechanism

SPEED = 20.0
"""w [rad/s]."""


def usual_gains(model: Mechanism) -> Mapping[str, Array]:
    """kp, ki and kd of PD and PID for every actuator of a robot, shape (n,) each, in the units of these laws.

    Raises:
        ActuationError: the actuators do not determine its motion, so there is no such inertia.
        SingularError: home is singular.
    """
    inertia = np.maximum(np.diag(model.terms(model.home).mass), 0.0)
    return {"kp": SPEED**2 * inertia, "kd": 2.0 * SPEED * inertia, "ki": SPEED**3 / 8.0 * inertia}
