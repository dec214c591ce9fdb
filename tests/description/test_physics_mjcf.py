"""Joint physics of MJCF: what is read of random models acts as MuJoCo makes it act, and what is written too."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.physics import with_any_physics
from kit.quickly import few

from cutjoint.description import JointType, RobotDescription, load_description, read_checked
from cutjoint.description.formats import unsaid, write
from cutjoint.errors import DescriptionError

mujoco = pytest.importorskip("mujoco")

Rng = np.random.Generator
MASS = '<inertial pos="0.1 0 0" mass="1" diaginertia="1 1 1"/>'
CLASSES = ("", "soft", "inner", "stiff")


def attributes(rng: Rng, scale: float, kind: str, share: float = 0.5) -> str:
    """Attributes of a joint, each there or not."""
    values = {key: scale * rng.uniform(0.1, 10.0) for key in ("damping", "frictionloss", "stiffness", "armature")}
    values["springdamper"] = f"{rng.uniform(0.1, 1.0)} {rng.uniform(0.1, 2.0)}" if rng.uniform() < 0.3 else "0 0"
    if kind != "ball":
        values |= {key: rng.normal() for key in ("ref", "springref")}
    return " ".join(f'{key}="{value}"' for key, value in values.items() if rng.uniform() < share)


def model(rng: Rng, scale: float) -> str:
    """A chain of hinges, slides and balls, some in nested classes of defaults, with motors."""
    angle = rng.choice(["degree", "radian", ""])
    compiler = f'<compiler angle="{angle}"/>' if angle else ""
    defaults = (
        f"<default><joint {attributes(rng, scale, 'hinge', 0.3)}/>"
        f'<default class="soft"><joint {attributes(rng, scale, "hinge")}/>'
        f'<default class="inner"><joint {attributes(rng, scale, "hinge")}/></default></default>'
        f'<default class="stiff"><joint {attributes(rng, scale, "hinge")}/><position gear="3"/></default></default>'
    )
    bodies, ends, motors = "", "", ""
    for number in range(rng.integers(1, 6)):
        kind = str(rng.choice(["hinge", "slide", "ball"]))
        own, around = (str(rng.choice(CLASSES)) for _ in range(2))
        inside = (f' class="{own}"' if own else "") + (f' type="{kind}"' if kind != "hinge" else "")
        axis = " ".join(map(str, rng.normal(size=3)))
        wrap = f' childclass="{around}"' if around else ""
        joint = f'<joint name="j{number}"{inside} axis="{axis}" {attributes(rng, scale, kind, 0.3)}/>'
        bodies += f'<body name="b{number}" pos="0.3 0.1 0"{wrap}>{MASS}{joint}'
        ends += "</body>"
        if kind != "ball" and rng.integers(2):
            rotor = f' armature="{scale * rng.uniform(0.1, 1.0)}"' if rng.integers(2) else ""
            rotor += f' damping="{scale * rng.uniform(0.1, 1.0)}"' if rng.integers(2) else ""
            gear = f' gear="{rng.normal()} 0 0 0 0 0"' if rng.integers(2) else ""
            motors += f'<motor joint="j{number}" class="{rng.choice(["main", "stiff"])}"{gear}{rotor}/>'
    actuator = f"<actuator>{motors}</actuator>" if motors else ""
    return f"<mujoco>{compiler}{defaults}<worldbody>{bodies}{ends}</worldbody>{actuator}</mujoco>"


def rotation_vector(quaternion: np.ndarray) -> np.ndarray:
    vector = np.zeros(3)
    mujoco.mju_quat2Vel(vector, quaternion, 1.0)
    return vector


def passive(robot: RobotDescription, compiled, data) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Forces of dampers and springs as our description has them, in MuJoCo's vectors; friction and armature as well."""
    force, friction, armature = (np.zeros(compiled.nv) for _ in range(3))
    for joint in robot.joints:
        index = mujoco.mj_name2id(compiled, mujoco.mjtObj.mjOBJ_JOINT, joint.name)
        if index < 0 or not joint.type.moves:
            continue
        physics, at, q = joint.physics, compiled.jnt_dofadr[index], compiled.jnt_qposadr[index]
        rates = slice(at, at + joint.type.dof)
        if joint.type is JointType.SPHERICAL:
            stretched = rotation_vector(data.qpos[q : q + 4])
        elif joint.type is JointType.FLOATING:
            stretched = np.zeros(6)
        else:
            stretched = data.qpos[q] - (physics.rest or 0.0)
        force[rates] = -physics.damping * data.qvel[rates] - physics.stiffness * stretched
        friction[rates], armature[rates] = physics.friction, physics.armature
    return force, friction, armature


def full_mass(compiled, data) -> np.ndarray:
    mass = np.zeros((compiled.nv, compiled.nv))
    mujoco.mj_fullM(compiled, data, mass)
    return mass


