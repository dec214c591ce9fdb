"""What stands beside the tree of a URDF and joins, couples or acts on its parts: read, or quoted in an error."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.description import CutType, JointType, check, load_description, read_checked
from cutjoint.description.formats.urdf import expanded
from cutjoint.errors import Problem

END = "</robot>"
BODY = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
Read = Callable[..., tuple[object, list[Problem], list[Problem]]]


def hinge(name: str, parent: str, child: str, inside: str = "", kind: str = "continuous") -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="0.2 0 0"/><axis xyz="0 0 1"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{inside}</joint>'


TREE = "".join(f'<link name="{name}">{BODY if name != "o" else ""}</link>' for name in "oabc")
TREE += hinge("oa", "o", "a") + hinge("ab", "a", "b") + hinge("oc", "o", "c")


@pytest.fixture
def read(tmp_path: Path) -> Read:
    """read(extra, ...) -> description, errors, warnings of a URDF with links o, a, b, c and joints oa, ab, oc."""

    def reading(extra: str = "", tree: str = TREE, lenient: bool = False) -> tuple[object, list, list]:
        path = tmp_path / "robot.urdf"
        path.write_text(f'<robot name="r" xmlns:drake="http://drake.mit.edu">{tree}{extra}{END}', encoding="utf-8")
        found = read_checked(path, lenient)
        errors = [one for one in found.problems if one.severity == "error"]
        return found.description, errors, [one for one in found.problems if one.severity != "error"]

    return reading


def plugin(inside: str, name: str = "p", file: str = "libroboticsgroup_gazebo_mimic_joint_plugin.so") -> str:
    return f'<gazebo><plugin name="{name}" filename="{file}">{inside}</plugin></gazebo>'


MIMIC = "<joint>oa</joint><mimicJoint>oc</mimicJoint><multiplier>-2</multiplier><offset>0.5</offset>"


def test_a_mimic_plugin_is_a_coupling(read: Read) -> None:
    robot, errors, _ = read(plugin(MIMIC))
    assert not errors
    (coupling,) = robot.couplings
    assert (coupling.joint, coupling.gear, coupling.offset) == ("oc", ("oa", -2.0), 0.5)
    assert robot.actuators == ("oa", "ab")


def test_a_mimic_plugin_may_repeat_a_mimic_and_not_contradict_it(read: Read) -> None:
    both = TREE.replace("</joint>", '<mimic joint="oa" multiplier="-2" offset="0.5"/></joint>')
    both = both.replace('<mimic joint="oa" multiplier="-2" offset="0.5"/></joint>', "</joint>", 2)
    robot, errors, _ = read(plugin(MIMIC), both)
    assert not errors
    assert len(robot.couplings) == 1
    _, errors, _ = read(plugin(MIMIC.replace("-2", "2")), both)
    assert "oc = 2 oa + 0.5" in errors[0].found
    assert "oc = -2 oa + 0.5" in errors[0].found
    robot, errors, _ = read(plugin(MIMIC.replace("-2", "2")), both, lenient=True)
    assert [coupling.formula for coupling in robot.couplings] == ["oc = -2 oa + 0.5"]


def test_a_mimic_of_ros2_control_is_a_coupling(read: Read) -> None:
    params = '<param name="mimic">oa</param><param name="multiplier">3</param>'
    robot, errors, _ = read(f'<ros2_control name="s" type="system"><joint name="oc">{params}</joint></ros2_control>')
    assert not errors
    assert robot.couplings[0].formula == "oc = 3 oa"


GZ = "gz-sim-detachable-joint-system"
ATTACHED = "<parent_link>b</parent_link><child_model>r</child_model><child_link>c</child_link>"


def test_a_detachable_joint_within_the_robot_holds(read: Read) -> None:
    robot, errors, _ = read(plugin(ATTACHED, "gz::sim::systems::DetachableJoint", GZ))
    assert not errors
    (cut,) = robot.cuts
    assert (cut.type, cut.a.link, cut.b.link) == (CutType.FIXED, "b", "c")
    np.testing.assert_allclose(cut.a.placement[:3, 3], [-0.2, 0.0, 0.0], atol=1e-15)


@pytest.mark.parametrize(
    ("extra", "said"),
    [
        (plugin(ATTACHED.replace(">r<", ">box<"), "gz::sim::systems::DetachableJoint", GZ), "<child_model>box"),
        (plugin("<link1>a</link1>", "close_it", "libclosed_loop_plugin.so"), "libclosed_loop_plugin.so"),
        (plugin("<jointA>a</jointA>", "p", "libgazebo_constraint.so"), "<jointA>a"),
        ('<gazebo><model name="box"/></gazebo>', "<model> 'box'"),
        ("<drake:linear_spring_damper/>", "<drake:linear_spring_damper>"),
        ('<closure first="a" second="c"/>', "<closure> names a, c"),
        ('<my:pair xmlns:my="urn:my"><one>a</one><two>c</two></my:pair>', "<pair> names a, c"),
        ('<transmission name="g"><passive_joint name="oc"/></transmission>', "couples oc to its motor"),
        ("<mujoco><equality/></mujoco>", "<equality> in the <mujoco>"),
        ('<link name="closing_x_1"/>' + hinge("x", "b", "closing_x_1", kind="fixed"), "without 'closing_x_2'"),
    ],
)
def test_what_may_join_or_couple_is_quoted_and_passes_where_lenient(extra: str, said: str, read: Read) -> None:
    robot, errors, _ = read(extra)
    assert robot is None
    assert [one for one in errors if said in one.found and one.tolerable]
    robot, errors, warnings = read(extra, lenient=True)
    assert not errors
    assert [one for one in warnings if said in one.found]


JOINT = "<parent>b</parent><child>c</child>"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f'<joint name="t" type="screw">{JOINT}<axis/><thread_pitch>0</thread_pitch></joint>', "is 0"),
        (f'<joint name="t" type="gearbox">{JOINT}</joint>', "type 'gearbox' of the joint 't'"),
        (f'<joint name="t" type="revolute">{JOINT}</joint>', "without <axis>"),
        ('<joint name="t" type="ball"><parent>b</parent><child>d</child></joint>', "frame 'd'"),
        ('<joint name="t" type="ball"><parent>b</parent><child>b</child></joint>', "both ends"),
        (f'<joint name="t" type="ball">{JOINT}<pose relative_to="oo">0 0 0 0 0 0</pose></joint>', "frame 'oo'"),
        (f'<joint name="t" type="revolute">{JOINT}<axis><xzy>0 0 1</xzy></axis></joint>', "<xzy> in <axis>"),
    ],
)
def test_a_joint_in_gazebo_that_cannot_be_is_refused(text: str, said: str, read: Read) -> None:
    _, errors, _ = read(f"<gazebo>{text}</gazebo>")
    assert [one for one in errors if said in one.found and not one.tolerable], errors
    assert read(f"<gazebo>{text}</gazebo>", lenient=True)[0] is None


def test_a_joint_in_gazebo_with_a_reference_is_refused(read: Read) -> None:
    _, errors, _ = read(f'<gazebo reference="b"><joint name="t" type="ball">{JOINT}</joint></gazebo>')
    assert "Gazebo leaves out" in errors[0].expected


def test_links_in_gazebo_hang_on_joints_there(read: Read) -> None:
    rod = '<link name="d"><pose>0.6 0 0 0 0 0</pose><inertial><mass>2</mass></inertial></link>'
    text = '<joint name="{}" type="revolute"><pose>{} 0 0 0 0</pose>{}<axis><xyz>0 0 1</xyz></axis></joint>'
    first = text.format("t", "0.1 0.05", "<parent>d</parent><child>b</child>")
    last = text.format("oa", "0.1 0.1", "<parent>r::d</parent><child>c</child>")
    robot, errors, _ = read(f"<gazebo>{rod}{first}</gazebo><gazebo>{last}</gazebo>")
    assert not errors
    assert [cut.name for cut in robot.cuts] == ["oa"]
    assert robot.link("d").inertial.mass == 2.0
    chain = ClosedChain(robot)
    assert (chain.mobility().velocities, chain.mobility().mobility) == (4, 2)
    at = chain.link_placements(chain.home.q_full)
    np.testing.assert_allclose([at["d"][0, 3], at["c"][0, 3]], [0.6, 0.2], atol=1e-15)
    assert "2 root links" in read(f"<gazebo>{rod}</gazebo>")[1][0].found


def test_a_driven_or_mimicking_joint_in_gazebo_keeps_its_coordinate(read: Read) -> None:
    axis = "<axis><xyz>0 0 1</xyz>{}</axis>"
    text = '<gazebo><joint name="t" type="revolute"><parent>b</parent><child>c</child>{}</joint></gazebo>'
    robot, errors, _ = read(text.format(axis.format('<mimic joint="oa"><multiplier>2</multiplier></mimic>')))
    assert not errors
    assert [coupling.formula for coupling in robot.couplings] == ["t = 2 oa"]
    assert [(cut.name, cut.type) for cut in robot.cuts] == [("t_end", CutType.FIXED)]
    driven = '<transmission name="m"><joint name="t"/></transmission>'
    robot, errors, _ = read(text.format(axis.format("")) + driven)
    assert not errors
    assert robot.actuators == ("t",)
    assert ClosedChain(robot).mobility().determined


def test_the_world_is_the_root(read: Read) -> None:
    text = '<gazebo><joint name="t" type="{}"><parent>world</parent><child>{}</child></joint></gazebo>'
    robot, errors, warnings = read(text.format("fixed", "o"))
    assert not errors
    assert not robot.cuts
    assert "the root of a URDF is fixed" in warnings[0].expected
    robot, errors, _ = read(text.format("ball", "b"))
    assert not errors
    assert (robot.cuts[0].a.link, robot.cuts[0].b.link) == ("o", "b")
    np.testing.assert_allclose(robot.cuts[0].a.placement[:3, 3], [0.4, 0.0, 0.0], atol=1e-15)


def test_springs_of_gazebo_act(read: Read) -> None:
    spring = (
        '<gazebo reference="oa"><springStiffness>3</springStiffness><springReference>0.1</springReference></gazebo>'
    )
    robot, errors, _ = read(spring)
    assert not errors
    assert (robot.joint("oa").physics.stiffness, robot.joint("oa").physics.rest) == (3.0, 0.1)


@pytest.mark.parametrize("tag", ["<turnGravityOff>true</turnGravityOff>", "<gravity>0</gravity>", "<inertial/>"])
def test_what_gazebo_changes_otherwise_is_told(tag: str, read: Read) -> None:
    _, errors, warnings = read(f'<gazebo reference="a">{tag}<mu1>0.2</mu1><selfCollide>true</selfCollide></gazebo>')
    assert not errors
    assert len(warnings) == 1
    assert "is not used" in warnings[0].found


def test_a_second_parent_closes_a_loop(read: Read) -> None:
    limits = '<limit lower="-1" upper="1" effort="3" velocity="2"/><dynamics damping="0.3"/>'
    robot, errors, warnings = read(hinge("cb", "c", "b", limits, "revolute"))
    assert not errors
    (cut,) = robot.cuts
    assert (cut.name, cut.type, cut.a.link, cut.b.link) == ("cb", CutType.REVOLUTE, "c", "b")
    assert cut.physics.damping == 0.3
    np.testing.assert_allclose(cut.a.placement[:3, 3], [0.2, 0.0, 0.0])
    told = " ".join(one.found for one in warnings)
    assert "'b' has 2 parents" in told
    assert "limits of joint 'cb'" in told


def test_a_driven_joint_stays_in_the_tree(read: Read) -> None:
    motor = '<transmission name="m"><joint name="cb"/></transmission>'
    robot, errors, _ = read(hinge("cb", "c", "b") + motor)
    assert not errors
    assert [cut.name for cut in robot.cuts] == ["ab"]
    assert robot.actuators == ("cb",)


def test_a_tree_is_found_where_first_parents_are_a_ring(read: Read) -> None:
    tree = "".join(f'<link name="{name}"/>' for name in "oab")
    tree += hinge("ba", "b", "a") + hinge("ab", "a", "b") + hinge("oa", "o", "a")
    robot, errors, _ = read("", tree)
    assert not errors
    assert [cut.name for cut in robot.cuts] == ["ba"]


def test_a_second_joint_that_holds_too_little_is_refused(read: Read) -> None:
    _, errors, _ = read(hinge("cb", "c", "b", kind="floating"))
    assert "of type floating closes a loop" in errors[0].found


def test_a_loops_toml_keeps_the_loops_of_its_urdf(read: Read, tmp_path: Path) -> None:
    frames = "".join(
        f'<link name="closing_t_{n}"/>' + hinge(f"f{n}", link, f"closing_t_{n}", kind="fixed")
        for n, link in ((1, "b"), (2, "c"))
    )
    read(f'{frames}<gazebo><joint name="t" type="ball">{JOINT}</joint></gazebo>')
    (tmp_path / "loops.toml").write_text('schema = 1\nurdf = "robot.urdf"\nactuators = ["oa"]\n', encoding="utf-8")
    robot = load_description(tmp_path)
    assert [cut.name for cut in robot.cuts] == ["t", "closing_t"]
    assert [one for one in check(tmp_path) if "'closing_t_1' and 'closing_t_2' are held together" in one.found]
    with (tmp_path / "loops.toml").open("a", encoding="utf-8") as file:
        file.write('[[cut]]\nname = "own"\ntype = "fixed"\nframes = ["closing_t_2", "closing_t_1"]\n')
    assert [cut.name for cut in load_description(tmp_path).cuts] == ["own", "t"]
    assert not [one for one in check(tmp_path) if "held together" in one.found]


# -- Drake -----------------------------------------------------------------------------------------------


def bushing(force: str, torque: str, damping: str = "0 0 0") -> str:
    values = {"force_stiffness": force, "force_damping": "2 2 2", "torque_stiffness": torque, "torque_damping": damping}
    parts = "".join(f'<drake:bushing_{name} value="{value}"/>' for name, value in values.items())
    ends = '<drake:bushing_frameA name="f"/><drake:bushing_frameC name="c"/>'
    return f'<frame name="f" link="b" xyz="0.1 0 0"/><drake:linear_bushing_rpy>{ends}{parts}</drake:linear_bushing_rpy>'


@pytest.mark.parametrize(
    ("torque", "damping", "kind", "turning"),
    [
        ("0 0 0", "0 0 0", CutType.SPHERICAL, (0.0, 0.0)),
        ("5 5 5", "1 1 1", CutType.FIXED, (5.0, 1.0)),
        ("5 0 5", "1 0 1", CutType.REVOLUTE, (5.0, 1.0)),
    ],
)
def test_bushings(torque: str, damping: str, kind: CutType, turning: tuple[float, float], read: Read) -> None:
    robot, errors, warnings = read(bushing("9 9 9", torque, damping))
    assert not errors
    (cut,) = robot.cuts
    assert (cut.type, cut.a.link, cut.bushing.stiffness, cut.bushing.damping) == (kind, "b", 9.0, 2.0)
    assert (cut.bushing.turning_stiffness, cut.bushing.turning_damping) == turning
    assert bool([one for one in warnings if "small turns" in one.found]) == (kind is not CutType.SPHERICAL)
    if kind is CutType.REVOLUTE:
        for frame in (cut.a, cut.b):
            np.testing.assert_allclose(frame.placement[:3, 2], [0.0, 1.0, 0.0], atol=1e-15)


@pytest.mark.parametrize(
    ("force", "torque"), [("9 9 8", "0 0 0"), ("9 9 9", "1 2 0"), ("9 9 9", "1 0 0"), ("0 0 0", "1 1 1")]
)
def test_bushings_that_are_not_the_same_in_all_directions_are_quoted(force: str, torque: str, read: Read) -> None:
    _, errors, _ = read(bushing(force, torque))
    assert f"={force}" in errors[0].found
    assert f"={torque}" in errors[0].found


def tendon(inside: str) -> str:
    joints = '<drake:tendon_constraint_joint name="oa" a="2"/><drake:tendon_constraint_joint name="oc" a="-4"/>'
    return f"<drake:tendon_constraint>{joints}{inside}</drake:tendon_constraint>"


def test_a_rigid_tendon_couples(read: Read) -> None:
    limits = "".join(f'<drake:tendon_constraint_{end}_limit value="1"/>' for end in ("lower", "upper"))
    robot, errors, _ = read(tendon(limits + '<drake:tendon_constraint_offset value="3"/>'))
    assert not errors
    (coupling,) = robot.couplings  # 2 oa - 4 oc + 3 = 1
    assert (coupling.joint, coupling.gear, coupling.offset) == ("oc", ("oa", 0.5), 0.5)
    _, errors, _ = read(tendon(limits + '<drake:tendon_constraint_stiffness value="3"/>'))
    assert "tendon_constraint_stiffness=3" in errors[0].found
    _, errors, _ = read(tendon('<drake:tendon_constraint_lower_limit value="1"/>'))
    assert errors


@pytest.mark.parametrize(
    ("kind", "read_as"),
    [("ball", JointType.SPHERICAL), ("universal", JointType.UNIVERSAL), ("planar", JointType.PLANAR)],
)
def test_joints_of_drake(kind: str, read_as: JointType, read: Read) -> None:
    text = f'<link name="d">{BODY}</link>' + hinge("od", "o", "d", kind=kind).replace("joint ", "drake:joint ", 1)
    robot, errors, _ = read(text.replace("</joint>", "</drake:joint>"))
    assert not errors
    joint = robot.joint("od")
    assert joint.type is read_as
    np.testing.assert_array_equal(joint.axis, [0.0, 0.0, 1.0] if kind == "planar" else [1.0, 0.0, 0.0])
    np.testing.assert_array_equal(joint.axis2, [0.0, 1.0, 0.0])


def test_the_world_need_not_be_a_link_and_what_hangs_on_nothing_floats(read: Read) -> None:
    tree = TREE.replace('<link name="o"></link>', f'<link name="free">{BODY}</link>').replace('"o"', '"world"')
    robot, errors, warnings = read(tree=tree)
    assert not errors
    assert robot.root == "world"
    assert [(one.name, one.type) for one in robot.joints[3:]] == [("free_root_joint", JointType.FLOATING)]
    assert ["hangs on 'world'" in warnings[0].found, "'free'" in warnings[1].found] == [True, True]
    assert "parent 'world' of joint 'oa' is not a link" in read(tree=tree.replace('"free"', '"wolrd"'))[1][0].found
    known = tree + '<link name="world"/>'
    assert "2 root links" in read(tree=known)[1][0].found
    assert not read("<drake:collision_filter_group/>", known)[1]


def test_the_namespace_of_drake_may_be_the_default(read: Read, tmp_path: Path) -> None:
    robot, _, told = read()
    text = (tmp_path / "robot.urdf").read_text(encoding="utf-8")
    (tmp_path / "robot.urdf").write_text(text.replace("xmlns:drake", "xmlns"), encoding="utf-8")
    found = read_checked(tmp_path / "robot.urdf")
    assert list(found.problems) == told
    assert [joint.name for joint in found.description.joints] == [joint.name for joint in robot.joints]


def test_a_robot_without_links_is_an_error(read: Read) -> None:
    robot, errors, _ = read(tree="", lenient=True)
    assert robot is None
    assert [one.found for one in errors] == ["a robot without links"]


# -- sums of URDF+ ---------------------------------------------------------------------------------------


def belt(inside: str, *dependent: str) -> tuple[str, str]:
    tree = TREE
    for name in dependent:
        tree = tree.replace(f'<joint name="{name}"', f'<joint independent="false" name="{name}"')
    return f'<coupling name="belt">{inside}<ratio value="8"/></coupling>', tree


@pytest.mark.parametrize(
    ("dependent", "joint", "ratios"),
    [
        ("oc", "oc", {"oa": 8.0, "ab": 8.0}),
        ("ab", "ab", {"oa": -1.0, "oc": 0.125}),
        ("oa", "oa", {"ab": -1.0, "oc": 0.125}),
    ],
)
def test_a_coupling_sums_both_sides(dependent: str, joint: str, ratios: dict[str, float], read: Read) -> None:
    """8 (oa + ab) = oc, whichever follows."""
    robot, errors, _ = read(*belt('<predecessor link="b"/><successor link="c"/>', dependent))
    assert not errors
    (coupling,) = robot.couplings
    assert (coupling.joint, dict(coupling.ratios)) == (joint, ratios)
    assert set(robot.actuators) == {"oa", "ab", "oc"} - {dependent}


def test_couplings_that_share_joints_get_followers_of_their_own(read: Read) -> None:
    two, tree = belt('<predecessor link="b"/><successor link="c"/>', "oc", "ab")
    robot, errors, _ = read(two + two.replace("belt", "second").replace('"b"', '"a"'), tree)
    assert not errors
    assert {one.name: one.joint for one in robot.couplings} == {"belt": "ab", "second": "oc"}


def test_joints_that_depend_on_nothing_in_the_file_are_told(read: Read) -> None:
    _, tree = belt("", "oc")
    _, errors, _ = read("", tree)
    assert "oc" in errors[0].found
    assert errors[0].tolerable


# -- what does not matter to motion ----------------------------------------------------------------------


@pytest.mark.parametrize(
    "shape",
    [
        '<visual><geometry><sphere radius="round"/></geometry></visual>',
        '<visual><geometry><sphere radius="-1"/></geometry></visual>',
        "<collision/>",
        '<visual><geometry><box size="1 1 1"/><box size="1 1 1"/></geometry></visual>',
        '<visual><origin xzy="0 0 0"/><geometry><box size="1 1 1"/></geometry></visual>',
        '<visual><geometry><box size="1 1 1"/></geometry><material name="m"><color rgba="2 0"/></material></visual>',
        '<visual><geometry><mesh filename="none.stl"/></geometry></visual>',
    ],
)
def test_a_bad_shape_blocks_only_where_strict(shape: str, read: Read) -> None:
    tree = TREE.replace('<link name="a">', f'<link name="a">{shape}', 1)
    robot, errors, _ = read("", tree)
    assert robot is None
    assert all(one.tolerable for one in errors)
    robot, errors, warnings = read("", tree, lenient=True)
    assert robot is not None
    assert not errors
    assert warnings


# -- xacro -----------------------------------------------------------------------------------------------

XACRO = f"""<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:property name="half" value="0.1"/>
  <xacro:macro name="body" params="name"><link name="${{name}}">{BODY}</link></xacro:macro>
  <link name="o"/><xacro:body name="a"/><xacro:include filename="$(find parts)/more.xacro"/>
  <joint name="oa" type="continuous"><parent link="o"/><child link="a"/><origin xyz="${{2 * half}} 0 0"/></joint>
