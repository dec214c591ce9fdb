"""What formats have trouble with, names above all, is written so that it comes back, or refused by name."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.described import FILES, differences

from cutjoint.description import (
    Coupling,
    CutJoint,
    CutType,
    Frame,
    Home,
    Inertial,
    Joint,
    JointType,
    Limits,
    Link,
    RobotDescription,
    Shape,
    read_checked,
)
from cutjoint.description.formats import WRITERS, left_out, unsaid, write
from cutjoint.errors import InputError

Name = Callable[[str, int], str]
OTHERS = ["x", "x/1", "x/2", "x/a", "x#1", "x#2", "x/1/1", "x/2/2"]

NAMES: dict[str, Name] = {
    "the same for all kinds": lambda _, n: f"n{n}",
    "like parts of others": lambda _, n: OTHERS[n],
    "markup": lambda kind, n: f"<{kind}>&\"'{n}",
    "lines and slashes": lambda kind, n: f"{kind}\n\t\\{n}",
    "any alphabet": lambda kind, n: f"ü{kind}日本\U0001f600{n}",
    "keys of TOML": lambda kind, n: f"{kind}.{n} = []",
    "long": lambda kind, n: f"{kind}{n}" + 300 * "x",
    "numbers": lambda _, n: f"-{n}",
}
REFUSED: dict[str, tuple[Name, str]] = {
    "control characters": (lambda kind, n: f"{kind}\x01{n}", "no text"),
    "half a character": (lambda kind, n: f"{kind}\udc80{n}", "no text"),
    "blanks": (lambda kind, n: f" {kind}{n}", "blanks"),
    "empty": (lambda kind, n: f"{kind}{n}" if n else "", "empty"),
}


def named(name: Name) -> RobotDescription:
    """A robot with cuts of which MJCF can say some, gears, and shapes, all called as `name` says."""
    body, shape = Inertial(1.0, np.zeros(3), 0.01 * np.eye(3)), Shape("box", (0.1, 0.2, 0.3))
    links = [Link(name("link", n), body, (replace(shape, name=name("shape", n // 2)),)) for n in range(8)]
    links[0] = replace(links[0], inertial=None)
    joints = [
        Joint(name("joint", n), JointType.CONTINUOUS, links[n // 2].name, links[n + 1].name) for n in range(7)
    ]  # fmt: skip
    kinds = [CutType.FIXED, CutType.REVOLUTE, CutType.SPHERICAL, CutType.UNIVERSAL, CutType.DISTANCE, CutType.FIXED]
    cuts = [
        CutJoint(name("cut", n), kind, Frame(links[n].name), Frame(links[n + 2].name), length=float(kind.has_length))
        for n, kind in enumerate(kinds)
    ]
    gears = [Coupling.geared(name("coupling", n), joints[n + 1].name, joints[0].name, 2.0) for n in range(2, 5)]
    homes = (Home(name("home", 1), {joints[0].name: 0.1}, {joints[5].name: 0.2}),)
    return RobotDescription(
        name("robot", 1), tuple(links), tuple(joints), tuple(cuts), tuple(gears), (joints[0].name,), homes=homes
    )


@pytest.mark.parametrize("form", ["loops", "urdf", pytest.param("mjcf", marks=pytest.mark.slow)])
@pytest.mark.parametrize("case", NAMES)
def test_names_come_back(case: str, form: str, tmp_path: Path) -> None:
    robot = named(NAMES[case])
    reading = read_checked(write(robot, tmp_path / FILES[form], to=form)[0])
    assert reading.description is not None, reading.problems
    assert differences(robot, reading.description) == []


def test_a_cut_called_like_a_coupling_is_not_lost_in_mjcf(tmp_path: Path) -> None:
    robot = named(NAMES["like parts of others"])
    reading = read_checked(write(robot, tmp_path / "robot.xml", to="mjcf")[0])
    assert reading.description is not None, reading.problems
    assert {cut.name: cut.type for cut in reading.description.cuts} == {cut.name: cut.type for cut in robot.cuts}
    assert {one.name for one in reading.description.couplings} == {one.name for one in robot.couplings}


@pytest.mark.parametrize("form", WRITERS)
@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_written_is_refused_by_name(case: str, form: str, tmp_path: Path) -> None:
    name, why = REFUSED[case]
    with pytest.raises(InputError, match=why):
        write(named(name), tmp_path / FILES[form], to=form)
    assert not any(tmp_path.iterdir())


def test_xacro_and_own_names_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="xacro"):
        write(named(lambda kind, n: f"${{{kind}}}{n}"), tmp_path)
    with pytest.raises(InputError, match="stands for parts"):
        write(named(lambda kind, n: f"cutjoint:{kind}{n}"), tmp_path / "robot.xml", to="mjcf")


def test_shapes_that_mujoco_cannot_draw_are_left_out_and_told(tmp_path: Path) -> None:
    robot = named(NAMES["numbers"])
    (tmp_path / "part.dae").write_bytes(b"<COLLADA/>")
    flat, mesh = Shape("box", (0.1, 0.1, 0.0)), Shape("mesh", (1.0, 1.0, 1.0), mesh=tmp_path / "part.dae")
    robot = replace(robot, links=(replace(robot.links[0], visuals=(flat, mesh)), *robot.links[1:]))
    assert left_out(robot, "loops") == left_out(robot, "urdf") == ()
    (told,) = left_out(robot, "mjcf")
    assert "part.dae" in told
    assert "box of size 0" in told
    reading = read_checked(write(robot, tmp_path / "robot.xml", to="mjcf")[0])
    assert reading.description is not None, reading.problems
    assert reading.description.links[0].visuals == ()


def test_the_colour_of_a_collision_shape_comes_back(tmp_path: Path) -> None:
    robot = named(NAMES["numbers"])
    shape = Shape("sphere", (0.1,), colour=(0.1, 0.2, 0.3, 1.0))
    robot = replace(robot, links=(*robot.links[:-1], replace(robot.links[-1], collisions=(shape,))))
    reading = read_checked(write(robot, tmp_path)[0])
    assert reading.description is not None, reading.problems
    assert reading.description.links[-1].collisions[0].colour == shape.colour


def test_text_of_toml_is_text_of_xml(tmp_path: Path) -> None:
    """What neither allows as it is comes back too: titles are free text."""
    robot = replace(named(NAMES["numbers"]), title="\x00\x7f\x85\ufffe\uffff é", source=json.dumps("a\nb"))
    for form in ("loops", "urdf"):
        reading = read_checked(write(robot, tmp_path / form / FILES[form], to=form)[0])
        assert reading.description is not None, reading.problems
        assert (reading.description.title, reading.description.source) == (robot.title, robot.source)


def flat(rng: np.random.Generator, directions: int) -> Inertial:
    """Of points on a line or in a plane, whose largest moment is the sum of the others but for rounding."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    points = rng.normal(size=(6, directions)) @ turn[:directions]
    points -= points.mean(axis=0)
    tensor = sum((p @ p) * np.eye(3) - np.outer(p, p) for p in points)
    return Inertial(1.0, np.zeros(3), 0.5 * (tensor + tensor.T))


