"""MJCF: what is read is what MuJoCo compiles, and what is written MuJoCo accepts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
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
    read_checked,
)
from cutjoint.description.catalogue import names
from cutjoint.description.formats import write
from cutjoint.description.transforms import rotation_from_quaternion, rpy_from_rotation
from cutjoint.errors import InputError

mujoco = pytest.importorskip("mujoco")

MODEL = (Path(__file__).parent / "samples" / "everything.xml").read_text(encoding="utf-8")


@pytest.fixture
def mjcf(tmp_path: Path):
    def make(*edits: tuple[str, str]) -> Path:
        text = MODEL
        for old, new in edits:
            assert old in text, old
            text = text.replace(old, new, 1)
        path = tmp_path / "model.xml"
        path.write_text(text, encoding="utf-8")
        return path

    return make


def compiled(path: Path):
    model = mujoco.MjModel.from_xml_path(str(path))
    return model, mujoco.MjData(model)


def body_id(model, name: str) -> int:
    return mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)


def place(robot: RobotDescription, model, data, values: dict[str, float]) -> dict[str, float]:
    """Put MuJoCo's single joints at the values, and free bodies where our joints are at zero; the values of these."""
    mujoco.mj_resetData(model, data)
    used = {}
    for joint in robot.joints:
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint.name)
        address = model.jnt_qposadr[index]
        if joint.type.single:
            used[joint.name] = data.qpos[address] = values.get(joint.name, 0.0)
        elif joint.type is JointType.FLOATING and model.jnt_type[index] == mujoco.mjtJoint.mjJNT_FREE:
            data.qpos[address : address + 3] = joint.placement[:3, 3]
            mujoco.mju_mat2Quat(data.qpos[address + 3 : address + 7], joint.placement[:3, :3].flatten())
    return used


def compare(robot: RobotDescription, model, data, forward, seed: int) -> None:
    """Every body of MuJoCo is where our forward kinematics has the link of its name, with the same inertia."""
    generator = np.random.default_rng(seed)
    values = place(robot, model, data, {joint.name: generator.uniform(-1, 1) for joint in robot.joints})
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    world = forward(robot, values)
    for link in robot.links:
        index = body_id(model, link.name)
        if index < 1:
            continue
        here = world[link.name]
        np.testing.assert_allclose(here[:3, 3], data.xpos[index], atol=1e-13, err_msg=link.name)
        np.testing.assert_allclose(here[:3, :3], data.xmat[index].reshape(3, 3), atol=1e-13, err_msg=link.name)
        mass = link.inertial.mass if link.inertial else 0.0
        assert mass == pytest.approx(model.body_mass[index], rel=1e-13, abs=2e-12)
        if link.inertial and mass > 0.0:
            com = here[:3, :3] @ link.inertial.com + here[:3, 3]
            np.testing.assert_allclose(com, data.xipos[index], atol=1e-13, err_msg=link.name)
            axes = data.ximat[index].reshape(3, 3)
            found = axes @ np.diag(model.body_inertia[index]) @ axes.T
            ours = here[:3, :3] @ link.inertial.inertia @ here[:3, :3].T
            np.testing.assert_allclose(ours, found, atol=2e-12 + 1e-11 * np.abs(found).max(), err_msg=link.name)


@pytest.mark.parametrize("seed", range(4))
def test_bodies_and_inertias_are_mujocos(seed: int, mjcf, forward) -> None:
    path = mjcf()
    compare(load_description(path), *compiled(path), forward, seed)


def test_joints_gravity_and_actuators(mjcf) -> None:
    robot = load_description(mjcf())
    assert robot.gravity.tolist() == [0.1, 0.0, -9.5]
    assert robot.actuators == ("first", "slide")
    first = robot.joint("first")
    np.testing.assert_allclose((first.limits.lower, first.limits.upper), np.deg2rad([-90, 45]), rtol=1e-15)
    assert (first.physics.damping, first.physics.friction) == (0.2, 0.0)
    assert robot.joint("second_x").physics.friction == 0.3
    assert robot.joint("second_z").type is JointType.CONTINUOUS
    assert (robot.joint("slide").limits.lower, robot.joint("slide").limits.upper) == (-0.1, 0.2)
    assert robot.joint("ball").type is JointType.SPHERICAL
    assert robot.joint("loose").type is JointType.FLOATING