def compare(robot: RobotDescription, path: Path, rng: Rng) -> None:
    """Passive forces, dry friction and what rotors add to the mass matrix, at a random state."""
    compiled = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(compiled)
    mujoco.mj_integratePos(compiled, data.qpos, rng.normal(size=compiled.nv), 1.0)
    data.qvel[:] = rng.normal(size=compiled.nv)
    mujoco.mj_forward(compiled, data)
    force, friction, armature = passive(robot, compiled, data)
    size = np.abs(force).max(initial=1e-300)
    np.testing.assert_allclose(force, data.qfrc_passive, atol=1e-12 * size)
    np.testing.assert_allclose(friction, compiled.dof_frictionloss, rtol=1e-14)
    heavy = full_mass(compiled, data)
    compiled.dof_armature[:] = 0.0
    compiled.actuator_armature[:] = 0.0
    mujoco.mj_forward(compiled, data)
    np.testing.assert_allclose(np.diag(armature), heavy - full_mass(compiled, data), atol=1e-12 * np.abs(heavy).max())


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("seed", few(range(40), *range(4)))
def test_random_models_act_as_in_mujoco(seed: int, scale: float, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    path = tmp_path / "model.xml"
    path.write_text(model(rng, scale), encoding="utf-8")
    compare(load_description(path), path, rng)


@pytest.mark.parametrize("name", ["fourbar", "fivebar", "stewart"])
@pytest.mark.parametrize("seed", few(range(5), 0))
def test_what_is_written_acts_in_mujoco(name: str, seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    robot = with_any_physics(load_description(name), rng)
    compare(robot, write(robot, tmp_path / "robot.xml", "mjcf")[0], rng)


def slide(attributes: str, more: str = "", tag: str = "joint") -> str:
    return (
        f'<mujoco><compiler angle="radian"/>{more}<worldbody><body name="b"><{tag} name="j" {attributes}/>{MASS}'
        "</body></worldbody></mujoco>"
    )


@pytest.fixture
def text(tmp_path: Path):
    def make(content: str) -> Path:
        path = tmp_path / "model.xml"
        path.write_text(content, encoding="utf-8")
        return path

    return make


BOUNDS = {
    '<motor joint="j" forcerange="-3 3"/>': 3.0,
    '<motor joint="j" forcerange="-3 3" gear="-5"/>': 15.0,
    '<motor joint="j" ctrlrange="-2 2" gear="5"/>': 10.0,
    '<motor joint="j" ctrlrange="-2 2" forcerange="-1.5 1.5" gear="4"/>': 6.0,
    '<general joint="j" forcerange="-4 4"/>': 4.0,
    '<motor joint="j" forcerange="-3 3" forcelimited="false"/>': None,
    '<motor joint="j" ctrlrange="-1 1"/><motor joint="j" ctrlrange="-2 2"/>': 3.0,
    '<motor joint="j" ctrlrange="-1 1"/><motor joint="j"/>': None,
}


@pytest.mark.parametrize("actuators", BOUNDS)
@pytest.mark.parametrize("bound", [None, 2.5])
def test_efforts_end_where_mujoco_ends_them(actuators: str, bound: float | None, text) -> None:
    own = "" if bound is None else f'actuatorfrcrange="{-bound} {bound}"'
    path = text(slide(f'type="slide" {own}').replace("</mujoco>", f"<actuator>{actuators}</actuator></mujoco>"))
    effort = load_description(path).joint("j").limits.effort
    assert effort == min((one for one in (BOUNDS[actuators], bound) if one is not None), default=None)
    compiled = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(compiled)
    for far in (1e9, -1e9):
        data.ctrl[:] = far * np.sign(compiled.actuator_gear[:, 0])
        mujoco.mj_forward(compiled, data)
        found = abs(data.qfrc_actuator[0])
        assert found == effort if effort is not None else found > 1e8


def test_a_gear_is_a_lever_of_the_force_and_no_gearbox(text) -> None:
    """As MuJoCo has it: the armature of a joint does not depend on its actuator's gear."""
    motor = '<actuator><motor joint="j" gear="50"/></actuator></mujoco>'
    path = text(slide('armature="0.5"').replace("</mujoco>", motor))
    physics = load_description(path).joint("j").physics
    assert (physics.rotor, physics.gear, physics.armature) == (0.5, 1.0, 0.5)
    compare(load_description(path), path, np.random.default_rng(0))


def test_gravcomp_is_read_and_written(text) -> None:
    robot = load_description(text(slide("").replace('name="b"', 'name="b" gravcomp="0.7"')))
    assert [link.gravity_compensation for link in robot.links if link.inertial] == [0.7]
    assert unsaid(robot, "mjcf") == ()
    assert unsaid(robot, "urdf") == ("gravity compensation of link b",)
    for wrong in ("-0.5", "2e3"):
        with pytest.raises(DescriptionError, match=f"gravity compensation of link 'b' is {float(wrong):g}"):
            load_description(text(slide("").replace('name="b"', f'name="b" gravcomp="{wrong}"')))


def test_a_rotor_of_the_actuator_is_behind_its_gear(text) -> None:
    motor = '<actuator><motor joint="j" gear="50" armature="2e-4"/></actuator></mujoco>'
    path = text(slide("").replace("</mujoco>", motor))
    physics = load_description(path).joint("j").physics
    assert (physics.rotor, physics.gear, physics.armature) == (2e-4, 50.0, 0.5)
    compare(load_description(path), path, np.random.default_rng(0))


def test_joints_become_one_only_where_they_are_alike(text) -> None:
    """Two hinges with one name are a universal joint; with dampers that differ, or ranges, they stay two."""
    second = '<joint name="j/2" axis="0 1 0" damping="1"/>'
    for own, type_of in (
        ('damping="1"', JointType.UNIVERSAL),
        ('damping="2"', JointType.CONTINUOUS),
        ('damping="1" range="-1 1"', JointType.REVOLUTE),
    ):
        path = text(slide(f'axis="1 0 0" {own}').replace(MASS, second + MASS))
        robot = load_description(path)
        assert robot.joint("j").type is type_of
        if type_of is not JointType.UNIVERSAL:
            compare(robot, path, np.random.default_rng(0))


def test_a_free_joint_has_dampers(text) -> None:
    path = text(slide('type="free" damping="2"'))
    robot = load_description(path)
    assert robot.joint("j").physics.damping == 2.0
    compare(robot, path, np.random.default_rng(0))
    again = load_description(write(robot, path.parent / "again.xml", "mjcf")[0])
    assert again.joint("j").physics == robot.joint("j").physics
    default = '<default><joint stiffness="3" damping="2"/></default>'
    assert load_description(text(slide("", default, "freejoint"))).joint("j").physics.damping == 0.0


WARNINGS = {
    "solreflimit of joint 'j' not used": slide('range="-1 1" solreflimit="0.1 1"'),
    "actuatorfrcrange of joint 'j' is -3 4: not used": slide('actuatorfrcrange="-3 4"'),
    "density of <option> not used": slide("", '<option density="1.2"/>'),
    "damper switched off by <flag>": slide("", '<option><flag damper="disable"/></option>'),
    "range of <fixed> 't' not used": slide("").replace(
        "</mujoco>", '<tendon><fixed name="t" range="-1 1"><joint joint="j" coef="1"/></fixed></tendon></mujoco>'
    ),
}


@pytest.mark.parametrize("found", WARNINGS)
def test_what_is_not_computed_is_told(found: str, text) -> None:
    reading = read_checked(text(WARNINGS[found]))
    assert reading.description is not None
    assert [one.found.startswith(found) for one in reading.problems] == [True]


def test_usual_softness_is_not_worth_a_word(text) -> None:
    reading = read_checked(text(slide('range="-1 1" solreflimit="0.02 1" solimplimit="0.9 0.95" margin="0"')))
    assert reading.problems == ()


ERRORS = {
    "stiffness 3 of the free joint 'j'": slide('type="free" stiffness="3"'),
    "frictionloss 1 of the free joint 'j'": slide('type="free"', '<default><joint frictionloss="1"/></default>'),
    "armature 1 of the free joint 'j'": slide('type="free" armature="1"'),
    "unknown attribute 'dampin' of <joint>": slide('dampin="1"'),
    "unknown attribute 'bogus' of <joint>": slide('bogus="1"'),
    "damping of joint 'j' is -1": slide('damping="-1"'),
    "friction of joint 'j' is -1": slide('frictionloss="-1"'),
    "rotor of joint 'j' is -1": slide('armature="-1"'),
    "stiffness of joint 'j' is -1": slide('stiffness="-1"'),
    "stiffness of joint 'j' is 3 1 2": slide('stiffness="3 1 2"'),
    "damping of joint 'j' is nan": slide('damping="nan"'),
}


@pytest.mark.parametrize("found", ERRORS)
def test_what_cannot_be_is_refused(found: str, text) -> None:
    reading = read_checked(text(ERRORS[found]))
    assert reading.description is None
    assert any(one.found.startswith(found) and one.severity == "error" for one in reading.problems), reading.problems


def test_polynomials_without_higher_terms_are_numbers(text) -> None:
    physics = load_description(text(slide('stiffness="3 0 0" damping="2 0"'))).joint("j").physics
    assert (physics.stiffness, physics.damping) == (3.0, 2.0)


def test_what_the_format_has_no_word_for_is_told() -> None:
    rng = np.random.default_rng(0)
    robot = with_any_physics(load_description("fourbar"), rng, stops=True)
    sticking = {joint.name for joint in robot.joints[1:3]}
    joints = [
        replace(
            joint, physics=replace(joint.physics, friction=1.0, friction_speed=0.0 if joint.name in sticking else 0.1)
        )
        for joint in robot.joints
        if joint.type.moves
    ]
    robot = replace(robot, joints=(*(one for one in robot.joints if not one.type.moves), *joints))
    told = unsaid(robot, "mjcf")
    assert all(any(joint.name in one for one in told) for joint in robot.joints if joint.physics.stop_stiffness)
    (speeds,) = [one for one in told if "friction_speed" in one]
    assert {joint.name for joint in joints if joint.name in speeds} == {one.name for one in joints} - sticking
    assert unsaid(robot, "loops") == ()
    assert unsaid(load_description("fourbar"), "mjcf") == ()
