"""Targets that are none, or that no posture has: one clear error each, over all robots, and nothing moves."""

from __future__ import annotations

import warnings
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.blueprint import random_mounting, random_rotation, turn
from kit.led import Standing, stand
from kit.led_robots import LED, drawn
from kit.mechanisms import MECHANISMS
from kit.quickly import few
from kit.shipped import DETERMINED
from kit.sized import Size

from cutjoint import Mechanism, Posture, compiled, robots
from cutjoint.errors import CutjointError, InputError, LimitError, SingularError, UnreachableError

X, Y, Z = np.eye(3)
NAN, INF = float("nan"), float("inf")

Array = np.ndarray

OFF: dict[str, tuple[str, ...]] = {
    "planar_3rrr": ("z", "rx", "ry"),
    "fivebar": ("z", "rx", "ry", "rz"),
    "delta": ("rx", "ry", "rz"),
    "schoenflies": ("rx", "ry"),
    "tripod": ("x", "y", "rz"),
    "spherical_3rrr": ("x", "y", "z"),
    "serial_wrist": ("x", "y", "z"),
    "pan_tilt": ("rx", "ry", "rz"),
}
"""Motions, in the axes of the base, that take a pose off what the tool can have."""


@cache
def model(name: str) -> Mechanism:
    if name.endswith(" compiled"):
        return compiled(model(name.removesuffix(" compiled")))
    if name.endswith(" of the paper"):
        return robots.published(name.removesuffix(" of the paper"))
    return robots.load(name)


COMPILED = ("stewart compiled", "fivebar compiled", "omega3 compiled", "omega3 of the paper compiled")
SHIPPED = (*DETERMINED, *(f"{name} of the paper" for name in robots.PUBLISHED), *COMPILED)


def led(name: str, folder: Path) -> Standing:
    rng = np.random.default_rng([2, *name.encode()])
    return stand(drawn(name, 2), folder, Size(rotation=random_rotation(rng), offset=rng.normal(size=3)))


