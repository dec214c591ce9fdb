"""Whatever is written is read back the same, in every format that can be written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.described import FILES, differences
from kit.physics import with_any_cuts, with_any_physics
from kit.quickly import few

from cutjoint.description import (
    Coupling,
    CutJoint,
    CutType,
    Frame,
    Home,
    Inertial,
    Joint,
    JointPhysics,
    JointType,
    Limits,
    Link,
    RobotDescription,
    Shape,
    Variant,
    check,
    load_description,
)
from cutjoint.description.catalogue import names
from cutjoint.description.formats import WRITERS, write
from cutjoint.description.model import TASK_AXES, TASK_NAMES
from cutjoint.description.transforms import placement
from cutjoint.errors import UnknownNameError


def menagerie(mesh: Path, seed: int = 0) -> RobotDescription:
    """A robot with one of everything: joint types, cut types, shapes, limits, couplings, awkward names."""
    generator = np.random.default_rng(seed)

    def somewhere() -> np.ndarray:
        return placement(generator.uniform(-1, 1, 3), generator.uniform(-3, 3, 3))

    def unit() -> np.ndarray:
        vector = generator.normal(size=3)
        return vector / np.linalg.norm(vector)

    def inertial() -> Inertial:
        points, masses = generator.normal(size=(5, 3)), generator.uniform(0.1, 1, 5)
        arms = points - masses @ points / masses.sum()
        tensor = sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, arms, strict=True))
        return Inertial(float(masses.sum()), generator.normal(size=3), 0.5 * (tensor + tensor.T))

    kinds = list(JointType)
    tags = ["plain", "with space", "ünï", 'quote"d', "a/b", "under_score", "<tag>&", "8"]
    first = unit()
    second = np.cross(first, unit())
    second /= np.linalg.norm(second)
    links, joints = [Link("base")], []
    limits = {
        JointType.REVOLUTE: Limits(-1.25, None, 3.5, None),
        JointType.PRISMATIC: Limits(None, 0.1, None, 12.0),
        JointType.CONTINUOUS: Limits(None, None, 7.0, 8.0),
    }
    for number, (kind, tag) in enumerate(zip(kinds, tags, strict=True)):
        links.append(Link(f"link {tag}", inertial()))
        parent = links[number // 2].name
        axis, axis2 = (unit(), np.array([0.0, 1.0, 0.0])) if kind is not JointType.UNIVERSAL else (first, second)
        if kind in (JointType.FIXED, JointType.SPHERICAL, JointType.FLOATING):
            axis = np.array([1.0, 0.0, 0.0])
        moving = 0.25 if kind in (JointType.REVOLUTE, JointType.PRISMATIC) else 0.0
        joints.append(
            Joint(
                f"joint {tag}", kind, parent, links[-1].name, somewhere(), axis, axis2,
                limits.get(kind, Limits()), physics=JointPhysics(moving, 2.0 * moving),
            )
        )  # fmt: skip
    shapes = (
        Shape("box", (0.1, 0.2, 0.3), somewhere(), (0.1, 0.2, 0.3, 0.5), name="crate"),
        Shape("cylinder", (0.1, 0.25), somewhere()),
        Shape("sphere", (0.3,), placement((0.0, 0.0, 0.1)), (1.0, 0.0, 0.0, 1.0)),
        Shape("mesh", (0.001, -0.001, 0.001), somewhere(), None, mesh),
    )
    links[1] = replace(links[1], visuals=shapes, collisions=(Shape("capsule", (0.05, 0.4)),))
    ends = [link.name for link in links if link.name != "link plain"]
    cuts = [
        CutJoint(
            f"cut {kind}",
            kind,
            Frame(ends[n + 1], somewhere()),
            Frame(ends[n - 2], somewhere()),
            length=float(generator.uniform(0.1, 3.0)) if kind.has_length else 0.0,
        )
        for n, kind in enumerate(CutType)
    ]
    names_of = {joint.type: joint.name for joint in joints}
    links = [replace(one, gravity_compensation=float(generator.choice([0.0, 1.0, 0.3]))) for one in links]
    return RobotDescription(
        name="menagerie",
        links=tuple(links),
        joints=tuple(joints),
        cuts=tuple(cuts),
        couplings=(
            Coupling.geared("gear", names_of[JointType.CONTINUOUS], names_of[JointType.REVOLUTE], -2.5, 0.125),
            Coupling.geared(
                f"{names_of[JointType.PRISMATIC]}_mimic", names_of[JointType.PRISMATIC], names_of[JointType.REVOLUTE]
            ),
        ),
        actuators=(names_of[JointType.REVOLUTE],),
        tool=Frame(links[3].name, somewhere()),
        task=tuple(generator.permutation(TASK_NAMES)[: generator.integers(7)].tolist()),
        task_axes=TASK_AXES[seed % 2],
        gravity=np.array([0.1, 9.81, -0.3]),
        homes=(
            Home(
                "start here",
                {names_of[JointType.REVOLUTE]: 0.1},
                {
                    names_of[JointType.CONTINUOUS]: 1.0 / 3.0,
                    names_of[JointType.UNIVERSAL]: (0.1, -0.2),
                    names_of[JointType.SPHERICAL]: (0.1, 0.2, 0.3),
                    names_of[JointType.PLANAR]: (1.0, 2.0, 3.0),
                    names_of[JointType.FLOATING]: (1.0, 2.0, 3.0, 0.1, 0.2, 0.3),
                },
                'about "quotes"\nand lines',
            ),
            Home("bare", {names_of[JointType.REVOLUTE]: -1e-5}),
        ),
        variants=(Variant("heavy", "twice", {links[2].name: inertial(), links[4].name: inertial()}), Variant("none")),
        title="One of everything \u007f",
        source="tests",
    )


@pytest.fixture
def mesh(tmp_path: Path) -> Path:
    """A tetrahedron as a binary STL."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype="<f4") * 100
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    path = tmp_path / "meshes" / "part.stl"
    path.parent.mkdir()
    triangles = b"".join(np.zeros(3, "<f4").tobytes() + corners[list(face)].tobytes() + b"\0\0" for face in faces)
    path.write_bytes(b"\0" * 80 + np.array([4], "<u4").tobytes() + triangles)
    return path


