"""Closed ways of the tool, gone round many times in small steps: the robot comes back to where it began.

Each way is a random closed curve in the robot's freedoms, and every step starts from the posture before it.  After
every lap the posture is that of the start in all joints: neither place nor orientation nor passive joints drift.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.led import Led, Standing
from kit.led_robots import LED, somewhere
from kit.quickly import few
from oracles.closed_form import SerialWrist
from oracles.connections import turn

from cutjoint.mechanism import Mechanism

ACCURACY = 1e-12
"""Of the robot's size, and radians."""

LAPS = 10

Array = np.ndarray
Rng = np.random.Generator


def closed_way(led: Led, rng: Rng, steps: int) -> Array:
    """A random closed curve in the freedoms, shape (steps, freedoms); it begins anywhere and is regular."""
    t = np.linspace(0.0, 2.0 * np.pi, steps, endpoint=False)[:, None]
    for _ in range(200):
        size = len(led.spread)
        way = led.spread * rng.uniform(-0.3, 0.3, size)
        for k in (1, 2):
            way = way + led.spread * rng.uniform(-0.35, 0.35, size) / k * np.sin(k * t + rng.uniform(0.0, 6.3, size))
        if all(map(led.is_regular, way[::4])):
            return way
    raise AssertionError("no regular way")


def led_by(robot: Standing, index: int) -> Callable[[Array], Any]:
    """How a way is told: by poses, by names, or by points where they are enough; in turns."""
    task = robot.chain.task
    ways: list[Callable[[Array], Any]] = [robot.pose, lambda x: robot.named(x, task.names, task.axes)]
    if task.is_of_point:
        ways.append(lambda x: robot.pose(x)[:3, 3])
    return ways[index % len(ways)]


def go_round(robot: Standing, mechanism: Mechanism, index: int, rng: Rng, steps: int) -> None:
    way, target = closed_way(robot.led, rng, steps), led_by(robot, index)
    whole = robot.chain.mobility().mobility == robot.chain.n  # else rods spin by themselves, which nothing leads
    start = last = mechanism.reach(target(way[0]))
    assert robot.missed(start.q, way[0]) < ACCURACY
    units = 1.0 if robot.size.length < 1.0 else robot.size.length
    for lap in range(LAPS):
        for x in [*way[1:], way[0]]:
            last = mechanism.reach(target(x), near=last)
        assert robot.missed(last.q, way[0]) < ACCURACY, f"lap {lap}"
        assert robot.off(mechanism.tool(last).pose, way[0]) < ACCURACY, f"lap {lap}"
        if whole:
            assert np.abs(last.q_full - start.q_full).max() < ACCURACY * units, f"lap {lap}"


def check(name: str, seeds: range, ways: int, steps: int, folder: Path, compiled: bool = False) -> None:
    for seed in seeds:
        rng = np.random.default_rng([seed, 5, *name.encode()])
        robot = somewhere(name, seed, folder, rng)
        for index in range(ways):
            go_round(robot, robot.chain.compile() if compiled else robot.chain, index, rng, steps)


@pytest.mark.parametrize("name", LED)
def test_ten_laps(name: str, tmp_path: Path) -> None:
    check(name, range(2), 1, 12, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", LED)
def test_ten_laps_of_hundred_ways(name: str, tmp_path: Path) -> None:
    check(name, range(2, 12), 10, 12, tmp_path)


def about_the_first_hinge(robot: Standing, angle: float) -> Array:
    """The pose of a serial wrist at home, turned about its first axis, which the base carries, shape (4, 4)."""
    assert isinstance(robot.led.form, SerialWrist)
    pose = robot.pose(np.zeros(3))
    pose[:3, :3] = turn(robot.size.rotation @ robot.led.form.axes[:, 2], angle) @ pose[:3, :3]
    return pose


def test_whole_turns(tmp_path: Path) -> None:
    """A tool that goes round and round winds up its first hinge, and is where it was."""
    for seed in range(2):
        rng = np.random.default_rng(seed)
        robot = somewhere("serial_wrist", seed, tmp_path, rng)
        start = last = robot.chain.home
        for k in range(1, 12 * LAPS + 1):
            last = robot.chain.reach(about_the_first_hinge(robot, 2.0 * np.pi * k / 12), near=last)
        np.testing.assert_allclose(last.q - start.q, [2.0 * np.pi * LAPS, 0.0, 0.0], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("angle", [np.pi, -np.pi, np.pi - 1e-9, 1e-9 - np.pi, 3.0, -3.0])
def test_half_a_turn_at_once(angle: float, tmp_path: Path) -> None:
    """Either way round, also from half a turn away from home and back."""
    robot = somewhere("serial_wrist", 1, tmp_path, np.random.default_rng(1))
    chain, wanted = robot.chain, about_the_first_hinge(robot, angle)
    there = chain.reach(wanted)
    assert np.abs(chain.tool(there).rotation - wanted[:3, :3]).max() < ACCURACY
    turned = there.q[0] - chain.home.q[0]
    assert abs(turned) == pytest.approx(abs(angle), abs=1e-12)
    assert abs(angle) > 3.14 or turned * angle > 0.0
    back = chain.reach(robot.pose(np.zeros(3)), near=there)
    assert np.abs(chain.tool(back).rotation - chain.tool(chain.home).rotation).max() < ACCURACY


@pytest.mark.parametrize("name", few(LED, "stewart", "tripod"))
def test_compiled(name: str, tmp_path: Path) -> None:
    pytest.importorskip("llvmlite")
    check(name, range(2), 1, 20, tmp_path, compiled=True)


@pytest.mark.slow
@pytest.mark.parametrize("name", LED)
def test_hundred_ways_compiled(name: str, tmp_path: Path) -> None:
    pytest.importorskip("llvmlite")
    check(name, range(2, 12), 10, 20, tmp_path, compiled=True)
