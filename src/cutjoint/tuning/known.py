"""Gains that are known: those of the robots whose papers run controllers.

The CPM's are printed (Elkady et al. 2008, table 3).  The Omega-3's paper prints none: these are this project's.  They
make the error critically damped at 20 rad/s for computed torque; for the others kp and kd are of the size of the
robot's largest inertia (1.4e-3 kg m2) times a bandwidth of some 25 rad/s, held well damped.
"""

from __future__ import annotations

from collections.abc import Mapping

from cutjoint.control.catalogue import law_row
from cutjoint.errors import InputError
from cutjoint.papers.cpm.published import TABLE_3

Gains = Mapping[str, float]

# The linear error equation of computed torque is the same for every robot.
COMPUTED_TORQUE: Gains = {"kp": 400.0, "kd": 40.0}

GAINS: Mapping[str, Mapping[str, Gains]] = {
    "cpm": {row.controller.replace("_", "-"): {"kp": row.k_p, "kd": row.k_d} for row in TABLE_3},
    "omega3": {
        "pd": {"kp": 1.0, "kd": 0.05},
        "pd-gravity": {"kp": 1.0, "kd": 0.05},
        "feedforward": {"kp": 1.0, "kd": 0.05},
        "computed-torque": COMPUTED_TORQUE,
    },
}


def default_gains(robot: str, law: str) -> Gains:
    """The gains known for a robot and a law.

    Raises:
        UnknownNameError: no such law.
        InputError: none are known.
    """
    takes = law_row(law).gains
    if not takes:
        return {}
    known = GAINS.get(robot, {"computed-torque": COMPUTED_TORQUE})
    if law not in known:
        options = " and ".join(f"--{name.replace('_', '-')}" for name in takes)
        have = f"; known for {robot}: {', '.join(known)}" if known else ""
        raise InputError(f"no gains are known for controller '{law}' on '{robot}'; give {options}{have}")
    return known[law]