def bodies_of(model, data, robot: RobotDescription) -> dict[str, np.ndarray]:
    """MuJoCo's placements of the links that are bodies, at its `qpos0`."""
    mujoco.mj_kinematics(model, data)
    found = {}
    for link in robot.links:
        index = body_id(model, link.name)
        if index >= 0:
            found[link.name] = np.eye(4)
            found[link.name][:3, :3], found[link.name][:3, 3] = data.xmat[index].reshape(3, 3), data.xpos[index]
    return found


def test_equalities_close_where_mujoco_closes_them(mjcf) -> None:
    """At the initial posture MuJoCo's residual of `connect` by bodies and of `weld` is 0, and so is ours."""
    robot = load_description(mjcf())
    cuts = {cut.name: cut for cut in robot.cuts}
    assert {name: cut.type for name, cut in cuts.items()} == {
        "rope": CutType.SPHERICAL,
        "glue": CutType.FIXED,
        "posed": CutType.FIXED,
        "sites": CutType.SPHERICAL,
    }
    path = mjcf()
    model, data = compiled(path)
    world = bodies_of(model, data, robot)
    ends = {name: [world[f.link] @ f.placement for f in (cut.a, cut.b)] for name, cut in cuts.items()}
    np.testing.assert_allclose(*(end[:3, 3] for end in ends["rope"]), atol=1e-14)
    np.testing.assert_allclose(*ends["glue"], atol=1e-14)
    for site, end in zip(("wrist", "post"), ends["sites"], strict=True):
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, site)
        np.testing.assert_allclose(end[:3, 3], data.site_xpos[index], atol=1e-14)
        np.testing.assert_allclose(end[:3, :3], data.site_xmat[index].reshape(3, 3), atol=1e-13)


def test_residuals_are_mujocos(mjcf, forward) -> None:
    path = mjcf(('<weld name="idle" body1="loose" body2="fourth" active="false"/>', ""))
    robot = load_description(path)
    model, data = compiled(path)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    values = place(robot, model, data, {"first": 0.3, "second_x": -0.2, "second_z": 0.4, "slide": 0.05})
    mujoco.mj_forward(model, data)
    world = forward(robot, values)
    equality = mujoco.mjtConstraint.mjCNSTR_EQUALITY
    for cut in robot.cuts:
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_EQUALITY, cut.name)
        rows = [i for i in range(data.nefc) if data.efc_type[i] == equality and data.efc_id[i] == index]
        a, b = (world[frame.link] @ frame.placement for frame in (cut.a, cut.b))
        np.testing.assert_allclose(
            np.linalg.norm(a[:3, 3] - b[:3, 3]), np.linalg.norm(data.efc_pos[rows[:3]]), atol=1e-12, err_msg=cut.name
        )
        if cut.type is CutType.FIXED:
            turn = a[:3, :3].T @ b[:3, :3]
            angle = np.arctan2(np.linalg.norm(turn - turn.T) / np.sqrt(8.0), (np.trace(turn) - 1.0) / 2.0)
            assert np.linalg.norm(data.efc_pos[rows[3:]]) == pytest.approx(np.sin(angle / 2.0), abs=1e-12)
    (coupling,) = robot.couplings
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_EQUALITY, "gear")
    (row,) = [i for i in range(data.nefc) if data.efc_type[i] == equality and data.efc_id[i] == index]
    ours = values[coupling.joint] - coupling.gear[1] * values[coupling.gear[0]] - coupling.offset
    assert ours == pytest.approx(data.efc_pos[row], abs=1e-14)


def test_keyframes_are_homes(mjcf) -> None:
    path = mjcf()
    (home,) = load_description(path).homes
    assert home.name == "pose"
    np.testing.assert_allclose(home.actuated["first"], 0.5)
    np.testing.assert_allclose(home.actuated["slide"], 0.05)
    np.testing.assert_allclose(home.passive["ball"], rpy_from_rotation(rotation_from_quaternion((0.8, 0.6, 0, 0))))
    model, data = compiled(path)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_kinematics(model, data)
    free = load_description(path).joint("loose")
    from cutjoint.description.transforms import placement

    value = home.passive["loose"]
    here = free.placement @ placement(value[:3], value[3:])
    np.testing.assert_allclose(here[:3, 3], data.xpos[body_id(model, "loose")], atol=1e-14)
    np.testing.assert_allclose(here[:3, :3], data.xmat[body_id(model, "loose")].reshape(3, 3), atol=1e-14)


