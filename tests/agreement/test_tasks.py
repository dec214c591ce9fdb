"""Which task a robot has where nothing is said: what its tool does, at mountings where that has one answer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kit.blueprint import random_rotation, turn
from kit.built import built
from kit.led import stand
from kit.led_robots import LED, drawn
from kit.mechanisms import MECHANISMS
from kit.shipped import SHIPPED
from kit.sized import Size

from cutjoint import robots
from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError

AXES = ("x", "y", "z")
SHIPPED_TASKS = {
    "cpm": "x y z",
    "cpm_rotary": "x y z",
    "fivebar": "x z",
    "omega3": "x y z",
    "redundant": "x y",
    "stewart": "x y z rx ry rz",
    "underactuated": "x ry",
}
"""Those that have one answer; the four-bar's coupler point goes along a curve of its plane."""

QUARTERS = [turn(axis, np.pi / 2 * k).round() for axis in np.eye(3) for k in range(4)]
"""Mountings that carry axes of the world to axes of the world."""


def carried(names: tuple[str, ...], rotation: np.ndarray) -> tuple[str, ...]:
    """Names of the axes of a base, as axes of the world at a mounting by quarter turns."""
    of = {AXES[k]: AXES[int(np.abs(rotation[:, k]).argmax())] for k in range(3)}
    found = {of[name] if name in of else "r" + of[name[1]] for name in names}
    return tuple(name for name in ("x", "y", "z", "rx", "ry", "rz") if name in found)


def turns_with_others(name: str) -> bool:
    """Whether the task is the same in any axes."""
    return name in ("stewart", "delta", "spherical_3rrr", "serial_wrist", "pan_tilt")


@pytest.mark.parametrize("name", SHIPPED_TASKS)
def test_shipped(name: str) -> None:
    task = robots.load(name).task
    assert " ".join(task.names) == SHIPPED_TASKS[name]
    assert task.axes == "world"


def test_all_shipped_have_one() -> None:
    for name in SHIPPED:
        assert robots.load(name).task.names


@pytest.mark.parametrize("name", LED)
def test_in_the_axes_of_the_world(name: str, tmp_path: Path) -> None:
    """The base along the world's axes, however the tool's frame is turned and wherever and how large it is."""
    for seed in range(3):
        rng, led = np.random.default_rng(seed), drawn(name, seed)
        size = Size(length=10.0 ** rng.uniform(-3.0, 3.0), offset=rng.normal(size=3))
        for axes in (None, random_rotation(rng)):
            task = stand(led, tmp_path, size, axes).chain.task
            assert (task.names, task.axes) == (led.task, "world")


@pytest.mark.parametrize("name", LED)
def test_by_quarter_turns(name: str, tmp_path: Path) -> None:
    led, rng = drawn(name, 0), np.random.default_rng(4)
    for index in rng.choice(len(QUARTERS), 4, replace=False):
        task = stand(led, tmp_path, Size(rotation=QUARTERS[index]), random_rotation(rng)).chain.task
        assert (task.names, task.axes) == (carried(led.task, QUARTERS[index]), "world")


@pytest.mark.parametrize("name", LED)
def test_tilted_in_the_axes_of_the_tool(name: str, tmp_path: Path) -> None:
    for seed in range(3):
        rng, led = np.random.default_rng(seed), drawn(name, seed)
        task = stand(led, tmp_path, Size(rotation=random_rotation(rng))).chain.task
        expected = "world" if turns_with_others(name) else "tool"
        assert (task.names, task.axes) == (led.task, expected)


@pytest.mark.parametrize("name", [name for name in LED if not turns_with_others(name)])
def test_tilted_with_a_turned_tool(name: str, tmp_path: Path) -> None:
    """Neither the world's nor the tool's axes say what is led: it must be said, and may be."""
    rng, led = np.random.default_rng(6), drawn(name, 0)
    robot = stand(led, tmp_path, Size(rotation=random_rotation(rng)), random_rotation(rng))
    if name == "fivebar":  # the point tells where it is, in any axes
        assert robot.chain.task.names == ("x", "y", "z")
        return
    with pytest.raises(InputError, match=r"cannot be told.*task = \[") as caught:
        _ = robot.chain.task
    words = str(caught.value)
    assert name in words
    assert f"{robot.chain.n} independent motions" in words


@pytest.mark.parametrize("seed", range(4))
def test_a_tripod_is_not_led_by_its_parasitic_motions(seed: int, tmp_path: Path) -> None:
    """Its point moves aside a little wherever it tilts, which is no way to lead it."""
    chain, _ = built(MECHANISMS["prs_3"](np.random.default_rng(seed)).plan, tmp_path)
    assert chain.task.names == ("z", "rx", "ry")


def test_a_singular_home_does_not_count(tmp_path: Path) -> None:
    """Where branches meet at home, the task is that of the postures around it."""
    chain, _ = built(MECHANISMS["upu_3_equal"](np.random.default_rng(0)).plan, tmp_path)
    assert chain.task.names == ("x", "y", "z")


@pytest.mark.parametrize("name", LED)
def test_declared(name: str, tmp_path: Path) -> None:
    """What is declared holds, in the order of x y z rx ry rz."""
    led, rng = drawn(name, 1), np.random.default_rng(7)
    robot = stand(led, tmp_path, Size(rotation=random_rotation(rng)), task=led.task, task_axes="tool")
    task = robot.chain.task
    assert (task.names, task.axes) == (led.task, "tool")
    for _ in range(5):
        x = led.freedoms(rng)
        at = robot.chain.reach(robot.named(x, task.names, "tool"))
        assert robot.missed(at.q, x) < 1e-12
        np.testing.assert_allclose(
            task.coordinates(robot.chain.tool(at).pose), list(robot.named(x, task.names, "tool").values()), atol=1e-12
        )


@pytest.mark.parametrize(
    ("name", "task"),
    [
        ("planar_3rrr", ("x", "y", "z")),
        ("planar_3rrr", ("x", "rz", "rx")),
        ("delta", ("x", "y", "rz")),
        ("fivebar", ("x", "z")),
        ("schoenflies", ("x", "y", "z", "rx")),
        ("spherical_3rrr", ("x", "rx", "ry")),
        ("tripod", ("z", "rx", "ry", "rz")),
        ("delta", ("x", "y", "z", "rx")),
    ],
)
def test_declared_that_cannot_be_done(name: str, task: tuple[str, ...], tmp_path: Path) -> None:
    robot = stand(drawn(name, 0), tmp_path, task=task)
    with pytest.raises(InputError, match=r"cannot be done"):
        _ = ClosedChain(robot.description).task


def test_one_row_of_two_motors(tmp_path: Path) -> None:
    """Fewer rows than motors: those that are led are met, and the rest moves least."""
    robot = stand(drawn("planar_3rrr", 0), tmp_path, task=("x", "y"))
    chain = robot.chain
    at = chain.reach({"x": robot.pose(np.zeros(3))[0, 3] + 0.02, "y": robot.pose(np.zeros(3))[1, 3]})
    found = chain.task.coordinates(chain.tool(at).pose)
    np.testing.assert_allclose(found, robot.pose(np.array([0.02, 0.0, 0.0]))[:2, 3], atol=1e-12)
