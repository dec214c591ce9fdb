"""What joints do by themselves, as `info`, `check` and `export` tell it."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from kit.physics import with_any_physics
from typer.testing import CliRunner

from cutjoint.cli import app
from cutjoint.description import Bushing, JointPhysics, RobotDescription, load_description
from cutjoint.description.formats import write
from cutjoint.mechanism.physics import NO_PHYSICS

ALL = JointPhysics(2.0, 3.0, 0.0, 4.0, 0.5, 0.01, 10.0, 600.0, 7.0)


@pytest.fixture
def robot() -> RobotDescription:
    """A five-bar in which every joint does something, and whose cut is damped."""
    given = with_any_physics(load_description("fivebar"), np.random.default_rng(0), stops=True)
    joints = [replace(joint, physics=ALL) if joint.name in given.actuators else joint for joint in given.joints]
    cut = replace(given.cuts[0], physics=JointPhysics(damping=0.25))
    return replace(given, joints=tuple(joints), cuts=(cut,))


def run(*arguments: str) -> tuple[str, str]:
    """Standard output and error of a command that must do well."""
    result = CliRunner().invoke(app, arguments, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout, result.stderr


@pytest.mark.parametrize("command", ["info", "check"])
def test_everything_that_acts_is_listed(command: str, robot: RobotDescription, tmp_path: Path) -> None:
    path = str(write(robot, tmp_path)[0])
    more = ["--no-modes"] if command == "info" else []
    text = " ".join(run(command, path, *more)[0].split())
    for part in (
        "damping 2 N m s/rad",
        "friction 3 N m (holds what rests)",
        "spring 4 N m/rad, at rest at 0.5 rad",
        "armature 1 kg m2, rotor 0.01 behind a gear of 10",
        "stops 600 N m/rad with 7 N m s/rad",
        f"{robot.cuts[0].name} (cut) damping 0.25 N m s/rad",
    ):
        assert part in text, part
    records = {one["name"]: one for one in json.loads(run(command, path, "--json", *more)[0])["physics"]}
    moving = {joint.name: joint.physics for joint in robot.joints if joint.physics != NO_PHYSICS}
    assert set(records) == {*moving, robot.cuts[0].name}
    for name, physics in moving.items():
        assert records[name] == {"name": name, "of": "joint", **asdict(physics), "armature": physics.armature}


def test_robots_that_move_freely_have_no_table() -> None:
    assert "joint physics" not in run("info", "fourbar", "--no-modes")[0]
    assert json.loads(run("info", "fourbar", "--no-modes", "--json")[0])["physics"] == []


@pytest.mark.parametrize("form", ["loops", "urdf", "mjcf"])
def test_export_tells_what_others_will_not_find(form: str, robot: RobotDescription, tmp_path: Path) -> None:
    yields = replace(robot.cuts[0], name="yields", physics=NO_PHYSICS, bushing=Bushing(1e5, 10.0, 1e3, 0.125))
    robot = replace(robot, cuts=(*robot.cuts, yields))
    path, out = str(write(robot, tmp_path / "given")[0]), str(tmp_path / "out.xml")
    told = run("export", path, "--to", form, "--out", out if form != "loops" else str(tmp_path / "out"))[1]
    if form == "loops":
        assert told == ""
        return
    for lost in ("stops of joint", f"damping of cut {robot.cuts[0].name}", "bushings of cut yields"):
        assert lost in told, lost
    assert ("springs of joint" in told) == (form == "urdf")
    assert all("only cutjoint reads it back" in line for line in told.splitlines())


def test_a_published_model_does_not_stand_in_for_a_robot_with_friction(tmp_path: Path) -> None:
    given = load_description("cpm")
    rubs = [
        replace(one, physics=JointPhysics(damping=500.0)) if one.name == "limb1_slide" else one for one in given.joints
    ]
    path = str(write(replace(given, joints=tuple(rubs)), tmp_path)[0])
    result = CliRunner().invoke(app, ["simulate", path, "--plant", "paper", "--duration", "0.01"])
    assert "physics of limb1_slide; take --plant chain" in str(result.exception)