@pytest.mark.parametrize("name", [*names(), "cassie", "panda"])
def test_mujoco_accepts_what_is_written_and_sees_the_same_robot(name: str, tmp_path: Path, forward) -> None:
    robot = load_description(name)
    (path,) = write(robot, tmp_path / "robot.xml", to="mjcf")
    model, data = compiled(path)
    compare(robot, model, data, forward, 0)
    assert model.opt.gravity.tolist() == robot.gravity.tolist()
    assert model.nu == len(robot.actuators)
    sizes = {"fixed": 6, "spherical": 3, "revolute": 6, "universal": 6, "prismatic": 6}
    mujoco.mj_forward(model, data)
    assert data.ne == sum(sizes[cut.type] for cut in robot.cuts) + len(robot.couplings)


MOVED = {  # how the second link may move while the cut stays closed, and the coordinates of MuJoCo's extra body
    CutType.REVOLUTE: (JointType.REVOLUTE, [0.7], []),
    CutType.PRISMATIC: (JointType.PRISMATIC, [0.2], [0.2]),
    CutType.UNIVERSAL: (JointType.UNIVERSAL, [0.3, -0.5], [0.3, -0.5]),
}


@pytest.mark.parametrize("kind", MOVED)
def test_written_cuts_leave_their_own_motion_free_and_no_other(kind: CutType, tmp_path: Path) -> None:
    joint_type, values, carried = MOVED[kind]
    inertial = Inertial(1.0, inertia=np.eye(3))
    axes = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]) if kind is CutType.UNIVERSAL else ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0])
    robot = RobotDescription(
        name="pair",
        links=(Link("base"), Link("arm", inertial)),
        joints=(Joint("move", joint_type, "base", "arm", axis=np.array(axes[0]), axis2=np.array(axes[1])),),
        cuts=(CutJoint("cut", kind, Frame("base"), Frame("arm")),),
    )
    model, data = compiled(write(robot, tmp_path / "pair.xml", to="mjcf")[0])

    def residual(coordinates: list[float], extra: list[float]) -> float:
        names = ["move", "move/2"][: len(coordinates)] + ["cutjoint:cut", "cutjoint:cut/2"][: len(extra)]
        for name, value in zip(names, [*coordinates, *extra], strict=True):
            data.qpos[model.jnt_qposadr[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)]] = value
        mujoco.mj_forward(model, data)
        return float(np.abs(data.efc_pos[: data.ne]).max(initial=0.0))  # MuJoCo leaves out rows that cannot move

    assert residual(values, carried) < 1e-14
    if kind is CutType.REVOLUTE:
        tilted = replace(robot, joints=(replace(robot.joints[0], axis=np.array([0.0, 1.0, 0.0])),))
        model, data = compiled(write(tilted, tmp_path / "pair.xml", to="mjcf")[0])
        assert residual([0.3], []) > 0.01
    else:
        assert residual(values, [0.0] * len(carried)) > 0.1
        with pytest.raises(InputError, match=r"2 numbers, 1 of|4 numbers, 2 of"):
            ClosedChain(robot).from_mujoco(data.qpos)


