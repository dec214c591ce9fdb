"""SDF: poses of links in their model, links with several parents, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cutjoint.description import CutType, JointType, load_description, read_checked
from cutjoint.description.transforms import inverse, placement

MODEL = (Path(__file__).parent / "samples" / "fourbar.sdf").read_text(encoding="utf-8")

WORLDS = {
    "ground": placement((0, 0, 0.5), (0, 0, 0.3)),
    "rocker": placement((0.5, 0.1, 0.5), (0, np.pi / 2, 0)),
}
WORLDS["crank"] = WORLDS["ground"] @ placement((0.1, 0, 0), (0.2, 0, 0))
WORLDS["coupler"] = WORLDS["crank"] @ placement((0.2, 0, 0))
TIP = WORLDS["rocker"] @ placement((0, 0, 0.2)) @ placement((0.1, 0, 0))


@pytest.fixture
def sdf(tmp_path: Path):
    def write(*edits: tuple[str, str]) -> Path:
        text = MODEL
        for old, new in edits:
            assert old in text, old
            text = text.replace(old, new, 1)
        path = tmp_path / "model.sdf"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_links_are_where_their_poses_say(sdf, forward) -> None:
    world = forward(load_description(sdf()), {})
    for name, expected in WORLDS.items():
        np.testing.assert_allclose(world[name], expected, atol=1e-15, err_msg=name)


def test_the_second_parent_becomes_a_cut(sdf, forward) -> None:
    robot = load_description(sdf())
    (cut,) = robot.cuts
    assert (cut.name, cut.type, cut.a.link, cut.b.link) == ("tip", CutType.REVOLUTE, "coupler", "rocker")
    world = forward(robot, {})
    for frame in (cut.a, cut.b):
        at = world[frame.link] @ frame.placement
        np.testing.assert_allclose(at[:3, 3], TIP[:3, 3], atol=1e-15)
        np.testing.assert_allclose(at[:3, 2], TIP[:3, 1], atol=1e-15)  # the axis of the joint is its y


def test_joints_away_from_their_link_turn_it_about_their_own_point(sdf, forward) -> None:
    robot = load_description(sdf())
    joint = WORLDS["coupler"] @ placement((0, 0, -0.1), (0, 0.3, 0))
    axis = robot.joint("coupler_turn").axis
    np.testing.assert_allclose(joint[:3, :3] @ axis, [0, 0, 1], atol=1e-15)  # expressed in the model
    moved = forward(robot, {"coupler_turn": 0.7})["coupler"]
    cosine, sine = np.cos(0.7), np.sin(0.7)
    about = np.eye(4)
    about[:2, :2] = [[cosine, -sine], [sine, cosine]]
    about[:3, 3] = joint[:3, 3] - about[:3, :3] @ joint[:3, 3]
    np.testing.assert_allclose(moved, about @ WORLDS["coupler"], atol=1e-15)


def test_inertia_limits_and_shapes(sdf) -> None:
    robot = load_description(sdf())
    inertial = robot.link("crank").inertial
    assert (inertial.mass, inertial.com.tolist()) == (2.0, [0.1, 0.2, 0.3])
    np.testing.assert_allclose(inertial.inertia, [[2, -0.1, 0], [-0.1, 1, 0], [0, 0, 2.5]], atol=1e-15)
    joint = robot.joint("crank_turn")
    limits = joint.limits
    assert (limits.lower, limits.upper, limits.velocity, limits.effort) == (-2.0, None, 3.0, None)
    assert (joint.physics.damping, joint.physics.friction) == (0.5, 0.25)
    (shape,) = robot.link("crank").visuals
    assert (shape.kind, shape.size, shape.colour) == ("cylinder", (0.1, 0.4), (0.1, 0.2, 0.3, 1.0))


def test_without_a_joint_to_the_world_the_base_floats_unless_static(sdf) -> None:
    weld = '<joint name="weld" type="fixed"><parent>world</parent><child>ground</child></joint>'
    robot = load_description(sdf((weld, "")))
    assert robot.root == "world"
    assert robot.joint("root_joint").type is JointType.FLOATING
    static = load_description(sdf((weld, "<static>true</static>")))
    assert static.root == "ground"
    assert all(joint.type is not JointType.FLOATING for joint in static.joints)


def test_a_joint_is_turned_round_where_only_its_parent_hangs_in_the_air(sdf, forward) -> None:
    """The rocker as a parent only: it is reached through the tip, backwards, and the rest still closes the loop."""
    ground = "<parent>ground</parent><child>rocker</child>"
    tip = "<parent>coupler</parent><child>rocker</child>"
    edits = (
        (ground, "<parent>rocker</parent><child>ground</child>"),
        (tip, "<parent>rocker</parent><child>coupler</child>"),
    )
    robot = load_description(sdf(*edits, ('<pose relative_to="corner">', '<pose relative_to="rocker">')))
    assert len(robot.cuts) == 1
    assert {joint.child for joint in robot.joints} >= {"ground", "crank", "coupler", "rocker"}
    world = forward(robot, {})
    for name, expected in WORLDS.items():
        np.testing.assert_allclose(world[name], expected, atol=1e-14, err_msg=name)
    backwards = next(joint for joint in robot.joints if joint.name == "rocker_turn")
    assert (backwards.parent, backwards.child.split("_at_")[0]) == ("ground", "rocker")
    angle = 0.4
    turned = forward(robot, {"rocker_turn": angle})
    motion = np.eye(4)
    motion[1:3, 1:3] = [
        [np.cos(angle), -np.sin(angle)],
        [np.sin(angle), np.cos(angle)],
    ]  # about x of its child, the ground
    expected = inverse(WORLDS["rocker"]) @ WORLDS["ground"] @ motion
    np.testing.assert_allclose(inverse(turned["rocker"]) @ turned["ground"], expected, atol=1e-14)


def test_old_versions_give_axes_in_the_model(sdf) -> None:
    text = sdf().read_text().replace('version="1.7"', 'version="1.4"').replace(' expressed_in="__model__"', "")
    sdf().write_text(text)
    path = sdf()
    path.write_text(text)
    robot = load_description(path)
    joint = WORLDS["rocker"]
    np.testing.assert_allclose(joint[:3, :3] @ robot.joint("rocker_turn").axis, [1, 0, 0], atol=1e-15)


def test_cassie_loads_with_its_loops() -> None:
    robot = load_description("cassie")
    assert len(robot.cuts) == 4
    assert {cut.type for cut in robot.cuts} == {CutType.SPHERICAL}
    assert robot.root == "world"
    assert sum(link.inertial.mass for link in robot.links if link.inertial) == pytest.approx(33.3, abs=1.0)


BAD = {
    "not sdf": ([("<sdf ", "<sfd "), ("</sdf>", "</sfd>")], "the root element is <sfd>", "<sdf>"),
    "two models": ([("</sdf>", '<model name="b"><link name="x"/></model></sdf>')], "2 models: fourbar, b", "one model"),
    "no links": (
        [(MODEL[MODEL.index("    <link") : MODEL.index("  </model>")], "")],
        "a model without links",
        "<link>",
    ),
    "include": ([("</model>", "<include><uri>x</uri></include></model>")], "model 'x' of an <include> not found", "x"),
    "joint type": ([('"tip" type="revolute"', '"tip" type="piston"')], "type 'piston' of joint 'tip'", "universal"),
    "unknown parent": (
        [("<parent>coupler</parent>", "<parent>copler</parent>")],
        "parent of joint 'tip' is the unknown frame 'copler'",
        "link",
    ),
    "no child": ([("<child>rocker</child><axis>", "<axis>")], "joint 'rocker_turn' without child", "link"),
    "pose with five numbers": ([("0 0 0.5 0 0 0.3", "0 0 0.5 0 0")], "pose of link 'ground': 5 numbers", "6 numbers"),
    "unknown frame": ([('relative_to="corner"', 'relative_to="conrer"')], "unknown frame 'conrer'", "frame"),
    "poses in a ring": (
        [("<pose>0 0 0.5 0 0 0.3</pose>", '<pose relative_to="crank">0 0 0 0 0 0</pose>')],
        "is relative to itself",
        "ring",
    ),
    "zero axis": ([("<xyz>0 1 0</xyz>", "<xyz>0 0 0</xyz>")], "axis of joint 'tip' is 0 0 0", "direction"),
    "no axis": ([("<axis><xyz>0 1 0</xyz></axis>", "")], "joint 'tip' without <axis>", "<axis>"),
    "universal with one axis": ([('"tip" type="revolute"', '"tip" type="universal"')], "without <axis2>", "<xyz>"),
    "limit text": (
        [("<lower>-2</lower>", "<lower>low</lower>")],
        "lower limit of joint 'crank_turn' is 'low'",
        "number",
    ),
    "mass text": ([("<mass>2</mass>", "<mass>two</mass>")], "mass of link 'crank': 'two'", "number"),
    "negative mass": ([("<mass>2</mass>", "<mass>-2</mass>")], "mass of link 'crank' is -2 kg", ">= 0"),
    "impossible inertia": ([("<izz>2.5</izz>", "<izz>9</izz>")], "breaks the triangle inequality", "sum"),
    "limits upside down": ([("<upper>1e16</upper>", "<upper>-3</upper>")], "upside down: -2 to -3", "lower <= upper"),
    "missing mesh": (
        [("<cylinder><radius>0.1</radius><length>0.4</length></cylinder>", "<mesh><uri>model://no/x.stl</uri></mesh>")],
        "mesh 'model://no/x.stl' in <visual> of link 'crank' not found",
        "such as",
    ),
    "typing error": (
        [("<inertial>", "<inertail>"), ("</inertial>", "</inertail>")],
        "unknown element <inertail>",
        "inertial",
    ),
    "planar loop": ([('"tip" type="revolute"', '"tip" type="planar"')], "type 'planar' of joint 'tip'", "one of"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input(case: str, sdf) -> None:
    edits, found, expected = BAD[case]
    reading = read_checked(sdf(*edits))
    assert reading.description is None
    hits = [one for one in reading.problems if found in one.found and expected in one.expected]
    assert hits, [str(one) for one in reading.problems]
    assert hits[0].severity == "error"
    assert hits[0].line