</robot>"""
MORE = f"""<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:body name="b"/>{hinge("ab", "a", "b")}
  {hinge("ob", "o", "b")}</robot>"""
installed = pytest.mark.skipif(find_spec("xacro") is None, reason="the package xacro is not installed")


def test_xacro_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(expanded, "is_installed", lambda name: False)
    (tmp_path / "r.xacro").write_text(XACRO, encoding="utf-8")
    problems = read_checked(tmp_path / "r.xacro").problems
    assert "pip install 'cutjoint[formats]'" in problems[0].mend
    assert "<xacro:property>" in problems[0].found


@installed
def test_xacro_is_expanded(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "more.xacro").write_text(MORE, encoding="utf-8")
    (tmp_path / "r.urdf.xacro").write_text(XACRO, encoding="utf-8")
    robot = load_description(tmp_path / "r.urdf.xacro")
    assert [link.name for link in robot.links] == ["o", "a", "b"]
    assert robot.joint("oa").placement[0, 3] == 0.2
    assert [cut.name for cut in robot.cuts] == ["ob"]


@installed
@pytest.mark.parametrize(
    ("inside", "said"),
    [
        ("<link name=\"${'x' * 10**10}\"/>", ""),
        ('<link name="$(arg side)"/>', "side"),
        ('<xacro:include filename="$(find nowhere)/x.xacro"/>', "nowhere"),
        ('<xacro:include filename="/dev/zero"/>', "regular file"),
        ('<xacro:include filename="r.xacro"/>', ""),
        ('<link name="${().__class__.__base__.__subclasses__()}"/>', "invalid name"),
    ],
)
def test_hostile_xacro_is_refused(inside: str, said: str, tmp_path: Path) -> None:
    text = f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{inside}</robot>'
    path = tmp_path / "r.xacro"
    path.write_text(text, encoding="utf-8")
    problems = read_checked(path).problems
    assert problems[0].severity == "error"
    assert "xacro" in problems[0].found
    assert said in problems[0].found


@installed
@pytest.mark.slow
def test_endless_xacro_is_ended(tmp_path: Path) -> None:
    test_hostile_xacro_is_refused('<link name="${sum(map(int, python.range(10**12)))}"/>', "", tmp_path)