BAD = {
    "another root": (
        [("<mujoco ", "<mujoko "), ("</mujoco>", "</mujoko>")],
        "the root element is <mujoko>",
        "<mujoco>",
    ),
    "unknown section": ([("<option", "<optoin")], "unknown element <optoin> in <mujoco>", "did you mean 'option'"),
    "unknown attribute": ([('anchor="0.1 0.2', 'anhcor="0.1 0.2')], "attribute 'anhcor' of <connect>", "'anchor'"),
    "no file to include": ([("<option", '<include file="x.xml"/><option')], "'x.xml' cannot be read", "an MJCF file"),
    "no bodies": (
        [(MODEL[MODEL.index("    <body") : MODEL.index("</mujoco>")], "</worldbody>")],
        "no body under",
        "<body>",
    ),
    "angle": ([('angle="degree"', 'angle="degrees"')], "<compiler>: invalid keyword: 'degrees'", ""),
    "euler order": ([('eulerseq="zyX"', 'eulerseq="zyw"')], "euler sequence can only contain", ""),
    "euler with two numbers": ([('euler="10 20 30" childclass', 'euler="10 20" childclass')], "'euler' does not", ""),
    "two orientations": ([('zaxis="0 1 1"', 'zaxis="0 1 1" euler="0 0 0"')], "multiple orientation", ""),
    "joint type": ([('type="slide"', 'type="slider"')], "<joint>: invalid keyword: 'slider'", ""),
    "unknown class": ([('class="tip" pos', 'class="tpi" pos')], "unknown default class", ""),
    "geom type": ([('type="cylinder"', 'type="tube"')], "<geom>: invalid keyword: 'tube'", ""),
    "unknown mesh": ([('<geom type="sphere" size="0.1"/>', '<geom type="mesh" mesh="m"/>')], "mesh 'm'", ""),
    "negative size": ([('size="0.1 0.1 0.1"', 'size="0.1 -0.1 0.1"')], "size 1 must be positive", ""),
    "range with one number": ([('range="-0.1 0.2"', 'range="-0.1"')], "'range' does not have enough data", ""),
    "range upside down": (
        [('range="-0.1 0.2"', 'range="0.2 -0.1"')],
        "limits of joint 'slide' are upside down",
        "lower",
    ),
    "unknown body": ([('body2="ball"', 'body2="bal"')], "unknown element 'bal'", "did you mean 'ball'"),
    "unknown site": ([('site2="post"', 'site2="psot"')], "unknown element 'psot'", "did you mean 'post'"),
    "one site": ([(' site2="post"', "")], "<connect>: one of ('site1'", ""),
    "no anchor": ([(' anchor="0.1 0.2 0.3"', "")], "'anchor') must be specified", ""),
    "unknown joint": ([('joint2="first"', 'joint2="frist"')], "unknown element 'frist'", "did you mean 'first'"),
    "short keyframe": ([('qpos="0.5 0.1 ', 'qpos="0.5 ')], "qpos of key 'pose': 14 numbers", "15 numbers"),
    "mass text": ([('mass="0.5"', 'mass="half"')], "attribute 'mass': 'half' is not a number", ""),
    "decimal comma": ([('mass="0.5"', 'mass="0,5"')], "decimal comma in '0,5'", "write decimal points: 0.5"),
    "not a number": ([('mass="0.5"', 'mass="nan"')], "mass of <inertial> is nan", "a finite number"),
    "huge": ([('mass="0.5"', 'mass="1e300"')], "mass of body 'third' is 1e+300", "at most 1e+09"),
    "impossible inertia": ([('diaginertia="0.01 0.012 0.015"', 'diaginertia="0.01 0.01 0.05"')], "A + B >= C", ""),
    "cut within one body": (
        [('body1="third" body2="ball"', 'body1="third" body2="third"')],
        "element 'third' is repeated",
        "",
    ),
    "two bodies of one name": ([('body name="ball"', 'body name="third"')], "repeated name 'third' in body", ""),
    "inertia of a mesh": (
        [
            ("<worldbody>", '<asset><mesh name="m" file="none.stl"/></asset><worldbody>'),
            ('<geom type="sphere" size="0.05"/>', '<geom type="mesh" mesh="m"/>'),
        ],
        "the inertia of body 'ball' would come from the mesh 'none.stl', which is not there",
        "<inertial>",
    ),
    "two sums of one joint": (
        [('<joint name="gear"', '<joint joint1="second_z" joint2="first" polycoef="0 1 1 0 0"/><joint name="gear"')],
        "contradicts the others",
        "",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input(case: str, mjcf) -> None:
    edits, found, expected = BAD[case]
    reading = read_checked(mjcf(*edits))
    assert reading.description is None
    hits = [one for one in reading.problems if found in one.found and expected in f"{one.expected} {one.mend}"]
    assert hits, [str(one) for one in reading.problems]
    assert hits[0].severity == "error"
    assert hits[0].line


def test_actuators_of_what_is_no_joint_are_told(mjcf) -> None:
    reading = read_checked(mjcf(('<velocity joint="first"/>', '<general name="jet" site="wrist"/>')))
    assert [(one.found, one.tolerable) for one in reading.problems] == [("<general> 'jet' on a site is not read", True)]
