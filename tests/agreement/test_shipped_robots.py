"""Every robot under urdf/, in every variant, against Newton's and Euler's equations in maximal coordinates.

The oracle reads the files itself and knows neither cutjoint nor Pinocchio.  1e-10 relative for everything: mobility,
accelerations of all joints, both equations of motion, loop forces of least norm, inverse dynamics, energies.
"""

from __future__ import annotations

import numpy as np
import pytest
from kit import judge
from kit.by_joint import by_joint, oracle_of, placed
from kit.postures import moving, random_posture

from cutjoint.chain import ClosedChain
from cutjoint.description import catalogue, load_description

ROBOTS = [
    (name, variant)
    for name in catalogue.names()
    for variant in [None, *(one.name for one in load_description(name).variants)]
]


@pytest.mark.parametrize(("name", "variant"), ROBOTS)
def test_everything_at_random_postures(name: str, variant: str | None) -> None:
    chain, rng = ClosedChain(load_description(name, variant)), np.random.default_rng(7)
    oracle = oracle_of(chain)
    for at in [chain.home, *(random_posture(chain, oracle, rng) for _ in range(2))]:
        p = placed(chain, oracle, at.q_full)
        assert p.margin[0] > 1e-3 > 1e9 * p.margin[1], "a posture whose mobility anybody can tell"
        v = moving(chain, p, 2.0 * rng.normal(size=p.mobility))
        effort = 3.0 * rng.normal(size=chain.nv)
        found = judge.everything(chain, oracle, at, v, effort, rng)
        judge.require(found, 1e-10)


@pytest.mark.parametrize(
    "name", [name if name == "fourbar" else pytest.param(name, marks=pytest.mark.slow) for name in catalogue.names()]
)
def test_compiled(name: str) -> None:
    """The straight-line code of every robot that its actuators determine."""
    pytest.importorskip("llvmlite")
    chain, rng = ClosedChain(load_description(name)), np.random.default_rng(8)
    oracle, compiled = oracle_of(chain), chain.compile()
    for at in [chain.home, random_posture(chain, oracle, rng)]:
        p = placed(chain, oracle, at.q_full)
        v, effort = moving(chain, p, 2.0 * rng.normal(size=p.mobility)), 3.0 * rng.normal(size=chain.nv)
        motion = p.moving(by_joint(chain, v)).driven(by_joint(chain, effort))
        assert judge.apart(chain, motion, compiled.full_acceleration(at.q_full, v, effort)) < 1e-10
        if chain.mobility(at).determined:
            judge.require(judge.actuated(chain, oracle, at, rng, compiled), 1e-10)
