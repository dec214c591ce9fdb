"""Joint limits in a run: it stops where the first joint passes its limit, passive ones too, and says which and when."""

from __future__ import annotations

import dataclasses
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.by_joint import coordinates
from kit.led import with_limits
from kit.led_robots import somewhere
from kit.quickly import few

import cutjoint
from cutjoint import tolerances
from cutjoint.chain import ClosedChain
from cutjoint.control import PD
from cutjoint.description import Frame, Inertial, Joint, JointType, Link, RobotDescription
from cutjoint.description.model import Limits
from cutjoint.errors import LimitError, SimulationError
from cutjoint.motion import Reference
from cutjoint.simulation import Adaptive, ConstrainedPlant, DormandPrince, ReducedPlant, RungeKutta4, State, run
from cutjoint.simulation.interpolant import hermite
from cutjoint.simulation.joint_limits import JointGuard

PLANTS = {"reduced": ReducedPlant, "constrained": ConstrainedPlant}
METHODS = [RungeKutta4(7e-3), Adaptive(), Adaptive(method="RK45"), DormandPrince()]
MASS = 2.0


def slider() -> ClosedChain:
    """A block of 2 kg on a level rail, 0.3 m either way."""
    links = (Link("base"), Link("block", Inertial(MASS, inertia=np.eye(3))))
    rail = Joint("rail", JointType.PRISMATIC, "base", "block", axis=[1.0, 0.0, 0.0], limits=Limits(-0.3, 0.3))
    found = RobotDescription("slider", links, (rail,), (), actuators=("rail",), tool=Frame("block"))
    return ClosedChain(found)


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("method", METHODS, ids=lambda one: one.name)
@pytest.mark.parametrize("every", [None, 0.05])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_time_of_a_crossing_is_that_of_the_closed_form(plant: str, method: Any, every: Any, sign: float) -> None:
    """A force that grows with time, F = 12 m t, moves a block by 2 t^3: at 0.3 m after (0.15)^(1/3) s."""
    chain = slider()
    with pytest.raises(SimulationError) as caught:
        run(PLANTS[plant](chain), lambda t: [sign * 12.0 * MASS * t], duration=1.0, integrator=method, every=every)
    error = caught.value
    bound = "upper limit of 0.3 m" if sign > 0.0 else "lower limit of -0.3 m"
    assert f"joint 'rail' passes its {bound}" in str(error)
    assert error.t == pytest.approx(0.15 ** (1 / 3), abs=1e-9)
    result: Any = error.result
    assert result.time[-1] == error.t
    assert result.q[-1, 0] == pytest.approx(sign * 0.3, abs=1e-9)
    assert np.abs(result.q).max() <= 0.3 + 1e-11
    cause = error.__cause__
    assert isinstance(cause, LimitError)
    assert (cause.joint, cause.bounds) == ("rail", (-0.3, 0.3))
    assert "rail" in str(pickle.loads(pickle.dumps(error)))


def test_a_sample_inside_a_step_is_never_beyond_a_limit() -> None:
    """Out and back within one step, which ends inside: x = 0.31 sin(pi t), seen where it is recorded."""
    chain = slider()

    def force(t: float) -> list[float]:
        return [-MASS * 0.31 * np.pi**2 * np.sin(np.pi * t)]

    settings: Any = {"duration": 1.0, "start_velocity": [0.31 * np.pi], "integrator": Adaptive(1e-3, 1e-3)}
    assert run(ReducedPlant(chain), force, joint_limits="ignore", **settings).about["steps"] < 6
    with pytest.raises(SimulationError, match="upper limit") as caught:
        run(ReducedPlant(chain), force, every=0.01, **settings)
    assert caught.value.t == pytest.approx(np.arcsin(0.3 / 0.31) / np.pi, abs=1e-3)


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("method", [RungeKutta4(1e-2), Adaptive()], ids=lambda one: one.name)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_joint_that_starts_beyond_may_come_back_but_not_go_further(plant: str, method: Any, sign: float) -> None:
    chain, side, push = slider(), "upper limit" if sign > 0.0 else "lower limit", sign * MASS
    made, start = PLANTS[plant](chain), chain.close([0.4 * sign], limits="ignore")
    back = run(made, lambda t: [-push], duration=0.5, integrator=method, start=start)
    assert back.q[-1, 0] == pytest.approx(sign * (0.4 - 0.125))
    with pytest.raises(SimulationError, match=side) as caught:
        run(made, lambda t: [push], duration=0.5, integrator=method, start=start)
    assert 0.4 <= sign * caught.value.q[0] <= 0.4 + 2.0 * tolerances.RESTING.value  # by no more than errors of a run
    # Back by 4 cm, still beyond, and out again: no further than it was, and that is where it stood on the way.
    with pytest.raises(SimulationError, match=side) as caught:
        run(made, lambda t: [-push * np.cos(5.0 * t)], duration=0.9, integrator=method, every=1e-2, start=start)
    assert 0.0 < caught.value.t < 0.9
    # Inside, it is as any other joint.
    with pytest.raises(SimulationError, match=side) as caught:
        run(made, lambda t: [-push if t < 0.5 else 8.0 * push], duration=1.5, integrator=RungeKutta4(1e-2), start=start)
    assert sign * caught.value.q[0] == pytest.approx(0.3, abs=1e-6)


