"""Inverse kinematics of poses against closed forms: random shapes at any mounting and size, chain and compiled.

By pose in each of its forms, by coordinates by name, and by the point where it tells where the robot is.  The actuators
are those of the closed form on the elbows of home, so a posture of another branch is noticed.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from kit.led import Standing
from kit.led_robots import LED, somewhere
from kit.quickly import few
from oracles.closed_form import PanTilt

from cutjoint.mechanism import Mechanism, Pose

ACCURACY = 1e-12
"""Of the robot's size, and radians."""

Rng = np.random.Generator


def forms(robot: Standing, x: np.ndarray) -> list[Any]:
    """All that may be said for the same target."""
    matrix, task = robot.pose(x), robot.chain.task
    quaternion = pin.Quaternion(matrix[:3, :3]).coeffs()
    found: list[Any] = [
        matrix,
        np.concatenate([matrix[:3, 3], quaternion]),
        [*matrix[:3, 3].tolist(), *(-quaternion).tolist()],
        pin.SE3(matrix),
        Pose.of(matrix),
    ]
    named = robot.named(x, task.names, task.axes)
    found += [named, dict(reversed(named.items()))]
    if task.is_of_point:
        found += [matrix[:3, 3], tuple(matrix[:3, 3].tolist())]
    return found


def check(robot: Standing, mechanism: Mechanism, poses: int, rng: Rng) -> None:
    """From home to random poses, each said in the next form."""
    task, units = robot.chain.task, [robot.length if unit == "m" else 1.0 for unit in robot.chain.task.units]
    for index in range(poses):
        x = robot.led.freedoms(rng)
        choices = forms(robot, x)
        at = mechanism.reach(choices[index % len(choices)])
        pose = mechanism.tool(at).pose
        assert robot.missed(at.q, x) < ACCURACY, f"actuators at pose {index}"
        assert robot.off(pose, x) < ACCURACY, f"tool at pose {index}"
        named = robot.named(x, task.names, task.axes).values()
        assert np.abs((mechanism.task.coordinates(pose) - list(named)) / units).max() < ACCURACY


def check_family(name: str, seeds: range, poses: int, folder: Path, compiled: bool = False) -> None:
    for seed in seeds:
        rng = np.random.default_rng([seed, *name.encode()])
        robot = somewhere(name, seed, folder, rng)
        check(robot, robot.chain.compile() if compiled else robot.chain, poses, rng)


@pytest.mark.parametrize("name", LED)
def test_inverse_kinematics(name: str, tmp_path: Path) -> None:
    check_family(name, range(2), 25, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", LED)
def test_inverse_kinematics_of_thousand_poses(name: str, tmp_path: Path) -> None:
    check_family(name, range(2, 12), 100, tmp_path)


@pytest.mark.parametrize("name", few(LED, "stewart", "planar_3rrr"))
def test_compiled(name: str, tmp_path: Path) -> None:
    pytest.importorskip("llvmlite")
    check_family(name, range(2), 25, tmp_path, compiled=True)


@pytest.mark.slow
@pytest.mark.parametrize("name", LED)
def test_thousand_poses_compiled(name: str, tmp_path: Path) -> None:
    pytest.importorskip("llvmlite")
    check_family(name, range(2, 12), 100, tmp_path, compiled=True)


@pytest.mark.parametrize("name", LED)
def test_forward_kinematics_on_the_branch_of_home(name: str, tmp_path: Path) -> None:
    """`close` at the closed form's actuators: the pose that they belong to; and `reach` ends in the same posture."""
    for seed in range(2):
        rng = np.random.default_rng([seed, *name.encode()])
        robot = somewhere(name, seed, tmp_path, rng)
        chain = robot.chain
        for _ in range(5):
            x = robot.led.freedoms(rng)
            at = chain.close(robot.joints(x))
            assert robot.off(chain.tool(at).pose, x) < ACCURACY
            if chain.mobility(at).mobility == chain.n:  # no rods that spin by themselves
                np.testing.assert_allclose(
                    chain.reach(robot.pose(x)).q_full, at.q_full, rtol=0.0, atol=1e-11 * max(robot.size.length, 1.0)
                )


def check_sphere(seeds: range, points: int, folder: Path) -> None:
    for seed in seeds:
        rng = np.random.default_rng([seed, 15])
        robot = somewhere("pan_tilt", seed, folder, rng)
        form, chain = robot.led.form, robot.chain
        assert isinstance(form, PanTilt)
        for _ in range(points):
            away = rng.normal(size=3)
            point = form.centre - form.at(form.start)[0] + form.arm * away / np.linalg.norm(away)
            at = chain.reach(robot.size.place(point))
            assert np.abs(chain.tool(at).position - robot.size.place(point)).max() < ACCURACY * robot.length


def test_all_over_a_sphere(tmp_path: Path) -> None:
    """Two motors on a curved surface reach every point of it."""
    check_sphere(range(2), 10, tmp_path)


@pytest.mark.slow
def test_all_over_many_spheres(tmp_path: Path) -> None:
    check_sphere(range(2, 6), 100, tmp_path)
