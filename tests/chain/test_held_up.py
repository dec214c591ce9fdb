"""Weights that are compensated in part: as loads that lift the centres of mass, in energy, with a payload and in runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.held_up import held_up, lifts, weighing
from kit.quickly import few
from kit.random_robots import random_robot

from cutjoint.chain import ClosedChain
from cutjoint.chain.rank import null_space
from cutjoint.description import load_description
from cutjoint.errors import CutjointError

SHIPPED = ("fourbar", "fivebar", "omega3", "cpm", "stewart")


def drawn(seed: int, folder: Path) -> tuple[ClosedChain, ClosedChain]:
    """A random robot that is held up, and the same without."""
    rng = np.random.default_rng(seed)
    plan = random_robot(rng, int(rng.integers(2, 7)), int(rng.integers(1, 4)), folder)
    robot = held_up(load_description(plan.write(folder)), rng)
    return ClosedChain(robot), ClosedChain(weighing(robot))


def near(found: np.ndarray, wanted: np.ndarray, terms: float) -> None:
    assert np.abs(np.asarray(found) - wanted).max(initial=0.0) <= 1e-9 * terms


@pytest.mark.parametrize("seed", few(range(40), 0, 1, 2))
def test_random_robots_move_as_if_lifted(seed: int, tmp_path: Path) -> None:
    """Accelerations, loop forces and reactions are those of loads at the centres of mass."""
    (chain, plain), rng = drawn(seed, tmp_path), np.random.default_rng(seed)
    loads, home = lifts(chain.description), plain.home
    motions = null_space(plain._k.at(home.q_full).scaled)
    v = plain._k.column_scale * (motions @ rng.normal(size=motions.shape[1]))
    effort = rng.normal(size=plain.nv)
    try:
        wanted = plain.full_forward_dynamics(home, v, effort, loads)
    except CutjointError as error:
        with pytest.raises(type(error)):
            chain.full_forward_dynamics(chain.home, v, effort)
        return
    found = chain.full_forward_dynamics(chain.home, v, effort)
    unit = plain._k.column_scale
    near(found.acceleration / unit, wanted.acceleration / unit, 1.0 + np.abs(wanted.acceleration / unit).max(initial=0))
    near(chain.full_acceleration(home.q_full, v, effort) / unit, wanted.acceleration / unit,
         1.0 + np.abs(wanted.acceleration / unit).max(initial=0))  # fmt: skip
    for name, force in wanted.loop_forces.items():
        near(found.loop_forces[name].force, force.force, 100.0 + np.abs(force.force).max())
    lifted = chain.full_reactions(chain.home, v, wanted.acceleration, effort)
    for one, other in zip(lifted, plain.full_reactions(home, v, wanted.acceleration, effort, loads), strict=True):
        near(one.wrench, other.wrench, 100.0 + np.abs(other.wrench).max())