def test_rods_and_plates_keep_their_inertia_in_mujoco(tmp_path: Path) -> None:
    """MuJoCo puts the mean of all three in the place of moments of which one is larger than the sum of the others."""
    mujoco, rng = pytest.importorskip("mujoco"), np.random.default_rng(0)
    robot = named(NAMES["numbers"])
    links = [replace(link, inertial=flat(rng, 1 + n % 2)) for n, link in enumerate(robot.links)]
    robot = replace(robot, links=tuple(links))
    assert not any("inertia" in one for one in unsaid(robot, "mjcf"))
    path = write(robot, tmp_path / "robot.xml", to="mjcf")[0]
    model = mujoco.MjModel.from_xml_path(str(path))
    for link in links:
        moments = np.linalg.eigvalsh(link.inertial.inertia)
        np.testing.assert_allclose(np.sort(model.body(link.name).inertia), moments, rtol=1e-9, atol=2e-12)
    reading = read_checked(path)
    assert reading.description is not None, reading.problems
    for link in links:
        found = reading.description.link(link.name).inertial
        np.testing.assert_allclose(found.inertia, link.inertial.inertia, rtol=0.0, atol=1e-12)


def test_inertias_that_mujoco_evens_out_are_told() -> None:
    robot = named(NAMES["numbers"])
    wrong = replace(robot.links[-1], inertial=Inertial(1.0, np.zeros(3), np.diag([0.1, 0.2, 0.3001])))
    robot = replace(robot, links=(*robot.links[:-1], wrong))
    assert [one for one in unsaid(robot, "mjcf") if wrong.name in one and "inertia" in one]
    assert unsaid(robot, "loops") == unsaid(robot, "urdf") == ()


@pytest.mark.parametrize("at", [0.0, -0.3])
def test_a_joint_that_its_limits_hold_is_not_free_in_mjcf(at: float, tmp_path: Path) -> None:
    robot = named(NAMES["numbers"])
    held = replace(robot.joints[-1], type=JointType.REVOLUTE, limits=Limits(at, at))
    robot = replace(robot, joints=(*robot.joints[:-1], held))
    reading = read_checked(write(robot, tmp_path / "robot.xml", to="mjcf")[0])
    assert reading.description is not None, reading.problems
    again = reading.description.joint(held.name)
    assert again.type is JointType.REVOLUTE
    assert (again.limits.lower, again.limits.upper) == pytest.approx((at, at), abs=1e-15)
