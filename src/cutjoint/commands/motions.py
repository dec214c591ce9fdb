"""Trajectories as the command line names them: `paper`, the robot's own, and those of `motion.TRAJECTORIES`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cutjoint.errors import InputError, UnknownNameError
from cutjoint.motion.catalogue import TRAJECTORIES, describe, trajectory

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain
    from cutjoint.mechanism import Mechanism
    from cutjoint.motion import Trajectory

HELP = "; ".join(["paper (the robot's own)", *map(describe, TRAJECTORIES)]) + "."


def trajectory_of(chain: ClosedChain, spec: str, mechanism: Mechanism | None = None) -> Trajectory:
    """The trajectory that `spec` names, for a robot that starts in the home posture of `mechanism` (default: `chain`).

    Raises:
        UnknownNameError: no such trajectory.
        InputError: its numbers are wrong, or the robot has no published trajectory.
    """
    from cutjoint.robots import PUBLISHED

    name, _, rest = spec.partition(":")
    if name not in ("paper", *TRAJECTORIES):
        raise UnknownNameError("trajectory", name, ("paper", *TRAJECTORIES))
    if name != "paper":
        return trajectory(spec, chain if mechanism is None else mechanism)
    if rest:
        raise InputError(f"'{spec}' is no trajectory; paper takes no numbers")
    robot = chain.description.name
    known = [name for name, row in PUBLISHED.items() if row.path is not None]
    if robot not in known:
        others = ", ".join(f"{one}{row.form}" for one, row in TRAJECTORIES.items())
        raise InputError(f"{robot} has no published trajectory (known: {', '.join(known)}); use {others}")
    return PUBLISHED[robot].trajectory()
