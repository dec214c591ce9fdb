"""The worst case anywhere, loads of bearings, several trajectories at once, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kit.quickly import few
from kit.small import write

import cutjoint
from cutjoint.errors import InputError
from cutjoint.motion import Hold, JointSine, PointToPoint, Reference
from cutjoint.motion.catalogue import trajectory
from cutjoint.sizing import size, size_anywhere


@pytest.mark.parametrize("name", few(["fivebar", "omega3", "cpm", "stewart"], "fivebar"))
def test_nothing_asked_of_the_tool_is_worse_than_the_worst_case(name: str) -> None:
    """Random motions of the tool within the bounds, at the posture where an effort was largest."""
    robot, rng = cutjoint.load(name), np.random.default_rng(4)
    turns = any(row >= 3 for row in robot.task.rows)
    more = {"turn_speed": 2.0, "turn_acceleration": 20.0} if turns else {}
    found = size_anywhere(robot, 1.0, 10.0, samples=12, **more)
    assert found.postures == 12
    task, tried = robot.task, []
    for row in range(robot.n):
        at = robot.close(found.at_effort[row])
        tool = robot.tool(at)
        condition = task.towards(tool.pose, task.rows).matrix(tool.rotation)
        inverse = np.linalg.inv(condition @ tool.frame_jacobian)
        for _ in range(20):
            parts = []
            for point, turn in ((1.0, 2.0), (10.0, 20.0)):
                wanted = rng.normal(size=robot.n)
                of_turn = np.array([one >= 3 for one in task.rows])
                for own, most in ((~of_turn, point), (of_turn, turn)):
                    if own.any():
                        wanted[own] *= most / np.linalg.norm(wanted[own])
                parts.append(wanted)
            v = inverse @ parts[0]
            a = inverse @ (parts[1] - condition @ robot.tool(at, v).frame_drift)
            assert np.all(np.abs(v) <= found.speed * (1.0 + 1e-9))
            still = inverse @ parts[1]
            assert np.all(np.abs(robot.inverse_dynamics(at, 0.0 * v, still)) <= found.effort * (1.0 + 1e-9))
            tried.append(np.abs(robot.inverse_dynamics(at, v, a)) / found.effort)
    assert np.max(tried) < 1.3  # directions of the speed are drawn, so a little may be missed
    assert np.all(found.holding <= found.effort)


@pytest.mark.parametrize("name", few(["fivebar", "omega3", "cpm"], "fivebar"))
def test_the_worst_direction_of_the_acceleration_is_met_exactly(name: str) -> None:
    """At hardly any speed: along the row of M B, the way of the weights."""
    robot = cutjoint.load(name)
    found = size_anywhere(robot, 1e-9, 10.0, samples=6)
    task = robot.task
    for row in range(robot.n):
        at = robot.close(found.at_effort[row])
        tool = robot.tool(at)
        condition = task.towards(tool.pose, task.rows).matrix(tool.rotation)
        inverse, terms = np.linalg.inv(condition @ tool.frame_jacobian), robot.terms(at)
        along = (terms.mass @ inverse)[row]
        sign = np.sign(terms.holding[row]) or 1.0
        a = inverse @ (10.0 * sign * along / np.linalg.norm(along))
        effort = robot.inverse_dynamics(at, np.zeros(robot.n), a)[row]
        assert abs(effort) == pytest.approx(found.effort[row], rel=1e-7)


@pytest.mark.slow
def test_heavier_and_faster_is_worse() -> None:
    robot = cutjoint.load("fivebar")
    one = size_anywhere(robot, 1.0, 10.0, samples=8)
    same = size_anywhere(robot, 1.0, 10.0, samples=8)
    assert np.array_equal(one.effort, same.effort)
    twice = size_anywhere(robot, 2.0, 10.0, samples=8)
    assert np.allclose(twice.speed, 2.0 * one.speed)
    accelerated = size_anywhere(robot, 1.0, 20.0, samples=8)
    assert np.all(accelerated.effort > one.effort)


@pytest.mark.slow
def test_a_hanging_weight_loads_its_bearing(tmp_path: Path) -> None:
    """A pendulum at rest hangs its weight into its hinge; swinging, by hand, m (g cos q + l v^2) along the rod."""
    robot = cutjoint.load(write("pendulum", tmp_path / "pendulum"))
    swing = JointSine([0.0], [0.8], [4.0], [0.0], np.pi / 2.0)
    (hinge,) = size(robot, Reference(swing, robot), bearings=True, samples=201).bearings
    t = np.linspace(0.0, np.pi / 2.0, 201)
    q, v, a = 0.8 * np.sin(4.0 * t), 3.2 * np.cos(4.0 * t), -12.8 * np.sin(4.0 * t)
    along, across = 2.0 * (9.81 * np.cos(q) + 0.5 * v * v), 2.0 * (9.81 * np.sin(q) + 0.5 * a)
    force = np.hypot(along, across)
    assert hinge.force.value == pytest.approx(force.max(), rel=1e-9)
    assert hinge.radial is not None
    assert hinge.axial is not None
    assert hinge.radial.value == pytest.approx(force.max(), rel=1e-9)
    assert hinge.axial.value == pytest.approx(0.0, abs=1e-9)
    cubes = force**3
    mean = np.sum(0.5 * (cubes[1:] + cubes[:-1])) / 200.0
    assert hinge.mean_force == pytest.approx(mean ** (1.0 / 3.0), rel=1e-9)


@pytest.mark.slow
def test_the_worst_of_several_trajectories() -> None:
    robot = cutjoint.load("fivebar")
    start = np.array(robot.tool(robot.home).position)
    moves = [PointToPoint(start, start + np.array([dx, 0.0, dz]), 0.3) for dx, dz in ((0.05, 0.0), (0.0, -0.05))]
    references = [Reference(one, robot) for one in (*moves, Hold.at_home(robot, 1.0))]
    whole = size(robot, references)
    alone = [size(robot, one) for one in references]
    assert len({one.name for one in whole.cycles}) == 3
    for i, duty in enumerate(whole.worst):
        for name in ("rms_effort", "rms_speed", "given", "back"):
            assert getattr(duty, name) == max(getattr(one.worst[i], name) for one in alone)
        for name in ("effort", "speed", "power", "returned", "holding"):
            worst = getattr(duty, name)
            assert abs(worst.value) == max(abs(getattr(one.worst[i], name).value) for one in alone)
            assert worst.trajectory in {one.name for one in whole.cycles}
    assert whole.balance == max(one.balance for one in alone)


def test_wrong_questions_are_refused() -> None:
    robot, other = cutjoint.load("fivebar"), cutjoint.load("fourbar")
    reference = Reference(trajectory("about-home", other), other)
    with pytest.raises(InputError, match="made for fourbar"):
        size(robot, reference)
    with pytest.raises(InputError, match="no reference"):
        size(robot, [])
    with pytest.raises(InputError, match="samples"):
        size(other, reference, samples=1)
    with pytest.raises(InputError, match="references of size"):
        size(other, [trajectory("about-home", other)])  # type: ignore[list-item]
    paper = cutjoint.published("omega3")
    held = Reference(Hold.at_home(paper, 1.0), paper)
    with pytest.raises(InputError, match="published model"):
        size(paper, held, bearings=True)
    for wrong, told in (
        ({"tool_speed": 0.0}, "tool_speed"),
        ({"samples": 0}, "samples"),
        ({"condition": 1.0}, "condition"),
        ({"turn_speed": 1.0}, "turns nothing"),
    ):
        with pytest.raises(InputError, match=told):
            size_anywhere(robot, **{"tool_speed": 1.0, "tool_acceleration": 1.0, **wrong})
    with pytest.raises(InputError, match="give turn_speed"):
        size_anywhere(cutjoint.load("stewart"), 1.0, 1.0)
