"""Orientations in a result: continuous, and in agreement with angular velocities; and robots that are led by pose."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.led_robots import LED, somewhere

import cutjoint
from cutjoint.control import ComputedTorque
from cutjoint.errors import InputError
from cutjoint.mechanism.rotations import matrix_of, vector_of
from cutjoint.motion import Hold, PoseMove, Reference
from cutjoint.simulation import Adaptive, ConstrainedPlant, ReducedPlant, RungeKutta4, load, run, save
from cutjoint.simulation.observables import gathered

PLANTS = {"reduced": ReducedPlant, "constrained": ConstrainedPlant}
STILL = ("delta", "cpm", "omega3")


@pytest.fixture(scope="module", params=[name for name in LED if name != "delta"])
def robot(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder: Path = tmp_path_factory.mktemp(request.param)
    return somewhere(request.param, 0, folder, np.random.default_rng(2)).chain


@pytest.mark.parametrize("plant", PLANTS)
def test_angular_velocity_is_how_the_orientation_changes(robot: Any, plant: str) -> None:
    slides = np.array([one.kind == "translation" for one in robot.actuators])
    push = 0.5 * np.where(slides, robot.length, 1.0)
    h = 1e-4
    found = run(PLANTS[plant](robot), duration=6e-3, every=h, integrator=Adaptive(1e-11, 1e-13), start_velocity=push)
    if "orientation" not in found.columns:
        assert robot.task.is_of_point
        return
    assert np.allclose(np.linalg.norm(found.orientation, axis=1), 1.0, rtol=0.0, atol=1e-12)
    for i in range(1, len(found) - 1, 7):
        before, after = matrix_of(found.orientation[i - 1]), matrix_of(found.orientation[i + 1])
        rate = vector_of(after @ before.T) / (2.0 * h)
        assert np.allclose(rate, found.angular_velocity[i], rtol=0.0, atol=1e-4 * max(1.0, np.abs(rate).max()))
    posture = robot.close(found.q[-1], robot.home, limits="ignore")
    assert np.allclose(matrix_of(found.orientation[-1]), robot.tool(posture).rotation, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("name", ["cpm", "omega3"])
@pytest.mark.parametrize("plant", PLANTS)
def test_a_tool_that_never_turns_has_no_orientation(name: str, plant: str) -> None:
    robot = cutjoint.load(name)
    found = run(PLANTS[plant](robot), duration=1e-3, every=1e-3)
    assert not {"orientation", "angular_velocity", "orientation_error"} & set(found.columns)
    reference = Reference(Hold.at_home(robot, 1.0), robot)
    led = run(PLANTS[plant](robot), ComputedTorque(robot, 400.0, 40.0), reference, duration=1e-3)
    with pytest.raises(InputError, match="cannot turn"):
        led.worst_turn()


@pytest.mark.slow
@pytest.mark.parametrize("plant", PLANTS)
def test_a_robot_led_by_pose_is_tracked(plant: str, tmp_path: Path) -> None:
    """Computed torque on a matched plant, from rest on the way of a pose to another one: to 1e-9 all along."""
    robot = cutjoint.load("stewart")
    move = PoseMove.from_home(robot, 0.02, -0.01, 0.03, 4.0, -3.0, 8.0, 0.4)
    found = run(
        PLANTS[plant](robot),
        ComputedTorque.critically_damped(robot, 100.0),
        Reference(move, robot),
        integrator=Adaptive(1e-11, 1e-13),
        every=0.05,
    )
    assert found.worst_error() < 1e-9
    assert found.worst_turn() < 1e-9
    assert np.abs(found.orientation - found.desired_orientation).max() < 1e-9
    assert found.energy_drift() < 1e-9
    again = load(save(found, tmp_path / "run.npz"))
    assert np.array_equal(again.orientation_error, found.orientation_error)
    heading = save(found, tmp_path / "run.csv").read_text().splitlines()[0].split(",")
    assert {"orientation w [1]", "desired orientation x [1]", "angular velocity z [rad/s]"} <= set(heading)
    assert "orientation error [rad]" in heading


def test_a_start_beside_the_way_shows_in_the_orientation_and_decays() -> None:
    robot = cutjoint.load("stewart")
    away = robot.reach(robot.tool(robot.home).pose.moved(turn=[0.05, -0.02, 0.1]))
    reference = Reference(Hold.at_home(robot, 0.3), robot)
    law = ComputedTorque.critically_damped(robot, 100.0)
    found = run(ReducedPlant(robot), law, reference, start=away, integrator=RungeKutta4(2e-3))
    assert found.orientation_error[0] == pytest.approx(np.linalg.norm([0.05, -0.02, 0.1]), rel=1e-9)
    assert found.worst_turn(after=0.29) < 1e-4
    assert not found.desired_v.any()


def test_quaternions_do_not_jump() -> None:
    """Several turns about one axis, whose quaternions of w >= 0 jump twice a turn; the desired one starts beside."""
    angle = np.linspace(0.0, 20.0, 400)
    quaternion = np.column_stack([np.sin(angle / 2), 0 * angle, 0 * angle, np.cos(angle / 2)])
    plain = quaternion * np.where(quaternion[:, 3:] < 0.0, -1.0, 1.0)
    found = gathered({"orientation": list(plain), "desired_orientation": list(-plain)})
    for column in found.values():
        assert np.abs(np.diff(column, axis=0)).max() < 0.06
        assert np.allclose(column, quaternion, rtol=0.0, atol=1e-15)
