"""What `cutjoint check` and `cutjoint info` say of the task: declared, found at home, not to be told, or impossible."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from kit.quickly import few
from typer.testing import CliRunner

from cutjoint.chain import ClosedChain
from cutjoint.commands import check, info
from cutjoint.description import (
    CutJoint,
    CutType,
    Frame,
    Inertial,
    Joint,
    JointType,
    Link,
    RobotDescription,
    load_description,
)
from cutjoint.description.formats import write
from cutjoint.description.model import TASK_AXES, TASK_NAMES
from cutjoint.description.transforms import placement
from cutjoint.mechanism import task as mechanism_task

Json = dict[str, Any]


def run(module: Any, *arguments: object) -> tuple[int, str]:
    app = typer.Typer()
    app.command()(module.command)
    result = CliRunner().invoke(app, [str(one) for one in arguments])
    return result.exit_code, result.output


def data(module: Any, path: Path) -> Json:
    more = ("--no-modes",) if module is info else ()
    found: Json = json.loads(run(module, path, "--json", *more)[1])
    return found


def arm(seed: int, joints: int) -> RobotDescription:
    """A serial arm with random axes: its tool has `joints` motions, in all six coordinates."""
    rng = np.random.default_rng(seed)
    body = Inertial(1.0, inertia=0.01 * np.eye(3))
    names = ["base", *(f"link{k}" for k in range(joints))]
    made = []
    for k in range(joints):
        axis = rng.normal(size=3)
        at = placement(rng.uniform(-0.3, 0.3, 3), rng.uniform(-1.0, 1.0, 3))
        axis /= np.linalg.norm(axis)
        made.append(Joint(f"turn{k}", JointType.CONTINUOUS, names[k], names[k + 1], at, axis=axis))
    return RobotDescription(
        "arm",
        tuple(Link(name, body if name != "base" else None) for name in names),
        tuple(made),
        actuators=tuple(joint.name for joint in made),
        tool=Frame(names[-1], placement((0.1, 0.2, 0.3))),
    )


def with_a_loop(robot: RobotDescription) -> RobotDescription:
    """The same with a driven wheel beside it that hangs on a second hinge."""
    wheel = Joint("spin", JointType.CONTINUOUS, "base", "wheel", axis=np.array([0.0, 0.0, 1.0]))
    return replace(
        robot,
        links=(*robot.links, Link("wheel", Inertial(1.0, inertia=np.eye(3)))),
        joints=(*robot.joints, wheel),
        actuators=(*robot.actuators, "spin"),
        cuts=(CutJoint("second hinge", CutType.REVOLUTE, Frame("base"), Frame("wheel")),),
    )


def with_task(robot: RobotDescription, path: Path, *task: str) -> Path:
    return write(replace(robot, task=task), path / "loops.toml")[0]


def line_of(path: Path, text: str) -> int:
    return 1 + next(k for k, line in enumerate(path.read_text().splitlines()) if line.startswith(text))


def test_names_of_a_task_are_those_of_the_mechanisms() -> None:
    assert TASK_NAMES == mechanism_task.NAMES
    assert mechanism_task.Axes.__args__ == TASK_AXES


@pytest.mark.parametrize(
    ("name", "task"),
    [
        ("fivebar", "x z"),
        *(
            pytest.param(*one, marks=pytest.mark.slow)
            for one in (("omega3", "x y z"), ("cpm", "x y z"), ("stewart", "x y z rx ry rz"))
        ),
    ],
)
def test_a_task_that_is_found_is_shown_with_its_place(name: str, task: str) -> None:
    chain = ClosedChain(load_description(name))
    home = dict(zip(TASK_NAMES, chain.tool(chain.home).position.tolist(), strict=False))
    for module in (check, info):
        status, text = run(module, name)
        assert status == 0
        assert f"task: {task} (found at home)" in text
        found = data(module, Path(name))["task"]
        assert (found["names"], found["axes"], found["declared"]) == (task.split(), "world", False)
        assert found["problem"] is None
        for one in found["home"]:
            assert one["unit"] == ("rad" if one["name"].startswith("r") else "m")
            assert one["value"] == pytest.approx(home.get(one["name"], 0.0), abs=1e-12)


@pytest.mark.parametrize("seed", few(range(6), 0, 1))
@pytest.mark.parametrize("joints", [4, 5])
def test_a_task_that_cannot_be_told_is_a_warning_that_says_how_to_choose(
    seed: int, joints: int, tmp_path: Path
) -> None:
    robot = with_a_loop(arm(seed, joints)) if seed % 2 else arm(seed, joints)
    path = with_task(robot, tmp_path)
    status, text = run(check, path)
    assert status == 0
    assert "cannot be told" in text
    (problem,) = [one for one in data(check, path)["problems"] if "task" in one["found"]]
    assert problem["severity"] == "warning"
    assert (problem["file"], problem["line"]) == (str(path), line_of(path, "[tool]"))
    assert data(check, path)["task"]["names"] == data(info, path)["task"]["names"] == []
    assert data(info, path)["task"]["problem"] == problem["found"]
    assert run(info, path, "--no-modes")[0] == 0
    # what it proposes is right: declared, it is the task, and there is nothing to say
    proposed = json.loads(re.search(r"task = (\[.*?\])", problem["found"])[1])
    assert len(proposed) == joints
    path = with_task(robot, tmp_path, *reversed(proposed))
    assert run(check, path)[0] == 0
    told = data(check, path)
    assert not [one for one in told["problems"] if "task" in one["found"]]
    assert told["working_modes"] is None or robot.cuts
    assert (told["task"]["names"], told["task"]["declared"]) == (proposed, True)
    assert f"task: {' '.join(proposed)} (declared)" in run(info, path, "--no-modes")[1]


@pytest.mark.parametrize(
    ("name", "task", "why"),
    [
        ("omega3", ("x", "rz"), "does not move along rz"),
        ("fivebar", ("x", "y"), "does not move along y"),
        ("cpm", TASK_NAMES, "does not move along rx, ry, rz"),
        ("fivebar", ("x", "z", "ry"), "of its 3 motions 2 are independent"),
    ],
)
def test_a_task_that_cannot_be_done_is_an_error(name: str, task: tuple[str, ...], why: str, tmp_path: Path) -> None:
    path = with_task(load_description(name), tmp_path, *task)
    status, text = run(check, path)
    assert status == 1
    (problem,) = [one for one in data(check, path)["problems"] if one["severity"] == "error"]
    assert f"the task {' '.join(task)} of" in problem["found"]
    assert why in problem["found"]
    assert "independent motions in" in problem["found"], "it says what there is"
    assert (problem["file"], problem["line"]) == (str(path), line_of(path, "task ="))
    assert "task:" in text


def test_a_robot_without_a_tool_has_no_task(tmp_path: Path) -> None:
    path = with_task(replace(load_description("fourbar"), tool=None), tmp_path)
    for module in (check, info):
        status, text = run(module, path)
        assert status == 0
        assert "task" not in text
        assert data(module, path)["task"] is None
