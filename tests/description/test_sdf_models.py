"""SDF: which models are the robot, models in models, included models, frames, and what all of them can get wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kit.sdf_text import SQUARE, TIP, joint, link, model, world

from cutjoint.chain import ClosedChain
from cutjoint.description import JointType, read_checked
from cutjoint.description.formats import Reading

GROUND = '<model name="ground"><static>true</static><link name="plane"/></model>'
TIPPED = SQUARE + joint("D", "c", "b", more=TIP)


@pytest.fixture
def reading(tmp_path: Path):
    def make(text: str, lenient: bool = False, **files: str) -> Reading:
        for name, inside in files.items():
            (tmp_path / name).mkdir(exist_ok=True)
            (tmp_path / name / "model.sdf").write_text(inside)
        (tmp_path / "model.sdf").write_text(text)
        return read_checked(tmp_path / "model.sdf", lenient)

    return make


def said(one: Reading) -> list[str]:
    return [problem.found for problem in one.problems]


def mobility(one: Reading) -> int:
    assert one.description is not None, said(one)
    return int(ClosedChain(one.description).mobility().mobility)


# -- frames ----------------------------------------------------------------------------------------------------------


def test_joints_between_frames_close_the_loop(reading) -> None:
    frames = '<frame name="end" attached_to="b"><pose>1 0 0 0 0 0</pose></frame>'
    frames += '<frame name="top" attached_to="c"><pose>1 0 0 0 0 0</pose></frame><frame name="tip" attached_to="top"/>'
    assert mobility(reading(model(SQUARE + frames + joint("D", "end", "tip")))) == 1


def test_the_world_may_be_the_child(reading) -> None:
    way = SQUARE.replace(joint("C", "world", "c"), joint("C", "b", "c", more=TIP))
    hung = reading(model(way + joint("D", "c", "world", more='<pose relative_to="c">0 0 0 0 0 0</pose>')))
    assert mobility(hung) == 1
    assert hung.description.cuts[0].name == "D"


def test_names_reach_into_models(reading) -> None:
    inner = (
        f'<model name="m"><pose>0 3 0 0 0 0</pose>{link("x")}<frame name="f"><pose>0 0 1 0 0 0</pose></frame></model>'
    )
    for name, wanted in (("m", 3), ("m::__model__", 3), ("m::f", 3), ("m::x", 3), ("__model__", 0)):
        outer = link("a").replace("<pose>", f'<pose relative_to="{name}">', 1)
        joints = reading(model(outer + inner + joint("J", "world", "a") + joint("K", "a", "m::f"))).description.joints
        at = next(one for one in joints if one.name == "J").placement[:3, 3]
        np.testing.assert_allclose(at, [0, wanted, 1 if name == "m::f" else 0], atol=1e-15)


def test_the_placement_frame_is_what_the_pose_places(reading) -> None:
    text = model(link("a", "0 0 1 0 0 0") + '<frame name="f" attached_to="a"><pose>0 2 0 0 0 0</pose></frame>')
    text = text.replace('name="robot">', 'name="robot" placement_frame="f"><pose>5 0 0 0 0 0</pose>')
    (base,) = reading(text).description.joints
    np.testing.assert_allclose(base.placement[:3, 3], [5, -2, 0], atol=1e-15)


@pytest.mark.parametrize(
    ("more", "found"),
    [
        (
            '<frame name="f" attached_to="g"/><frame name="g" attached_to="f"/>' + joint("D", "b", "f"),
            "attached to itself",
        ),
        (
            '<frame name="f"><pose relative_to="g"/></frame><frame name="g"><pose relative_to="f"/></frame>',
            "relative to it",
        ),
        (joint("D", "b", "nowhere"), "child of joint 'D' is the unknown frame 'nowhere'"),
        ('<frame name="f" attached_to="b"/>' + joint("D", "b", "f"), "both ends of joint 'D' are on 'b'"),
        ('<frame name="__model__"/>', "frame '__model__'"),
        ('<frame name="f"/><frame name="f"/>', "a second frame 'f' in one <model>"),
        (joint("D", "b", "c", "revolut"), "type 'revolut' of joint 'D'"),
        (joint("D", "b", "c", "piston"), "type 'piston' of joint 'D' is not supported"),
        ("<static>ture</static>", "<static> in <model> is 'ture'"),
        (
            joint("D", "b", "c", more='<pose rotation_format="quat_xyzw">0 0 0 0 0 0</pose>'),
            "pose of joint 'D': 6 numbers",
        ),
        (joint("D", "b", "c", more='<pose rotation_format="quat">0 0 0 0 0 0</pose>'), "rotation_format 'quat'"),
    ],
)
def test_bad_frames(more: str, found: str, reading) -> None:
    one = reading(model(TIPPED.replace('name="D"', 'name="E"') + more))
    assert one.description is None
    assert any(found in each for each in said(one)), said(one)


def test_numbers_may_be_empty_and_a_joint_of_old_be_called_world(reading) -> None:
    empty = "<limit><lower>-1</lower><upper>1</upper><effort/></limit><dynamics><damping></damping></dynamics>"
    text = TIPPED.replace("<xyz>0 0 1</xyz></axis>", f"<xyz>0 0 1</xyz>{empty}</axis>", 1)
    found = reading(model(text))
    told = ["effort limit of joint 'A' is empty: read as not given", "damping of joint 'A' is empty: read as not given"]
    assert said(found) == told
    assert (found.description.joint("A").limits.upper, found.description.joint("A").physics.damping) == (1.0, 0.0)
    named = TIPPED.replace('name="A"', 'name="world"')
    assert mobility(reading(model(named, version="1.6"))) == 1
    assert "joint 'world'" in said(reading(model(named)))


# -- which models are the robot --------------------------------------------------------------------------------------


def test_a_robot_beside_a_ground_plane(reading) -> None:
    one = reading(world(f'{GROUND}<model name="robot">{TIPPED}</model>'))
    assert mobility(one) == 1
    assert said(one) == ["left out beside the robot: ground, which no joint ties to it"]
    assert [link.name for link in one.description.links][:4] == ["world", "a", "b", "c"]


def test_two_robots_are_refused_with_a_way_out(reading) -> None:
    one = reading(world(f'<model name="one">{TIPPED}</model><model name="two">{TIPPED}</model>'))
    assert one.description is None
    (problem,) = one.problems
    assert problem.found == "2 models: one, two"
    assert "<static>" in problem.mend


def test_joints_of_the_world_tie_models_to_one_robot(reading) -> None:
    left = f'<model name="left">{SQUARE.replace(joint("C", "world", "c"), "").replace(link("c", TURNED), "")}</model>'
    right = f'<model name="right"><pose>1 0 0 0 0 1.5707963267948966</pose>{link("c")}</model>'
    ties = joint("C", "world", "right") + joint("D", "right::c", "left::b", more=TIP.replace("b", "left::b"))
    one = reading(world(GROUND + left + right + ties))
    assert mobility(one) == 1
    assert {each.name for each in one.description.links} >= {"left::a", "left::b", "right::c"}
    assert one.description.name == "lab"


TURNED = "0 0 0 0 0 1.5707963267948966".replace("0 0 0", "1 0 0", 1)


def test_static_models_that_are_tied_hold_still(reading) -> None:
    post = f'<model name="post"><static>1</static>{link("p", "0 0 1 0 0 0")}</model>'
    one = reading(world(post + f'<model name="arm">{link("a")}</model>' + joint("J", "post::p", "arm::a")))
    assert mobility(one) == 1
    assert one.description.joint("post::p_static").type is JointType.FIXED


def test_a_static_model_alone_is_a_robot_on_a_fixed_base_with_a_warning(reading) -> None:
    one = reading(model("<static>true</static>" + link("a") + link("b") + joint("J", "a", "b")))
    assert one.description.root == "a"
    assert said(one) == ["static model 'robot' with joints that move, which Gazebo holds too"]


def test_gravity_is_that_of_the_world(reading) -> None:
    robot = f'<model name="robot">{TIPPED}</model>'
    for inside, wanted in (
        ("", [0, 0, -9.8]),
        ("<gravity>1 2 3</gravity>", [1, 2, 3]),
        ('<physics type="ode"><gravity>0 0 -5</gravity></physics>', [0, 0, -5]),
    ):
        assert reading(world(inside + robot)).description.gravity.tolist() == wanted
    assert reading(model(TIPPED)).description.gravity.tolist() == [0, 0, -9.81]


def test_the_pose_of_the_model_counts(reading) -> None:
    tilted = model(f"<pose>0 0 0 1.5707963267948966 0 0</pose>{link('a')}{joint('J', 'world', 'a')}")
    chain = ClosedChain(reading(tilted).description)
    effort = chain.full_acceleration(chain.neutral, np.zeros(1), np.zeros(1))
    assert effort == pytest.approx([-9.81 * 0.5 / (0.084 + 0.25)], rel=1e-12)  # the axis lies, so the rod falls


# -- models in models ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("version", ["1.7", "1.10", "1.12"])
def test_versions_compare_by_their_numbers(version: str, reading) -> None:
    """The axis is along z of a joint that is turned by 90 degrees: of the joint, not of the model, since 1.5."""
    text = model(link("a", "0 0 0 1.5707963267948966 0 0") + joint("J", "world", "a"), version=version)
    found = reading(text).description.joint("J")
    np.testing.assert_allclose(found.axis, [0, 0, 1], atol=1e-15)
    old = reading(text.replace(version, "1.4")).description.joint("J")
    np.testing.assert_allclose(old.axis, [0, 1, 0], atol=1e-15)


def test_included_models_have_the_name_pose_and_hold_of_the_include(reading) -> None:
    arm = model(link("a") + link("b", "1 0 0 0 0 0") + joint("J", "a", "b"), "arm")
    held = arm.replace("<link", "<static>1</static><link", 1)
    said = "<include><uri>model://arm</uri><name>left</name><pose>0 0 2 0 0 0</pose>{}</include>"
    free = reading(model(said.format("<static>false</static>") + joint("W", "world", "left", "fixed")), arm=held)
    assert mobility(free) == 1
    assert free.description.joint("left::J").child == "left::b"
    np.testing.assert_allclose(free.description.joint("W").placement[:3, 3], [0, 0, 2])
    lone = link("z") + joint("Z", "world", "z")
    for inside, text in ((said.format("<static>true</static>"), arm), (said.format(""), held)):
        one = reading(model(lone + inside), arm=text)
        assert {each.name for each in one.description.joints} == {"Z", "left::a_static", "left::b_static"}


def test_a_model_config_names_the_newest_version(reading, tmp_path: Path) -> None:
    (tmp_path / "arm").mkdir()
    for order in ((4, 9, 10), (10, 9, 4)):
        named = "".join(f'<sdf version="1.{number}">{number}.sdf</sdf>' for number in order)
        (tmp_path / "arm" / "model.config").write_text(f"<model>{named}</model>")
        for number in order:
            (tmp_path / "arm" / f"{number}.sdf").write_text(model(link(f"l{number}"), "arm"))
        links = reading(model("<include><uri>model://arm</uri></include>")).description.links
        assert [each.name for each in links] == ["world", "arm::l10"]


def test_the_old_way_to_give_axes_is_a_doubt_in_new_files_and_not_used(reading) -> None:
    old = "<use_parent_model_frame>true</use_parent_model_frame>"
    text = model(link("a", "0 0 0 1.5707963267948966 0 0") + joint("J", "world", "a", axis=old))
    assert reading(text).description is None
    np.testing.assert_allclose(reading(text, lenient=True).description.joint("J").axis, [0, 0, 1], atol=1e-15)
    found = reading(text.replace('version="1.9"', 'version="1.6"')).description.joint("J")
    np.testing.assert_allclose(found.axis, [0, 1, 0], atol=1e-15)


def test_a_merged_model_shares_the_names(reading) -> None:
    arm = model(link("a") + link("b", "1 0 0 0 0 0") + joint("J", "a", "b"), "arm")
    include = '<include merge="true"><uri>arm</uri><pose>0 0 2 0 0 0</pose></include>'
    one = reading(model(include + joint("W", "world", "a", "fixed")), arm=arm)
    assert mobility(one) == 1
    np.testing.assert_allclose(one.description.joint("W").placement[:3, 3], [0, 0, 2])
    assert one.description.joint("J").parent == "a"


def test_the_canonical_link_of_a_model_that_merges_another_may_be_the_others(reading) -> None:
    arm, own = model(link("a"), "arm"), link("z", "0 0 1 0 0 0")
    include = '<include merge="true"><uri>arm</uri></include>'
    for inside, wanted in ((include + own, "a"), (own + include, "z")):
        one = reading(world(f'<model name="m">{inside}</model>' + joint("W", "world", "m", "fixed")), arm=arm)
        ends = [each for each in one.description.joints if each.name.startswith("W") or each.child == wanted]
        assert any(each.child.split("_at_")[0] == wanted for each in ends if each.name == "W")


def test_shapes_may_stand_in_any_frame(reading) -> None:
    shape = '<visual name="v"><pose relative_to="{}">0 0 1 0 0 0</pose>'
    shape += "<geometry><sphere><radius>1</radius></sphere></geometry>"
    for name, wanted in (("", [0, 0, 1]), ("f", [0, 2, 1]), ("__model__", [-5, 0, 1])):
        text = link("a", "5 0 0 0 0 0", shape.format(name) + "</visual>")
        frame = '<frame name="f" attached_to="a"><pose>0 2 0 0 0 0</pose></frame>'
        (found,) = reading(model(text + frame)).description.link("a").visuals
        np.testing.assert_allclose(found.placement[:3, 3], wanted, atol=1e-15)


def test_problems_of_an_included_file_name_it(reading) -> None:
    one = reading(model("<include><uri>arm</uri></include>"), arm=model(link("a").replace("mass", "mas")))
    hit = next(problem for problem in one.problems if "<mas>" in problem.found)
    assert hit.file.endswith("arm/model.sdf")
    assert hit.line == 1


def test_scenery_that_is_not_there_is_not_missed(reading) -> None:
    robot = f'<model name="robot">{TIPPED}</model>'
    for uri in (
        "model://ground_plane",
        "model://sun",
        "https://fuel.gazebosim.org/1.0/OpenRobotics/models/Ground Plane",
    ):
        one = reading(world(f"<include><uri>{uri}</uri></include>{robot}"))
        assert mobility(one) == 1
        assert [problem.severity for problem in one.problems] == ["warning"]
    other = world(f"<include><uri>model://table</uri></include>{robot}")
    assert reading(other).description is None
    assert mobility(reading(other, lenient=True)) == 1


def test_a_file_of_unknown_names_ends(reading) -> None:
    one = reading(model(TIPPED + "".join(f"<q{number}/>" for number in range(20_000))))
    assert one.description is None
    assert len(one.problems) == 101
    assert "more than 100 unknown names" in said(one)


INCLUDES = {
    "missing": ("<include><uri>model://nothing</uri></include>", "model 'model://nothing' of an <include> not found"),
    "from the net": ("<include><uri>https://fuel.gazebosim.org/x</uri></include>", "<include> of 'https://fuel"),
    "no uri": ("<include><name>x</name></include>", "<include> without <uri>"),
    "itself": ("<include><uri>model.sdf</uri></include>", "which includes itself"),
    "a ring": ("<include><uri>ring</uri></include>", "which includes itself"),
    "two models": ("<include><uri>two</uri></include>", "<include> of 'two', which has 2 models"),
    "not sdf": ("<include><uri>urdf</uri></include>", "the root element is <robot>"),
    "placement_frame alone": (
        "<include><uri>good</uri><placement_frame>a</placement_frame></include>",
        "<placement_frame> without <pose> in <include>",
    ),
    "unknown placement_frame": (
        "<include><uri>good</uri><pose>0 0 0 0 0 0</pose><placement_frame>z</placement_frame></include>",
        "unknown placement_frame 'z'",
    ),
    "name twice": ("<include><uri>good</uri></include>" * 2, "a second model 'good' in one <model>"),
    "parameters": (
        '<include><uri>good</uri><e:params xmlns:e="experimental">x</e:params></include>',
        "<include> with experimental:params",
    ),
}


@pytest.mark.parametrize("case", INCLUDES)
def test_bad_includes(case: str, reading) -> None:
    inside, found = INCLUDES[case]
    one = reading(
        model(TIPPED + inside),
        ring=model("<include><uri>../model.sdf</uri></include>", "ring"),
        two=model("").replace("</sdf>", '<model name="other"/></sdf>'),
        urdf="<robot/>",
        good=model(link("a"), "good"),
    )
    assert one.description is None
    assert any(found in each for each in said(one)), said(one)


def test_includes_do_not_grow_without_bound(reading, tmp_path: Path) -> None:
    """Ten files, each of which includes the next one ten times, would be 10^9 models."""
    for number in range(9):
        (tmp_path / f"{number}.sdf").write_text(
            model("".join(f"<include><uri>{number + 1}.sdf</uri><name>m{k}</name></include>" for k in range(10)))
        )
    (tmp_path / "9.sdf").write_text(model(link("a")))
    one = read_checked(tmp_path / "0.sdf")
    assert one.description is None
    assert any("more than 500 models" in each for each in said(one)), said(one)


# -- what matters to motion and what does not ------------------------------------------------------------------------


def test_lenient_readers_pass_what_does_not_move_anything(reading) -> None:
    visual = "<visual name='v'><geometry><sphere><radius>big</radius></sphere></geometry></visual>"
    mesh = "<visual name='w'><geometry><mesh><uri>no.stl</uri></mesh></geometry></visual>"
    text = model(TIPPED.replace("</link>", f"{visual}{mesh}</link>", 1))
    assert reading(text).description is None
    assert mobility(reading(text, lenient=True)) == 1


@pytest.mark.parametrize("told", ["false", "0", "true", " 1 "])
def test_a_link_that_gravity_does_not_pull(told: str, reading) -> None:
    text = model(TIPPED.replace(link("b", "0 1 0 0 0 0"), link("b", "0 1 0 0 0 0", f"<gravity>{told}</gravity>")))
    shares = {one.name: one.gravity_compensation for one in reading(text).description.links}
    assert shares.pop("b") == (told in ("false", "0"))
    assert not any(shares.values())


@pytest.mark.parametrize(
    ("more", "found"),
    [
        ("<gravity>down</gravity>", "<gravity> in <link> is 'down'"),
        ("<kinematic>1</kinematic>", "link 'b' is kinematic"),
        ("<velocity_decay><linear>0.1</linear></velocity_decay>", "velocity_decay of link 'b'"),
    ],
)
def test_what_moves_a_link_otherwise_is_told(more: str, found: str, reading) -> None:
    plain = link("b", "0 1 0 0 0 0")
    one = reading(model(TIPPED.replace(plain, link("b", "0 1 0 0 0 0", more))))
    assert one.description is None
    assert found in said(one)


@pytest.mark.parametrize(
    ("attribute", "more", "found"),
    [
        (' auto="true"', "", "<inertial auto=\"true\"> of link 'z'"),
        ("", "<fluid_added_mass><xx>1</xx></fluid_added_mass>", "<fluid_added_mass> of link 'z'"),
    ],
)
def test_inertia_by_other_means_is_refused(attribute: str, more: str, found: str, reading) -> None:
    odd = f'<link name="z"><inertial{attribute}><mass>1</mass>{more}</inertial></link>'
    one = reading(model(TIPPED + odd + joint("Z", "c", "z")))
    assert one.description is None
    assert found in said(one)
