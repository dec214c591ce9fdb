"""Reactions of a run at even steps, of a robot of which it is looked whether it is the one that was simulated."""

from __future__ import annotations

import math

import numpy as np

from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError
from cutjoint.mechanism import kinetic_energy
from cutjoint.simulation.reactions import ReactionHistory, reactions_of
from cutjoint.simulation.result import Result, result_of

SAME = 1e-6
"""Part of the energies of a run that those of the same robot may differ: loops are open by 1e-9 of its length."""


def sampled_reactions(result: Result, robot: ClosedChain, samples: int) -> ReactionHistory:
    """Reactions at so many samples or fewer, evenly spaced among those of the run.

    Raises:
        InputError: the run is not one of this robot: of other joints, masses, payload or physics.
        CutjointError: as of `reactions_of`.
    """
    every = max(1, math.ceil(len(result) / samples))
    part = result_of({name: column[::every] for name, column in result.columns.items()}, result.about)
    found = reactions_of(part, robot)
    check_same_robot(part, robot)
    return found


def check_same_robot(result: Result, robot: ClosedChain) -> None:
    """That `robot` has the energies that the run has, so its masses and springs, and that its joints take energy where
    those of the run did: a payload or another variant is not told by a result.

    Raises:
        InputError: it has not.
    """
    told = "a run with a payload, another variant or ideal joints; give the robot it was made with"
    if robot.dissipates != ("dissipated" in result.more):
        has, had = ("has", "had none") if robot.dissipates else ("has no", "had some")
        raise InputError(f"{robot.name} {has} friction in its joints and the robot of the run {had}: {told}")
    size = float(np.abs(result.kinetic).max() + np.abs(result.potential).max())
    for i in np.unique(np.linspace(0, len(result) - 1, 5).astype(int)):
        at = robot.posture(result.q_full[i])
        kinetic = kinetic_energy(robot, at, result.v[i])
        for name, own, had_energy in (
            ("kinetic", kinetic, float(result.kinetic[i])),
            ("potential", robot.potential_energy(at), float(result.potential[i])),
        ):
            if abs(own - had_energy) > SAME * size:
                raise InputError(
                    f"{robot.name} would have {own:.6g} J of {name} energy at {result.time[i]:.6g} s, the run has "
                    f"{had_energy:.6g} J: {told}"
                )
