"""A run takes the compiled plant where there is one, says so, and gives what the chain gives."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import llvmlite.binding as llvm
import numpy as np
import pytest
from kit.physics import with_physics
from kit.quickly import few

from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled, compiled_plant
from cutjoint.compile.machine.llvm import native
from cutjoint.control import PD, ComputedTorque
from cutjoint.description import load_description
from cutjoint.description.catalogue import path
from cutjoint.errors import SimulationError
from cutjoint.mechanism import kinetic_energy
from cutjoint.motion import JointSine, Reference
from cutjoint.simulation import Adaptive, ConstrainedPlant, ReducedPlant, Result, RungeKutta4, run
from cutjoint.simulation.hardware import Clock, Drive, Hardware, TorqueSpeed

SPAN, RATE = 0.05, 1000.0
EXACT = Adaptive(1e-12, 1e-14)
ROBOTS = ("fourbar", "fivebar", "stewart", "cpm", "cpm_rotary", "omega3", "paper cpm", "paper omega3")
COLUMNS = ("q", "v", "effort", "tool", "tool_velocity", "kinetic", "potential", "work", "q_full", "gap")
COLUMNS_BUT_KINETIC = tuple(name for name in COLUMNS if name != "kinetic")


def swing(t: float) -> float:
    """Efforts as parts of what holds a robot."""
    return float(np.sin(40.0 * t))


def pushed(mechanism: Any) -> Any:
    """Efforts that keep any robot moving, whoever has the motors."""
    n = mechanism.n
    try:
        weight = mechanism.terms(mechanism.home).holding
    except Exception:
        weight = np.full(n, 1.0)
    return lambda t: weight * (1.0 + 0.5 * swing(t)) + 0.1 * np.abs(weight).max() * np.sin(25.0 * t + np.arange(n))


def plain_plant(mechanism: Any) -> Any:
    return ConstrainedPlant(mechanism) if isinstance(mechanism, ClosedChain) else ReducedPlant(mechanism)


def same(found: Result, wanted: Result, tolerance: float = 1e-9, columns: tuple[str, ...] = COLUMNS) -> None:
    np.testing.assert_array_equal(found.time, wanted.time)
    for name in columns:
        if name == "q_full" and found.q_full.shape != wanted.q_full.shape:
            continue
        one, other = getattr(found, name), getattr(wanted, name)
        np.testing.assert_allclose(one, other, rtol=0, atol=tolerance * max(1.0, np.abs(other).max()), err_msg=name)


@pytest.mark.parametrize("name", few(ROBOTS, "fivebar", "omega3", "paper cpm"))
def test_the_compiled_plant_is_taken_and_moves_as_the_robot_does(kit: Any, name: str) -> None:
    robot = kit.model(name)
    reference = Reference(JointSine.from_home(robot, 0.05, 3.0), robot, SPAN)
    law = ComputedTorque(robot, 400.0, 40.0)
    options = {"rate": RATE, "every": 1e-3}
    found = run(robot, law, reference, **options)
    assert found.about["plant"].endswith("compiled")
    assert "machine code" in found.about["integrator"]
    assert "not_compiled" not in found.about
    same(found, run(plain_plant(robot), law, reference, integrator=EXACT, **options))
    assert found.loop_gap()[0] < 1e-13
    assert found.energy_drift() < 1e-10
    # between the samples of the controller too, and where samples and records fall apart
    options = {"rate": 730.0, "every": 0.4e-3}
    same(run(robot, law, reference, **options), run(plain_plant(robot), law, reference, integrator=EXACT, **options))


@pytest.mark.parametrize("name", few(["redundant", "underactuated", "stewart"], "redundant"))
def test_robots_that_their_motors_do_not_determine_are_compiled_in_all_joints(kit: Any, name: str) -> None:
    robot = kit.model(name)
    found = run(robot, pushed(robot), duration=SPAN, rate=RATE, every=1e-3)
    assert found.about["plant"].endswith("compiled")
    same(found, run(ConstrainedPlant(robot), pushed(robot), duration=SPAN, rate=RATE, every=1e-3, integrator=EXACT))
    assert found.loop_gap()[0] < 1e-11


@pytest.mark.parametrize("seed", few(range(6), 3))
@pytest.mark.parametrize("name", ["fivebar", "cpm"])
def test_friction_springs_and_rotors_of_all_joints_act_and_are_accounted_for(name: str, seed: int) -> None:
    robot = ClosedChain(with_physics(load_description(path(name)), np.random.default_rng(seed)))
    found = run(robot, pushed(robot), duration=SPAN, rate=RATE, every=1e-3)
    assert "not_compiled" not in found.about
    wanted = run(ConstrainedPlant(robot), pushed(robot), duration=SPAN, rate=RATE, every=1e-3, integrator=EXACT)
    same(found, wanted, 1e-8, COLUMNS_BUT_KINETIC)
    for k in (10, 50):  # of the mass matrix; Pinocchio's kinetic energy leaves rotors about some axes out
        at = robot.close(found.q[k], robot.home, limits="ignore")
        assert found.kinetic[k] == pytest.approx(kinetic_energy(robot, at, found.v[k]), rel=1e-9)
    np.testing.assert_allclose(found.dissipated, wanted.dissipated, rtol=1e-7, atol=1e-10)
    assert found.dissipated[-1] > 0.0
    assert found.energy_drift() < 1e-8


def test_a_plant_that_is_given_is_taken_as_it_is(kit: Any) -> None:
    robot = kit.model("fivebar")
    found = run(ConstrainedPlant(robot), duration=0.01, rate=RATE)
    assert found.about["plant"] == "fivebar, constrained"
    assert "not_compiled" not in found.about
    # and so is an integrator
    assert run(robot, duration=0.01, rate=RATE, integrator=RungeKutta4(1e-3)).about["integrator"].startswith("RK4")


def test_what_is_not_compiled_says_why(kit: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = kit.model("paper cpm_rotary")
    found = run(robot, duration=0.01, rate=RATE, every=1e-3)
    assert found.about["plant"].endswith("reduced")
    assert "only closed chains and published models with closed forward" in found.about["not_compiled"]

    description = load_description(path("fivebar"))
    joints = [one.name for one in description.joints]
    sticky = with_physics(description, np.random.default_rng(0))
    still = [replace(one, physics=replace(one.physics, friction=1.0, friction_speed=0.0)) for one in sticky.joints]
    found = run(ClosedChain(replace(sticky, joints=tuple(still))), duration=2e-3, rate=RATE, every=1e-3)
    assert found.about["plant"] == "fivebar, constrained"
    assert joints[0] in found.about["not_compiled"]
    assert "friction_speed" in found.about["not_compiled"]

    native._host.cache_clear()
    monkeypatch.setitem(__import__("sys").modules, "llvmlite.binding", None)
    monkeypatch.delattr("llvmlite.binding")
    found = run(ClosedChain(description), duration=0.01, rate=RATE, every=1e-3)
    assert found.about["plant"] == "fivebar, constrained"
    assert "pip install 'cutjoint[compile]'" in found.about["not_compiled"]
    monkeypatch.undo()
    assert llvm is __import__("llvmlite.binding").binding


def test_efforts_that_change_with_the_motion_are_not_held(kit: Any) -> None:
    """A motor whose torque falls with its speed: one evaluation at a time, and said."""
    robot = kit.model("fivebar")
    slow = Hardware(Clock(RATE), drive=Drive(torque_speed=TorqueSpeed(5.0, 20.0)))
    law = PD(60.0, 3.0)
    reference = Reference(JointSine.from_home(robot, 0.3, 3.0), robot, SPAN)
    found = run(robot, law, reference, hardware=slow, every=1e-3)
    assert found.about["integrator"].startswith("DOP853")
    same(found, run(ConstrainedPlant(robot), law, reference, hardware=slow, every=1e-3, integrator=EXACT), 1e-7)


@pytest.mark.parametrize("name", ["fivebar", "cpm"])
def test_a_joint_that_passes_its_limits_ends_the_run_where_it_does_with_the_chain(kit: Any, name: str) -> None:
    robot = kit.model(name)
    law = pushed(robot)

    def harder(t: float) -> Any:
        return 8.0 * law(t)

    ends = []
    for plant, method in ((robot, None), (ConstrainedPlant(robot), EXACT)):
        with pytest.raises(SimulationError, match="passes its") as stopped:
            run(plant, harder, duration=5.0, rate=RATE, every=1e-3, integrator=method)
        ends.append(stopped.value)
    assert ends[0].t == pytest.approx(ends[1].t, abs=1e-7)
    np.testing.assert_allclose(ends[0].result.q[:-1], ends[1].result.q[:-1], rtol=0, atol=1e-7)


def test_stretches_are_as_exact_as_they_say_whatever_they_are_cut_into(kit: Any) -> None:
    """One stretch of 20 ms, and twenty of 1 ms."""
    plant = compiled_plant(compiled(kit.model("omega3"), quick=True))
    state = plant.start(kit.model("omega3").home, np.full(3, 0.1))
    effort = kit.model("omega3").terms(kit.model("omega3").home).holding * 1.2
    whole = plant.advance(state, effort, 0.02, np.inf)
    assert whole is not None
    work, ahead = 0.0, np.inf
    for _ in range(20):
        done = plant.advance(state, effort, 1e-3, ahead)
        assert done is not None
        state, ahead, work = done.state, done.ahead, work + done.work
    np.testing.assert_allclose(whole.state.q, state.q, rtol=0, atol=1e-10)
    np.testing.assert_allclose(whole.state.v, state.v, rtol=0, atol=1e-9)
    assert whole.work == pytest.approx(work, abs=1e-9)
    assert plant.advance(plant.start(kit.model("omega3").home, np.full(3, 0.1)), effort * np.nan, 1e-3, 1e-3) is None
