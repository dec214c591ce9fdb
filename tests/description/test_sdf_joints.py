"""SDF: joints with two axes, gearboxes, mimics, plugins, and which joints close loops."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kit.in_sdf import somewhere, unit
from kit.sdf_text import SQUARE, TIP, joint, link, model
from scipy.spatial.transform import Rotation

from cutjoint.chain import ClosedChain
from cutjoint.description import CutType, JointType, read_checked
from cutjoint.description.formats import Reading


@pytest.fixture
def reading(tmp_path: Path):
    def make(text: str, lenient: bool = False) -> Reading:
        path = tmp_path / "model.sdf"
        path.write_text(text)
        return read_checked(path, lenient)

    return make


def said(one: Reading) -> list[str]:
    return [problem.found for problem in one.problems]


def words(values: np.ndarray) -> str:
    return " ".join(map(repr, map(float, values)))


def pose(at: np.ndarray) -> str:
    turn = Rotation.from_matrix(at[:3, :3]).as_euler("xyz")
    return f'<pose relative_to="__model__">{words(at[:3, 3])} {words(turn)}</pose>'


# -- two axes --------------------------------------------------------------------------------------------------------


def two(kind: str, first: str, second: str, more: str = "", more2: str = "") -> str:
    axes = f"<axis><xyz>{first}</xyz>{more}</axis><axis2><xyz>{second}</xyz>{more2}</axis2>"
    return f'<joint name="J" type="{kind}"><parent>a</parent><child>b</child>{axes}</joint>'


BASE = link("a") + joint("A", "world", "a") + link("b", "1 0 0 0 0 0")
DAMPED = "<dynamics><damping>{}</damping></dynamics>"
RANGE = "<limit><lower>-1</lower><upper>2</upper></limit>"


@pytest.mark.parametrize("kind", ["universal", "revolute2"])
@pytest.mark.parametrize(
    ("second", "more", "more2"),
    [
        ("1 0 0", "", DAMPED.format(0.4)),
        ("1 0 0", RANGE, ""),
        ("0.6 0.8 0", DAMPED.format(0.3), DAMPED.format(0.3)),
    ],
)
def test_axes_that_no_universal_joint_has_are_two_hinges(
    kind: str, second: str, more: str, more2: str, reading
) -> None:
    """Against the hinges written out, with a link without mass between them."""
    found = reading(model(BASE + two(kind, "0 1 0", second, more, more2))).description
    middle = (
        '<link name="m"><pose>1 0 0 0 0 0</pose><inertial><mass>0</mass><inertia><ixx>0</ixx><iyy>0</iyy><izz>0</izz>'
    )
    middle += "</inertia></inertial></link>"
    hinges = "".join(
        f'<joint name="{name}" type="revolute"><parent>{up}</parent><child>{down}</child>'
        f"<pose relative_to='b'>0 0 0 0 0 0</pose><axis><xyz>{axis}</xyz>{inside}</axis></joint>"
        for name, up, down, axis, inside in (("J", "a", "m", "0 1 0", more), ("J2", "m", "b", second, more2))
    )
    wanted = reading(model(BASE + middle + hinges)).description
    chains = [ClosedChain(one) for one in (found, wanted)]
    rng = np.random.default_rng(4)
    q, v, effort = rng.uniform(-0.5, 0.5, 3), rng.normal(size=3), rng.normal(size=3)
    order = [
        [chain.model.getJointId(name) for name in names]
        for chain, names in zip(chains, (["A", "J", "J/2"], ["A", "J", "J2"]), strict=True)
    ]
    accelerations = []
    for chain, ids in zip(chains, order, strict=True):
        at = np.argsort([chain.model.idx_vs[one] for one in ids])
        accelerations.append(chain.full_acceleration(q[at], v[at], effort[at])[np.argsort(at)])
    np.testing.assert_allclose(accelerations[0], accelerations[1], rtol=1e-11)
    assert [found.joint(name).limits.upper for name in ("J", "J/2")] == [2.0 if more == RANGE else None, None]


@pytest.mark.parametrize("kind", ["universal", "revolute2"])
def test_axes_that_are_alike_are_one_universal_joint(kind: str, reading) -> None:
    found = reading(model(BASE + two(kind, "0 1 0", "1 0 0", DAMPED.format(2), DAMPED.format(2)))).description
    assert found.joint("J").type is JointType.UNIVERSAL
    np.testing.assert_allclose(found.joint("J").axis, [0, 1, 0])  # the first axis stays with the parent
    assert found.joint("J").physics.damping == 2.0


# -- couplings -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_a_gearbox_turns_its_gears_against_each_other(seed: int, reading, forward) -> None:
    """theta2 = - ratio theta1, both angles seen from the reference body about the gearbox's own axes, whichever way the
    hinges point and whichever of their ends is the parent."""
    rng = np.random.default_rng(seed)
    places = [somewhere(rng) for _ in range(3)]
    axes = [unit(rng), unit(rng)]
    ratio = float(rng.uniform(0.3, 4.0))
    text = ""
    for name, at in zip("rpc", places, strict=True):
        text += link(name).replace("<pose>0 0 0 0 0 0</pose>", pose(at), 1)
    signs = rng.choice([-1.0, 1.0], 4)
    for name, axis, sign in zip("pc", axes, signs, strict=False):
        ends = [
            f"<{tag}>{one}</{tag}>" for tag, one in zip(rng.permutation(["parent", "child"]), ("r", name), strict=True)
        ]
        xyz = f'<xyz expressed_in="__model__">{words(sign * axis)}</xyz>'
        text += f'<joint name="{name}_turn" type="revolute">{"".join(ends)}<axis>{xyz}</axis></joint>'
    tags = [
        f'<{tag}><xyz expressed_in="__model__">{words(sign * axis)}</xyz></{tag}>'
        for tag, axis, sign in zip(("axis", "axis2"), axes, signs[2:], strict=True)
    ]
    gears = f"<gearbox_ratio>{ratio!r}</gearbox_ratio><gearbox_reference_body>r</gearbox_reference_body>"
    text += f'<joint name="G" type="gearbox"><parent>p</parent><child>c</child>{"".join(tags)}{gears}</joint>'
    robot = reading(model(text + joint("W", "world", "r", "fixed"))).description
    (coupling,) = robot.couplings
    driver, factor = coupling.gear
    moved = forward(robot, {driver: 0.3, coupling.joint: factor * 0.3})
    angles = []
    for name, axis, sign in zip("pc", axes, signs[2:], strict=True):
        zero, turned = forward(robot, {})[name][:3, :3], moved[name][:3, :3]
        vector = Rotation.from_matrix(turned @ zero.T).as_rotvec()
        angles.append(float(vector @ axis) * sign)
        np.testing.assert_allclose(np.cross(vector, axis), 0.0, atol=1e-12)
    assert abs(angles[0]) > 1e-3
    assert angles[1] == pytest.approx(-ratio * angles[0], rel=1e-12)


GEARS = '<joint name="G" type="gearbox"><parent>b</parent><child>c</child>{}</joint>'
AXES = "<axis><xyz>0 0 1</xyz></axis><axis2><xyz>{}</xyz></axis2>"


@pytest.mark.parametrize(
    ("inside", "found"),
    [
        (AXES.format("0 0 1"), "gearbox 'G' without <gearbox_reference_body>"),
        (
            AXES.format("0 0 1") + "<gearbox_reference_body>z</gearbox_reference_body>",
            "gearbox 'G' at the unknown frame",
        ),
        (
            AXES.format("0 1 0") + "<gearbox_reference_body>a</gearbox_reference_body>",
            "without a hinge between 'a' and 'c'",
        ),
        ("<gearbox_reference_body>a</gearbox_reference_body>", "gearbox 'G' without <axis>"),
    ],
)
def test_a_gearbox_without_hinges_is_refused(inside: str, found: str, reading) -> None:
    text = link("a") + link("b") + link("c") + joint("B", "a", "b") + joint("C", "a", "c")
    one = reading(model(text + joint("A", "world", "a") + GEARS.format(inside)))
    assert one.description is None
    assert any(found in each for each in said(one)), said(one)


def test_a_mimic_may_follow_the_second_axis_of_a_universal_joint(reading) -> None:
    mimic = (
        '<mimic joint="J" axis="axis2"><multiplier>2</multiplier><offset>0.5</offset><reference>0.1</reference></mimic>'
    )
    text = BASE + two("universal", "0 1 0", "1 0 0") + link("c") + joint("C", "b", "c", axis=mimic)
    (coupling,) = reading(model(text)).description.couplings
    assert (coupling.joint, coupling.gear) == ("C", ("J/2", 2.0))
    assert coupling.offset == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("attributes", "found"),
    [
        ('joint="K"', "the mimic of joint 'C' follows the unknown joint 'K'"),
        ('joint="J" axis="axis2"', "the mimic of joint 'C' follows <axis2> of joint 'J'"),
        ('joint="J" axis="axsi"', "the mimic of joint 'C' follows the 'axsi' of a joint"),
    ],
)
def test_bad_mimics(attributes: str, found: str, reading) -> None:
    text = BASE + joint("J", "a", "b") + link("c") + joint("C", "b", "c", axis=f"<mimic {attributes}/>")
    one = reading(model(text))
    assert one.description is None
    assert found in said(one)


# -- plugins ---------------------------------------------------------------------------------------------------------


def plugin(name: str, inside: str) -> str:
    return f'<plugin filename="lib{name}.so" name="gz::sim::systems::{name}">{inside}</plugin>'


TIPPED = SQUARE + joint("D", "b", "c", more=TIP)


def test_joint_controllers_are_actuators_and_stay_in_the_tree(reading) -> None:
    for name in ("A", "D", "C"):
        one = reading(model(TIPPED + plugin("JointPositionController", f"<joint_name>{name}</joint_name>")))
        assert one.description.actuators == (name,)
        assert one.problems == ()
        assert ClosedChain(one.description).mobility().mobility == 1


def test_the_plugin_for_mimics_is_a_coupling(reading) -> None:
    inside = "<joint>A</joint><mimicJoint>C</mimicJoint><multiplier>-2</multiplier><offset>0.1</offset>"
    one = reading(model(SQUARE + plugin("roboticsgroup_gazebo_mimic_joint_plugin", inside)))
    (coupling,) = one.description.couplings
    assert coupling.formula == "C = -2 A + 0.1"


def test_plugins_that_hold_links_are_refused_and_others_that_name_joints_are_told(reading) -> None:
    held = plugin("DetachableJoint", "<parent_link>b</parent_link><child_model>x</child_model>")
    one = reading(model(TIPPED + held))
    assert one.description is None
    assert any("DetachableJoint" in each and "<parent_link>b, <child_model>x" in each for each in said(one))
    assert reading(model(TIPPED + held), lenient=True).description is not None
    driven = reading(model(TIPPED + plugin("DiffDrive", "<left_joint>A</left_joint>")))
    assert said(driven) == ["plugin 'gz::sim::systems::DiffDrive', which names joint 'A', is not read"]
    assert reading(model(TIPPED + plugin("JointStatePublisher", "<joint_name>A</joint_name>"))).problems == ()
    elsewhere = reading(model(TIPPED + plugin("DetachableJoint", "<parent_link>z</parent_link>")))
    assert elsewhere.description is not None
    assert any("may hold or couple parts" in each for each in said(elsewhere))


@pytest.mark.parametrize(
    "name", ["closed_loop", "leo_gz_differential", "gazebo_disable_link", "SpringForce", "GearBox"]
)
def test_names_of_plugins_that_couple_are_doubts_where_they_name_parts(name: str, reading) -> None:
    assert [one.tolerable for one in reading(model(TIPPED + plugin(name, "<x>b</x>"))).problems] == [True]
    assert [one.severity for one in reading(model(TIPPED + plugin(name, "<x>y</x>"))).problems] == ["warning"]


@pytest.mark.parametrize(
    "name", ["differential_drive", "LandingGear", "wheel_slip", "gazebo_grasp_fix", "closest_camera"]
)
def test_harmless_plugins_are_not_refused(name: str, reading) -> None:
    one = reading(model(TIPPED + plugin(name, '<link>b</link><wheel link_name="a"/><joint>A</joint>')))
    assert one.description is not None


def test_a_detachable_joint_within_the_robot_holds(reading) -> None:
    inside = "<parent_link>a</parent_link><child_model>robot</child_model><child_link>b</child_link>"
    robot = reading(model(TIPPED + plugin("DetachableJoint", inside))).description
    assert ClosedChain(robot).mobility().mobility == 0


def test_elements_of_drake_that_act_are_refused(reading) -> None:
    for inside in ("<drake:linear_bushing_rpy/>", "<drake:ball_constraint/>", '<drake:joint name="x" type="planar"/>'):
        for declared in (' xmlns:drake="http://drake.mit.edu"', ""):
            one = reading(model(TIPPED + inside).replace("<sdf", f"<sdf{declared}"))
            assert one.description is None
            assert any(inside.split()[0].strip("</>") in each for each in said(one)), said(one)
    rotor = "<drake:rotor_inertia>2e-5</drake:rotor_inertia><drake:gear_ratio>50</drake:gear_ratio>"
    found = reading(model(BASE + joint("J", "a", "b", more=rotor))).description.joint("J").physics
    assert (found.rotor, found.gear) == (2e-5, 50.0)


# -- which joints close loops ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["A", "B", "C", "D"])
def test_the_file_may_say_which_joint_closes_the_loop(name: str, reading) -> None:
    flag = "<physics><simbody><must_be_loop_joint>true</must_be_loop_joint></simbody></physics>"
    at = TIPPED.index(f'<joint name="{name}"')
    end = TIPPED.index("</joint>", at)
    robot = reading(model(TIPPED[:end] + flag + TIPPED[end:])).description
    assert [(cut.name, cut.type) for cut in robot.cuts] == [(name, CutType.REVOLUTE)]
    assert ClosedChain(robot).mobility().mobility == 1


def test_limits_of_a_joint_that_closes_a_loop_are_told(reading) -> None:
    one = reading(model(SQUARE + joint("D", "b", "c", axis=RANGE, more=TIP)))
    assert said(one) == ["limits of joint 'D', which closes a loop, are not used"]


def test_couplings_of_a_joint_that_must_close_a_loop_are_refused(reading) -> None:
    flag = "<physics><simbody><must_be_loop_joint>1</must_be_loop_joint></simbody></physics>"
    one = reading(model(SQUARE + joint("D", "b", "c", axis='<mimic joint="A"/>', more=TIP + flag)))
    assert one.description is not None  # what is coupled stays in the tree, and another joint is cut
    both = TIPPED.replace("</axis>", '<mimic joint="Z"/></axis>') + link("z") + joint("Z", "a", "z")
    refused = reading(model(both))
    assert refused.description is None
    assert any("which closes a loop" in each for each in said(refused)), said(refused)
