"""Runs in minimal coordinates: what flies keeps its momentum, what falls its energy, and full coordinates agree."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.built import built
from kit.by_joint import state as oracle_state
from kit.mechanisms import MECHANISMS
from kit.quickly import few

import cutjoint
from cutjoint import Load
from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError
from cutjoint.simulation import Adaptive, ConstrainedPlant, MinimalPlant, State, run

TIGHT = Adaptive(1e-11, 1e-13)


def flying(name: str, folder: Path, gravity: float = 1.0) -> tuple[ClosedChain, Any, np.random.Generator]:
    """A mechanism that flies, with a tool on its last link."""
    rng = np.random.default_rng([41, *name.encode()])
    plan = MECHANISMS[name](rng).plan
    plan.tool = (plan.joints[-1].child, plan.poses[plan.joints[-1].child].position)
    chain, oracle = built(plan, folder)
    oracle.robot = replace(oracle.robot, gravity=gravity * oracle.robot.gravity)
    return ClosedChain(replace(chain.description, gravity=gravity * chain.description.gravity)), oracle, rng


def test_a_flying_fourbar_keeps_momentum_and_energy(tmp_path: Path) -> None:
    """Without gravity: energy, whatever its motor does, and linear and angular momentum by the oracle."""
    chain, oracle, rng = flying("floating_fourbar", tmp_path, gravity=0.0)
    plant = MinimalPlant(chain.minimal())
    start = plant.state(chain.home, rng.normal(size=7))
    for law in (None, lambda t: [0.05 * np.sin(5.0 * t)]):
        found = run(plant, law, start=start, duration=0.2, integrator=TIGHT, every=0.1)
        assert found.energy_drift() < 1e-9
        assert (law is None) == (not found.work.any())
        assert found.loop_gap()[0] < 1e-12
    whole = run(ConstrainedPlant(chain), start=_full(plant, start), duration=0.2, integrator=TIGHT, every=0.1)
    free = run(plant, start=start, duration=0.2, integrator=TIGHT, every=0.1)
    assert np.abs(whole.q_full - free.q_full).max() < 1e-8
    momenta = [np.concatenate(oracle_state(chain, oracle, q, v).momentum()) for q, v in _states(plant, start)]
    assert np.abs(momenta[0]).min() > 1e-3
    assert np.abs(np.array(momenta) - momenta[0]).max() < 1e-9 * np.abs(momenta[0]).max()


def _full(plant: MinimalPlant, state: State) -> State:
    return State(state.q, plant.minimal.full_velocity(state.posture, state.v))


def _states(plant: MinimalPlant, start: State) -> list[tuple[np.ndarray, np.ndarray]]:
    """Configurations and velocities of all joints on the way, by the plant's own equations."""
    found, state = [], start
    n, effort = start.v.size, np.zeros(plant.chain.n)

    def field(t: float, y: np.ndarray, origin: State) -> np.ndarray:
        here = plant.moved(origin, y[:n], y[n:])
        return np.concatenate([plant.chart_rate(origin, here), plant.acceleration(here, effort)])

    for count in range(76):
        if count % 25 == 0:
            found.append((state.q, plant.minimal.full_velocity(state.posture, state.v)))
        y = np.concatenate([plant.chart(state), state.v])
        slopes = []
        for ahead in (0.0, 0.5e-3, 0.5e-3, 1e-3):
            slopes.append(field(0.0, y if not slopes else y + ahead * slopes[-1], state))
        y = y + 1e-3 / 6.0 * (slopes[0] + 2.0 * slopes[1] + 2.0 * slopes[2] + slopes[3])
        state = plant.moved(state, y[:n], y[n:])
    return found


@pytest.mark.parametrize("name", few(["hexapod", "planar_3rrr", "geared_fivebar"], "hexapod"))
def test_it_moves_as_in_full_coordinates(name: str, tmp_path: Path) -> None:
    """A standing hexapod driven by its 18 motors and pushed, and planar robots of which one motor is left."""
    chain, _, rng = flying(name, tmp_path)
    if name != "hexapod":
        chain = ClosedChain(replace(chain.description, actuators=chain.description.actuators[:1]))
    from kit.loaded import minimal_of

    plant = MinimalPlant(minimal_of(chain))
    load, effort = Load([0.5, 0.3, 0.2]), 0.1 * rng.normal(size=chain.n)
    start = plant.state(chain.home, 0.1 * rng.normal(size=plant.minimal.n))
    runs = [
        run(one, lambda t: effort, start=first, duration=0.1, integrator=TIGHT, loads=load, every=0.05)
        for one, first in ((plant, start), (ConstrainedPlant(chain), _full(plant, start)))
    ]
    for found in runs:
        assert found.energy_drift() < 1e-8
    assert np.abs(runs[0].q_full - runs[1].q_full).max() < 1e-8
    for column in ("v", "tool", "tool_velocity", "kinetic", "potential", "work", "load_work", "angular_velocity"):
        one, two = (getattr(found, column, None) for found in runs)
        assert (one is None) == (two is None)
        assert one is None or np.abs(one - two).max() < 1e-7 * max(1.0, np.abs(two).max())
    if name == "hexapod":
        with pytest.raises(InputError, match="is no coordinate of hexapod, minimal"):
            run(plant, duration=0.1, lock=["leg1_1"])
        with pytest.raises(InputError, match=r"plant\.state\(posture, v\)"):
            run(plant, duration=0.1, start_velocity=np.ones(18))


def test_a_crane_in_minimal_coordinates() -> None:
    """Brakes hold its cart, plain coordinates are their own chart, and it can be pickled."""
    chain = cutjoint.load("underactuated")
    plant = MinimalPlant(chain.minimal("left"))
    assert plant.minimal.is_flat
    start = plant.state(plant.minimal.moved(chain.home, [0.0, 0.4]), [0.0, 0.0])
    found = run(plant, start=start, duration=0.5, integrator=TIGHT, lock=["cart"])
    assert np.abs(found.q).max() < 1e-12
    assert found.energy_drift() < 1e-9
    assert np.ptp(found.tool[:, 0]) > 1e-2
    again = run(pickle.loads(pickle.dumps(plant)), start=start, duration=0.5, integrator=TIGHT, lock=["cart"])
    assert np.array_equal(again.q_full, found.q_full)
    moved = run(plant, start=plant.minimal.moved(chain.home, [0.0, 0.4]), start_velocity=[0.2], duration=0.01)
    assert moved.v[0] == pytest.approx([0.2])


def test_a_robot_without_a_tool_is_told() -> None:
    chain = cutjoint.load("underactuated")
    bare = ClosedChain(replace(chain.description, tool=None, task=()))
    with pytest.raises(InputError, match="no tool frame to simulate"):
        MinimalPlant(bare.minimal("left"))
