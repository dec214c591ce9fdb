"""The books of energy with dampers, dry friction, springs, stops and bushings: all plants, ten seconds."""

from __future__ import annotations

import numpy as np
import pytest
from kit.physics import with_physics
from kit.quickly import few

from cutjoint.chain import ClosedChain
from cutjoint.control import NoControl
from cutjoint.robots import load
from cutjoint.simulation import Adaptive, ConstrainedPlant, ReducedPlant, run

ROBOTS = ["fourbar", "fivebar", "stewart", "cpm", "omega3"]
TIGHT = Adaptive(1e-11, 1e-12)


def real(robot: str, seed: int = 0) -> ClosedChain:
    description = load(robot).description
    return ClosedChain(with_physics(description, np.random.default_rng(seed)))


def books(result) -> float:
    assert result.dissipated[-1] > 0.0
    assert (np.diff(result.dissipated) >= -1e-12).all()
    return float(result.energy_drift())


@pytest.mark.parametrize("robot", few(ROBOTS, "fourbar"))
@pytest.mark.parametrize("plant", [ReducedPlant, ConstrainedPlant])
def test_ten_seconds(robot: str, plant) -> None:
    chain = real(robot)
    result = run(
        plant(chain),
        NoControl(),
        integrator=TIGHT,
        duration=10.0,
        every=0.1,
        start_velocity=np.full(chain.n, 0.3),
        joint_limits="ignore",
    )
    assert books(result) < 1e-8
