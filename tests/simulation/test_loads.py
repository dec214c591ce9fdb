"""Loads over a run: weights, springs, walls and rods that push; their work is in the balance of the energies."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.quickly import few
from kit.rods import ankle

import cutjoint
from cutjoint import Load
from cutjoint.chain import ClosedChain
from cutjoint.control import PD
from cutjoint.description import load_description
from cutjoint.errors import ActuationError, InputError, SimulationError, UnknownNameError
from cutjoint.motion import Hold, Reference
from cutjoint.simulation import Adaptive, ConstrainedPlant, MinimalPlant, ReducedPlant, load, run, save

TIGHT = Adaptive(1e-11, 1e-13)
PLANTS = {
    "reduced": ReducedPlant,
    "constrained": ConstrainedPlant,
    "minimal": lambda chain: MinimalPlant(chain.minimal()),
}


@pytest.mark.parametrize("plant", few(PLANTS, "constrained"))
@pytest.mark.parametrize("name", few(["fivebar", "stewart"], "fivebar"))
def test_weights_as_loads_are_gravity(plant: str, name: str) -> None:
    """The same motion, and the work of the loads is what the potential energy gives."""
    chain = cutjoint.load(name)
    floating = ClosedChain(replace(chain.description, gravity=np.zeros(3)))
    weights = [
        Load(link.inertial.mass * np.array(chain.description.gravity), link=link.name, point=link.inertial.com)
        for link in chain.description.links
        if link.inertial is not None
    ]
    wanted = run(PLANTS[plant](chain), duration=0.1, integrator=TIGHT, every=0.05)
    found = run(PLANTS[plant](floating), duration=0.1, integrator=TIGHT, every=0.05, loads=weights)
    assert np.abs(found.q - wanted.q).max() < 1e-9 * np.abs(wanted.q - wanted.q[0]).max()
    assert found.load_work == pytest.approx(wanted.potential[0] - wanted.potential, abs=1e-9 * np.ptp(wanted.potential))
    assert found.energy_drift() < 1e-8
    assert "load_work" not in wanted.columns


def spring(chain: ClosedChain, stiffness: float) -> Any:
    """Pulls the tool to where it is at home."""
    foot = chain.tool(chain.home).position

    def pull(t: float, seen: Any) -> Load:
        return Load(-stiffness * (seen.tool - foot))

    return pull, foot


@pytest.mark.parametrize("plant", few(PLANTS, "minimal"))
def test_a_spring_keeps_what_it_takes(plant: str) -> None:
    chain = cutjoint.load("fivebar")
    pull, foot = spring(chain, 200.0)
    v = np.array([0.8, -0.3])
    found = run(PLANTS[plant](chain), duration=0.15, loads=pull, start_velocity=v, integrator=TIGHT)
    stored = 100.0 * np.sum((found.tool - foot) ** 2, axis=1)
    assert np.ptp(stored) > 0.0
    assert found.load_work == pytest.approx(-stored, abs=1e-8 * stored.max())
    assert found.energy_drift() < 1e-8
    assert found.about["loads"] == "the loads' function 'pull'"


def test_a_constant_force_does_the_work_of_its_way_and_a_result_keeps_it(tmp_path: Path) -> None:
    chain = cutjoint.load("stewart")
    force = np.array([3.0, -2.0, 60.0])
    found = run(ReducedPlant(chain), duration=0.1, loads=Load(force), integrator=TIGHT)
    assert found.load_work == pytest.approx((found.tool - found.tool[0]) @ force, abs=1e-9)
    again = load(save(found, tmp_path / "run.npz"))
    assert np.array_equal(again.load_work, found.load_work)
    assert again.about["loads"] == [
        {"link": None, "force": force.tolist(), "moment": [0.0] * 3, "point": [0.0] * 3, "axes": "world"}
    ]
    assert np.array_equal(pickle.loads(pickle.dumps(found)).load_work, found.load_work)
    assert "load work [J]" in save(found, tmp_path / "run.csv").read_text().splitlines()[0]


def test_a_wall_stops_a_held_robot_and_brakes_bear_loads() -> None:
    """Sampled control against a push over time; what a brake gives is inverse dynamics under the load."""
    chain = cutjoint.load("fivebar")
    reference = Reference(Hold(chain.tool(chain.home).position), chain, 0.06)
    law = PD(400.0, 20.0)
    pushes = [lambda t, seen: Load([10.0 * np.sin(20.0 * t), 0.0, 0.0]), Load([10.0, 0.0, 0.0])]
    for loads in pushes:
        found = run(ReducedPlant(chain), law, reference, rate=500.0, loads=loads)
        held = run(ConstrainedPlant(chain), law, reference, rate=500.0, loads=loads)
        assert np.abs(found.q[-1] - held.q[-1]).max() < 1e-8
        assert found.worst_error() > 1e-4
    load_ = Load([10.0, 5.0, 0.0])
    names = [actuator.name for actuator in chain.actuators]
    locked = run(ReducedPlant(chain), duration=0.01, lock=names, loads=load_)
    wanted = chain.inverse_dynamics(chain.home, np.zeros(2), np.zeros(2), load_)
    assert np.abs(locked.effort - wanted).max() < 1e-7 * np.abs(wanted).max()


def test_a_compiled_robot_is_pushed_alike() -> None:
    pytest.importorskip("llvmlite")
    chain = cutjoint.load("fivebar")
    pull, _ = spring(chain, 50.0)
    v = np.array([0.5, 0.2])
    one, two = (
        run(ReducedPlant(robot), duration=0.03, loads=pull, start_velocity=v) for robot in (chain, chain.compile())
    )
    assert np.abs(one.q[-1] - two.q[-1]).max() < 1e-9


def test_what_spins_a_rod_is_refused_where_nobody_would_see_it(tmp_path: Path) -> None:
    """A twist on a ball-ball rod spins it, which the actuated coordinates do not tell; a push through its axis is
    told."""
    chain = ClosedChain(load_description(ankle(np.random.default_rng(3)).write(tmp_path)))
    rod = next(joint.child for joint in chain.description.joints if joint.name in chain.mobility().idle)
    inertial = chain.description.link(rod).inertial
    assert inertial is not None
    along = inertial.com / np.linalg.norm(inertial.com)
    twist = Load(moment=0.1 * along, link=rod, axes="link")
    with pytest.raises(ActuationError, match="push an idle motion"):
        run(ReducedPlant(chain), duration=0.01, loads=twist)
    push = Load(along, link=rod, point=inertial.com, axes="link")
    one, two = (
        run(plant(chain), duration=0.01, loads=push, integrator=TIGHT) for plant in (ReducedPlant, ConstrainedPlant)
    )
    assert np.abs(one.q[-1] - two.q[-1]).max() < 1e-9 * np.abs(one.q[-1] - one.q[0]).max() + 1e-13


def test_bad_loads_of_a_run_are_told() -> None:
    plant = ReducedPlant(cutjoint.load("fivebar"))

    def breaks(t: float, seen: Any) -> Load:
        raise ZeroDivisionError("no wall")

    with pytest.raises(InputError, match="the loads' function 'breaks' raised ZeroDivisionError: no wall"):
        run(plant, duration=0.1, loads=breaks)
    with pytest.raises(InputError, match="the loads' function '<lambda>' gives no loads"):
        run(plant, duration=0.1, loads=lambda t, seen: [1.0, 0.0, 0.0])
    with pytest.raises(UnknownNameError, match="link of fivebar 'tip'"):
        run(plant, duration=0.1, loads=Load(link="tip"))
    with pytest.raises(InputError, match="loads of run must be a Load, a list of Loads"):
        run(plant, duration=0.1, loads=5.0)  # type: ignore[arg-type]
    with pytest.raises(SimulationError, match="no loads"):
        run(plant, duration=0.1, loads=lambda t, seen: Load() if t < 0.05 else None, every=0.01)