def refusal(mechanism: Mechanism, target: Any, expected: Any = InputError, **how: Any) -> CutjointError:
    """The error of `reach`; numpy may not even warn on the way to it."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(CutjointError) as caught:
            mechanism.reach(target, **how)
    assert isinstance(caught.value, expected), f"{target!r}: {type(caught.value).__name__}: {caught.value}"
    assert caught.value.__cause__ is None or isinstance(caught.value, InputError)
    words = str(caught.value)
    assert 20 < len(words) < 900
    assert "\n" not in words.strip()
    return caught.value


def home_of(mechanism: Mechanism) -> Array:
    return mechanism.tool(mechanism.home).pose.matrix


def changed(matrix: Array, at: Any, value: float) -> Array:
    found = np.array(matrix)
    found[at] = value
    return found


def seven(matrix: Array, quaternion: Any = (0.0, 0.0, 0.0, 1.0)) -> Array:
    return np.array([*matrix[:3, 3], *quaternion])


def no_targets(mechanism: Mechanism) -> list[Any]:
    """What is no target of any robot."""
    home = home_of(mechanism)
    stretched, sheared, mirrored = home.copy(), home.copy(), home.copy()
    stretched[:3, :3] *= 2.0
    sheared[:3, 0] += 0.01 * sheared[:3, 1]
    mirrored[:3, 2] *= -1.0
    named = dict(
        zip(mechanism.task.names, mechanism.task.coordinates(mechanism.tool(mechanism.home).pose), strict=True)
    )
    first = mechanism.task.names[0]
    return [
        None, "home", 1.0, NAN, [], {}, object(), ["a", "b", "c"], [None] * 3, [[0.0, 1.0], [2.0]], np.zeros(0),
        [0.0, 0.0], np.zeros(4), np.zeros(6), np.zeros(8), np.zeros((1, 3)), np.eye(3), np.zeros((3, 4)), np.eye(5),
        [NAN, 0.0, 0.0], [0.0, INF, 0.0], np.array([0.0, 0.0, -INF]), np.array([1j, 0.0, 0.0]),
        changed(home, (0, 3), NAN), changed(home, (1, 1), NAN), changed(home, (2, 3), INF), changed(home, (0, 0), INF),
        changed(home, (3, 3), 2.0), changed(home, (3, 0), 1.0), changed(home, (3, 1), NAN),
        stretched, sheared, mirrored, np.zeros((4, 4)),
        seven(home, np.zeros(4)), seven(home, (0.0, 0.0, 0.0, 2.0)), seven(home, (1.0, 1.0, 0.0, 0.0)),
        seven(home, (NAN, 0.0, 0.0, 1.0)), changed(seven(home), 1, INF),
        {**named, first: NAN}, {**named, first: INF}, {**named, first: "far"}, {**named, first: None},
        {**named, first: [1.0, 2.0]}, {**named, "roll": 0.0}, {**named, first.upper(): 0.0}, {**named, 3: 0.0},
        {"a": 1.0, "b": 2.0},
    ]  # fmt: skip


def check_refused(mechanism: Mechanism) -> None:
    before = np.array(mechanism.home.q_full)
    for target in no_targets(mechanism):
        refusal(mechanism, target)
        if not isinstance(target, dict):
            refusal(mechanism, target, free=True)
    task = mechanism.task
    named = dict(zip(task.names, task.coordinates(mechanism.tool(mechanism.home).pose), strict=True))
    for name in task.names:
        rest = {one: value for one, value in named.items() if one != name}
        assert name in str(refusal(mechanism, rest))
    for name in ("x", "y", "z", "rx", "ry", "rz"):
        if name not in task.names:
            assert name in str(refusal(mechanism, {**named, name: 0.1}))
    if not task.is_of_point:
        words = str(refusal(mechanism, home_of(mechanism)[:3, 3]))
        assert "free=True" in words
        assert str(task) in words
    np.testing.assert_array_equal(mechanism.home.q_full, before)


@pytest.mark.parametrize("name", SHIPPED)
def test_what_is_no_target(name: str) -> None:
    check_refused(model(name))


@pytest.mark.parametrize("name", LED)
def test_what_is_no_target_of_a_led_robot(name: str, tmp_path: Path) -> None:
    check_refused(led(name, tmp_path).chain)


def moved(robot: Standing, name: str, amount: float, x: Array) -> Array:
    """The pose at `x` moved off by this much along or about an axis of the base."""
    pose, axis = robot.pose(x), robot.size.rotation[:, "xyz".index(name[-1])]
    if name.startswith("r"):
        pose[:3, :3] = turn(axis, amount) @ pose[:3, :3]
    else:
        pose[:3, 3] += amount * robot.length * axis
    return pose


@pytest.mark.parametrize("name", few(OFF, "delta", "tripod", "planar_3rrr"))
def test_poses_that_the_tool_cannot_have(name: str, tmp_path: Path) -> None:
    """By a tenth or by a thousandth, at home and elsewhere; the same pose is right where it is not off."""
    robot, rng = led(name, tmp_path), np.random.default_rng(3)
    chain = robot.chain
    for x in (np.zeros(len(robot.led.spread)), robot.led.freedoms(rng, 0.5)):
        chain.reach(robot.pose(x))
        for motion in OFF[name]:
            for amount in (0.1, -0.1, 1e-3, 1e-5):
                error = refusal(chain, moved(robot, motion, amount, x), (UnreachableError, SingularError))
                assert not isinstance(error, LimitError)
                assert robot.led.plan.name in str(error)


@pytest.mark.parametrize("name", [name for name in SHIPPED if name.startswith(("cpm", "omega3"))])
def test_a_turned_pose_for_a_robot_that_never_turns(name: str) -> None:
    mechanism = model(name)
    home = home_of(mechanism)
    for axis in (X, Y, Z):
        for angle in (1e-5, 0.1, 3.0):
            turned = home.copy()
            turned[:3, :3] = turn(axis, angle) @ home[:3, :3]
            refusal(mechanism, turned, UnreachableError)
            refusal(mechanism, seven(home, [*(axis * np.sin(angle / 2)), np.cos(angle / 2)]), UnreachableError)
            at = mechanism.reach(turned, free=True)
            np.testing.assert_allclose(mechanism.tool(at).position, home[:3, 3], rtol=0.0, atol=1e-12)


def too_far(mechanism: Mechanism, size: float, far: float) -> list[Array]:
    found = []
    for direction in (np.array([0.6, 0.64, 0.48]), np.array([-0.64, 0.48, -0.6])):
        pose = home_of(mechanism)
        pose[:3, 3] += far * size * direction
        found.append(pose)
    return found


@pytest.mark.parametrize("far", few([30.0, 1e6, 1e150, 1e300], 1e150, 1e300))
@pytest.mark.parametrize("name", SHIPPED)
def test_out_of_reach(name: str, far: float) -> None:
    mechanism = model(name)
    for pose in too_far(mechanism, robots.load(name.split()[0]).length, far):
        for target in (pose, pose[:3, 3]) if mechanism.task.is_of_point else (pose,):
            refusal(mechanism, target, (UnreachableError, SingularError, *([InputError] if far > 1e100 else [])))


@pytest.mark.parametrize("name", LED)
def test_out_of_reach_of_a_led_robot(name: str, tmp_path: Path) -> None:
    robot = led(name, tmp_path)
    for far in (30.0, 1e200)[name == "stewart" :]:  # its legs may be of any length
        for pose in too_far(robot.chain, robot.length, far):
            refusal(robot.chain, pose, (UnreachableError, SingularError, *([InputError] if far > 1e100 else [])))


@pytest.mark.parametrize("name", LED)
def test_rotations_that_are_rounded(name: str, tmp_path: Path) -> None:
    """Seven digits of a rotation are one: the nearest is taken."""
    robot, rng = led(name, tmp_path), np.random.default_rng(4)
    x = robot.led.freedoms(rng, 0.5)
    rounded = robot.pose(x)
    rounded[:3, :3] = np.round(rounded[:3, :3], 8)
    at = robot.chain.reach(rounded, free=True)
    assert robot.missed(at.q, x) < 1e-6


@pytest.mark.parametrize("name", LED)
def test_what_is_not_said_is_free_if_that_is_said(name: str, tmp_path: Path) -> None:
    """A point alone, and single coordinates, are met."""
    robot, rng = led(name, tmp_path), np.random.default_rng(5)
    chain = robot.chain
    x = robot.led.freedoms(rng, 0.3)
    point = robot.pose(x)[:3, 3]
    if set(robot.led.task) & set("xyz"):
        at = chain.reach(point, free=True) if set("xyz") <= set(robot.led.task) or name == "fivebar" else chain.home
        if at is not chain.home:
            assert np.abs(chain.tool(at).position - point).max() < 1e-12 * robot.length
    named = robot.named(x, chain.task.names, chain.task.axes)
    for one, value in named.items():
        at = chain.reach({one: value}, free=True)
        found = dict(zip(chain.task.names, chain.task.coordinates(chain.tool(at).pose), strict=True))
        if not one.startswith("r"):
            assert abs(found[one] - value) < 1e-12


def test_another_robots_posture() -> None:
    one, other = model("stewart"), model("fivebar")
    with pytest.raises(InputError):
        one.reach(home_of(one), near=other.home)
    with pytest.raises(InputError):
        one.reach(home_of(one), near=Posture(np.zeros(3), np.zeros(3)))


def test_nothing_to_reach() -> None:
    for name in ("stewart", "omega3"):
        mechanism = model(name)
        assert "no coordinate is given" in str(refusal(mechanism, {}))
        assert "no coordinate is given" in str(refusal(mechanism, {}, free=True))


def test_a_pose_fixes_a_tool_whose_task_cannot_be_told(tmp_path: Path) -> None:
    """A planar robot that lies askew, its tool's axes too: no three rows of six are plainly its task."""
    rng = np.random.default_rng(0)
    MECHANISMS["planar_3rrr"](rng).plan.write(tmp_path, random_mounting(rng))
    chain = robots.load(tmp_path)
    with pytest.raises(InputError, match=r"task = \["):
        _ = chain.task
    at = chain.close(chain.home.q + 0.1)
    found = chain.reach(chain.tool(at).pose)
    np.testing.assert_allclose(found.q, at.q, atol=1e-9)
    with pytest.raises(InputError, match=r"task = \["):
        chain.reach(chain.tool(at).position)
    with pytest.raises(UnreachableError):
        chain.reach(chain.tool(at).pose.moved(0.1 * chain.length * chain.tool(at).rotation[:, 0]), limits="ignore")