@pytest.mark.parametrize(
    "name", few(["stewart", "planar_3rrr", "fivebar", "tripod", "spherical_3rrr"], "planar_3rrr", "tripod")
)
@pytest.mark.parametrize("passive", [False, True])
@pytest.mark.parametrize("plant", PLANTS)
def test_the_first_joint_is_told_of_robots_of_random_shapes(
    name: str, passive: bool, plant: str, tmp_path: Path
) -> None:
    """A run without limits tells where its joints go; a limit put on the way of one stops it there."""
    robot = somewhere(name, 0, tmp_path, np.random.default_rng(1))
    free = robot.chain
    slides = np.array([one.kind == "translation" for one in free.actuators])
    settings: Any = {"duration": 0.1, "start_velocity": np.where(slides, robot.length, 1.0) * 0.5, "every": 1e-3}
    settings["integrator"] = Adaptive(1e-11, 1e-13)
    whole = run(PLANTS[plant](free), joint_limits="ignore", **settings)
    places = [coordinates(free, q) for q in whole.q_full]
    actuators = [one.name for one in free.actuators]
    single = [one for one, value in places[0].items() if np.ndim(value) == 0 and (one not in actuators) is passive]
    if not single:
        pytest.skip("it has no passive joint of one coordinate")
    way = {one: np.array([place[one] for place in places]) for one in single}
    joint = max(single, key=lambda one: float(np.ptp(way[one])))
    middle = len(whole) // 2
    bound = float(way[joint][middle])
    out = np.flatnonzero(np.sign(way[joint] - bound) == np.sign(way[joint][-1] - bound))
    first = float(whole.time[out[0]])
    rising = way[joint][out[0]] > bound
    chain = ClosedChain(with_limits(robot.description, {joint: (-99.0, bound) if rising else (bound, 99.0)}))
    with pytest.raises(SimulationError) as caught:
        run(PLANTS[plant](chain), **settings)
    told = f"joint '{joint}' passes its {'upper' if rising else 'lower'} limit of {bound:.6g}"
    assert told in str(caught.value)
    assert first - 1e-3 - 1e-9 <= caught.value.t <= first + 1e-9
    result: Any = caught.value.result
    assert coordinates(chain, result.q_full[-1])[joint] == pytest.approx(bound, abs=1e-9)
    again = run(PLANTS[plant](chain), joint_limits="ignore", **settings)
    assert np.allclose(again.q, whole.q, rtol=0.0, atol=1e-9)


def test_a_published_model_knows_no_limits() -> None:
    paper = cutjoint.published("cpm")
    found = run(ReducedPlant(paper), PD(0.0, 0.0), Reference_at(paper), duration=0.2)
    assert found.time[-1] == 0.2


def Reference_at(mechanism: Any) -> Reference:
    from cutjoint.motion import Hold

    return Reference(Hold(mechanism.tool(mechanism.home).position), mechanism)


def test_the_cubic_between_two_states_is_exact_for_cubics() -> None:
    rng = np.random.default_rng(0)
    c = rng.normal(size=(4, 5))
    powers = np.arange(4)

    def y(t: float) -> Any:
        return (t**powers) @ c

    def f(t: float) -> Any:
        return (powers[1:] * t ** powers[:-1]) @ c[1:]

    between = hermite((0.2, y(0.2), f(0.2)), (1.7, y(1.7), f(1.7)))
    for t in (0.2, 0.5, 1.0, 1.6, 1.7):
        assert np.allclose(between(t), y(t), rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("beyond", [0.0, 0.02])
def test_a_joint_that_rests_at_its_limit_or_beyond_is_let_be(beyond):
    """Errors of the run do not end it; a joint that moves further does."""
    robot = cutjoint.load("fivebar")
    at = robot.home.actuated["left_shoulder"]
    joints = tuple(
        dataclasses.replace(one, limits=dataclasses.replace(one.limits, lower=at + beyond))
        if one.name == "left_shoulder"
        else one
        for one in robot.description.joints
    )
    robot = robot.rebuilt(dataclasses.replace(robot.description, joints=joints))
    guard = JointGuard(robot, State(robot.home.q_full, np.zeros(robot.nv)))
    row = int(robot.model.idx_qs[robot.model.getJointId("left_shoulder")])

    def passed(by):
        q = robot.home.q_full.copy()
        q[row] += by
        state = State(q, np.zeros(robot.nv))
        found = guard.passed(state)
        if found is None:
            guard.accept(state)
        return found is not None

    for _ in range(5):
        assert not passed(-5e-7)  # it does not creep, however often
    assert passed(-2e-6)
    assert not passed(0.01)
    assert passed(-1e-5)
    assert passed(0.005) == (beyond > 0.0)  # what has come back stays back


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_joint_that_creeps_over_its_limit_is_told(sign: float) -> None:
    """From its limit at 2e-6 m/s, less than 1e-7 m a sample: it goes as far as errors of a run do, and no further."""
    chain = slider()
    start = chain.close([0.3 * sign], limits="ignore")
    settings: Any = {"duration": 10.0, "every": 0.04, "start": start, "start_velocity": [sign * 2e-6]}
    with pytest.raises(SimulationError, match="passes its") as caught:
        run(ReducedPlant(chain), integrator=RungeKutta4(0.04), **settings)
    assert caught.value.t == pytest.approx(chain.length * tolerances.RESTING.value / 2e-6, rel=1e-6)
    assert abs(caught.value.q[0]) - 0.3 <= chain.length * tolerances.RESTING.value * (1.0 + 1e-6)