@pytest.mark.parametrize("form", WRITERS)
@pytest.mark.parametrize("seed", range(5))
def test_one_of_everything_comes_back(form: str, seed: int, mesh: Path, tmp_path: Path) -> None:
    robot = menagerie(mesh, seed)
    assert [one for one in check(robot) if one.severity == "error"] == []
    written = write(robot, tmp_path / "out" / FILES[form], to=form)
    assert all(path.is_file() for path in written)
    assert differences(robot, load_description(written[0])) == []


@pytest.mark.parametrize("form", WRITERS)
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("seed", few(range(12), 0, 1, 2))
def test_physics_comes_back_bit_by_bit(form: str, scale: float, seed: int, mesh: Path, tmp_path: Path) -> None:
    rng = np.random.default_rng([seed, round(1e3 * scale)])
    robot = with_any_cuts(with_any_physics(menagerie(mesh, seed), rng, scale), rng, scale)
    assert [str(one) for one in check(robot)] == []
    again = load_description(write(robot, tmp_path / "out" / FILES[form], to=form)[0])
    assert {one.name: one.physics for one in again.joints} == {one.name: one.physics for one in robot.joints}
    assert {one.name: (one.physics, one.bushing) for one in again.cuts} == {
        one.name: (one.physics, one.bushing) for one in robot.cuts
    }
    assert {one.name: one.limits for one in again.joints} == {one.name: one.limits for one in robot.joints}
    assert differences(robot, again) == []


@pytest.mark.parametrize("seed", range(3))
def test_the_tree_alone_tells_what_urdf_can(seed: int, mesh: Path, tmp_path: Path) -> None:
    """robot.urdf beside a loops.toml has dampers, friction and springs; rotors, gears and stops are in that."""
    robot = with_any_physics(menagerie(mesh, seed), np.random.default_rng(seed))
    alone = load_description(write(robot, tmp_path)[1])
    for joint in robot.joints:
        if joint.type.urdf is not None:
            wanted = replace(joint.physics, rotor=0.0, gear=1.0, stop_stiffness=0.0, stop_damping=0.0)
            assert alone.joint(joint.name).physics == wanted


@pytest.mark.parametrize("form", WRITERS)
@pytest.mark.parametrize("name", names())
def test_shipped_robots_come_back(name: str, form: str, tmp_path: Path) -> None:
    robot = load_description(name)
    again = load_description(write(robot, tmp_path / FILES[form], to=form)[0])
    assert differences(robot, again) == []
    assert check(again) == ()


@pytest.mark.parametrize("name", ["ur5", "panda", "cassie"])
@pytest.mark.parametrize("form", ["loops", "urdf"])
def test_published_robots_come_back(name: str, form: str, tmp_path: Path) -> None:
    robot = load_description(name)
    again = load_description(write(robot, tmp_path / FILES[form], to=form)[0], lenient=True)
    assert differences(robot, again, tolerance=1e-14) == []


def test_a_variant_is_written_as_the_inertias_of_the_tree(tmp_path: Path) -> None:
    robot = load_description("omega3", variant="lumped")
    again = load_description(write(robot, tmp_path)[0])
    assert differences(replace(robot, variant_name=""), again) == []


def test_differences_are_seen(mesh: Path) -> None:
    robot, other = menagerie(mesh), menagerie(mesh, 1)
    assert differences(robot, robot) == []
    assert len(differences(robot, other)) > 30
    moved = replace(robot, cuts=(replace(robot.cuts[0], name="renamed"), *robot.cuts[1:]))
    assert differences(robot, moved) != []
    lighter = robot.with_inertial("base", Inertial(1.0 + 1e-12))
    assert differences(robot.with_inertial("base", Inertial(1.0)), lighter) != []


def test_a_failed_write_leaves_the_old_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = load_description("fourbar")
    write(robot, tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def refuse(*_: object) -> None:
        raise OSError("no room")

    monkeypatch.setattr("cutjoint.files.os.replace", refuse)
    with pytest.raises(OSError, match="no room"):
        write(replace(robot, name="other"), tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_unknown_formats_suggest_the_nearest(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'mjcf'"):
        write(load_description("fourbar"), tmp_path / "x.xml", to="mjcff")
