"""`propose`: cuts are found where they were, robots on other trees are the same robots."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.built import built
from kit.mechanisms import MECHANISMS
from kit.quickly import few
from kit.random_robots import random_robot
from kit.shipped import DETERMINED, OTHERS
from kit.uncut import ENDS, at_zero, random, uncut, written

from cutjoint.chain import ClosedChain
from cutjoint.chain.findings import kinematic_problems, usual_mobility
from cutjoint.description import check, load_description, write
from cutjoint.description.model import Home
from cutjoint.drafting.cutting.proposing import propose
from cutjoint.drafting.cutting.respan import instead_of
from cutjoint.drafting.folder import write_description
from cutjoint.errors import CutjointError, InputError, UnknownNameError

UNIVERSAL = ("upu_3", "upu_3_equal")
"""Their types of cuts are left open, as frames alone do not tell them."""


def original(name: str, folder: Path, seed: int = 7) -> ClosedChain:
    return built(MECHANISMS[name](random(seed)).plan, folder)[0]


@pytest.mark.parametrize("name", few([one for one in MECHANISMS if one not in UNIVERSAL], "spherical_4r"))
def test_cuts_are_found_by_the_names_of_their_frames(name: str, tmp_path: Path) -> None:
    chain = original(name, tmp_path / "a")
    ends = ENDS[len(name) % 3]
    found = propose(written(uncut(chain.description, ends), tmp_path / "b", tree_alone=False))
    was, now = chain.mobility(), found.report
    assert [cut.type for cut in found.cuts] == [cut.type.value for cut in chain.description.cuts]
    assert {cut.why for cut in found.cuts} == {"names"}
    assert (now.mobility, len(now.redundant_rows)) == (was.mobility, len(was.redundant_rows))
    again = ClosedChain(found.robot)
    old, new = chain.link_placements(chain.home), again.link_placements(again.home)
    assert all(np.allclose(old[link], new[link], atol=1e-6) for link in old)


BY_PLACE = [one for one in MECHANISMS if one not in (*UNIVERSAL, "scotch_yoke", "geared_fivebar")]


@pytest.mark.parametrize("name", few(BY_PLACE, "sarrus"))
def test_cuts_are_found_where_frames_lie_in_one_place(name: str, tmp_path: Path) -> None:
    chain = original(name, tmp_path / "a")
    robot = at_zero(chain)
    alone = all(one.type.urdf for one in robot.joints)
    found = propose(written(uncut(robot, ("_x", "_y")), tmp_path / "b", tree_alone=alone))
    cut_before = ClosedChain(robot)
    was, now = cut_before.mobility(), found.report
    usual = usual_mobility(cut_before)  # less than at home where that is flat; what is proposed is not
    assert sorted(cut.type for cut in found.cuts) == sorted(cut.type.value for cut in robot.cuts)
    assert max(cut.distance for cut in found.cuts) < 1e-9
    assert (now.mobility, len(now.redundant_rows)) == (usual, was.rows - was.velocities + usual)
    assert any("singular at zero" in one for one in found.told) is (usual < was.mobility)
    assert found.chose_motors is alone
    if name != "floating_fourbar":  # nothing drives what flies
        assert not [one for one in found.told if alone and "locked" in one]  # the actuators that were chosen move it


@pytest.mark.parametrize("name", few(UNIVERSAL))
def test_what_frames_do_not_tell_is_left_to_choose(name: str, tmp_path: Path) -> None:
    chain = original(name, tmp_path / "a")
    folder = written(uncut(chain.description, ENDS[0]), tmp_path / "b", tree_alone=False)
    found = propose(folder)
    assert {cut.type for cut in found.cuts} == {"spherical"}
    assert all("universal" in [one.type for one in cut.choices if one.closes] for cut in found.cuts)
    said = propose(folder, types={cut.name: "universal" for cut in found.cuts})
    assert said.report.mobility == chain.mobility().mobility
    assert {cut.choices[0].type for cut in said.cuts} == {"universal"}


def same_robot(chain: ClosedChain, other: ClosedChain) -> None:
    """Two chains of one robot: mobility, the bodies at home, and the dynamics in actuated coordinates."""
    was, now = chain.mobility(), other.mobility()
    assert (was.mobility, len(was.redundant_rows)) == (now.mobility, len(now.redundant_rows))
    old, new = chain.link_placements(chain.home), other.link_placements(other.home)
    assert all(np.allclose(old[link], new[link], atol=1e-8) for link in old)
    if was.determined and now.determined and chain.n:
        v = random(1).normal(size=chain.n)
        one, two = chain.terms(chain.home, v), other.terms(other.home, v)
        for key in ("mass", "coriolis", "gravity", "springs", "friction"):
            a, b = getattr(one, key), getattr(two, key)
            assert np.allclose(a, b, rtol=1e-6, atol=1e-7 * max(1.0, np.abs(a).max())), key


@pytest.mark.parametrize("name", few((*DETERMINED, *OTHERS), "fivebar"))
def test_shipped_robots_on_other_trees_are_the_same(name: str) -> None:
    chain = ClosedChain(load_description(name))
    for cut, joints in list(instead_of(chain.description).items())[:2]:
        for joint in joints[:3]:
            found = propose(name, [joint])
            assert joint in [one.name for one in found.cuts]
            assert cut in [one.name for one in (*found.robot.cuts, *found.robot.joints)]
            same_robot(chain, ClosedChain(found.robot))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["upu_3", "bennett", "prs_3", "scotch_yoke", "spherical_3rrr", "geared_fivebar"])
def test_mechanisms_on_other_trees_are_the_same(name: str, tmp_path: Path) -> None:
    chain = original(name, tmp_path / "a")
    for joints in instead_of(chain.description).values():
        for joint in joints:
            same_robot(chain, ClosedChain(propose(tmp_path / "a", [joint]).robot))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(24))
def test_random_robots_on_other_trees_are_the_same(seed: int, tmp_path: Path) -> None:
    rng = random(seed)
    folder = random_robot(rng, int(rng.integers(3, 7)), int(rng.integers(1, 3)), tmp_path / "tries").write(
        tmp_path / "a"
    )
    robot = load_description(folder)
    choices = [joint for joints in instead_of(robot).values() for joint in joints]
    if not choices:
        pytest.skip("nothing else can be cut")
    chain = ClosedChain(robot)
    for joint in dict.fromkeys(choices[:4]):
        found = propose(folder, [joint])
        target = tmp_path / f"out_{joint}"
        write_description(found.robot, target)
        assert not [one for one in check(target) if one.severity == "error" and "cannot move" not in one.found]
        again = ClosedChain(load_description(target))
        assert (again.mobility().mobility, len(again.mobility().redundant_rows)) == (
            chain.mobility().mobility,
            len(chain.mobility().redundant_rows),
        )


LINK = """<link name="{}"><inertial><mass value="1"/>
  <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
"""
JOINT = """<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><origin xyz="{}"/>
  <axis xyz="0 0 1"/>{}</joint>
"""
LIMIT = '<limit lower="-3" upper="3" effort="1" velocity="1"/>'


def two_parents(folder: Path) -> Path:
    """A four-bar whose rocker's tip hangs on the coupler too."""
    joints = (
        ("crank", "continuous", "base", "crank_link", "0 0 0", ""),
        ("rocker", "continuous", "base", "rocker_link", "0.3 0 0", ""),
        ("coupler", "continuous", "crank_link", "coupler_link", "0 0.1 0", ""),
        ("at_tip", "fixed", "rocker_link", "tip", "0 0.2 0", ""),
        (
            "last",
            "revolute",
            "coupler_link",
            "tip",
            "0.32 0 0",
            '<limit lower="-3" upper="3" effort="1" velocity="1"/>',
        ),
    )
    links = "".join(LINK.format(name) for name in ("base", "crank_link", "rocker_link", "coupler_link"))
    file = folder / "two.urdf"
    file.write_text(
        f'<robot name="two">{links}<link name="tip"/>{"".join(JOINT.format(*one) for one in joints)}</robot>'
    )
    return file


def test_limits_come_back_where_the_joint_goes_into_the_tree(tmp_path: Path) -> None:
    found = propose(two_parents(tmp_path))
    assert [(cut.name, cut.type, cut.why) for cut in found.cuts] == [("last", "revolute", "the file")]
    assert [one for one in found.told if one.startswith("'last' has limits, which a cut cannot have: --cut coupler")]
    assert [one for one in found.told if "limits of joint 'last', which closes a loop, are not used" in one]
    again = propose(two_parents(tmp_path), ["coupler"])
    limits = again.robot.joint("last").limits
    assert (limits.lower, limits.upper) == (-3.0, 3.0)
    assert not [one for one in again.told if "'last'" in one]
    assert again.report.mobility == found.report.mobility == 1
    old, new = (one.link_placements(one.home) for one in (ClosedChain(found.robot), ClosedChain(again.robot)))
    assert np.allclose(old["tip"], new["tip"], atol=1e-8)


def test_frames_that_close_nothing_are_told(tmp_path: Path) -> None:
    chain = original("parallelogram", tmp_path / "a")
    robot = uncut(chain.description, ENDS[0])
    alone = replace(robot, links=robot.links[:-1], joints=robot.joints[:-1])
    found = propose(written(alone, tmp_path / "b", tree_alone=False))
    assert found.robot is None
    assert [one for one in found.told if "the other end is not there" in one]
    assert found.ends


def test_frames_that_are_held_together_already_are_told(tmp_path: Path) -> None:
    """The frame on the foot of an ankle is where its two axes meet: a cut to the base there would hold nothing."""
    joints = (
        ("pitch", "continuous", "base", "cross", "0 0 0", ""),
        ("roll", "continuous", "cross", "foot", "0 0 0", ""),
        ("at_foot", "fixed", "foot", "p", "0 0 0", ""),
        ("at_base", "fixed", "base", "q", "0 0 0", ""),
    )
    links = "".join(LINK.format(name) for name in ("base", "cross", "foot")) + '<link name="p"/><link name="q"/>'
    file = tmp_path / "ankle.urdf"
    file.write_text(f'<robot name="ankle">{links}{"".join(JOINT.format(*one) for one in joints)}</robot>')
    found = propose(file)
    assert found.robot is None
    assert len([one for one in found.told if "holds nothing that is not held already" in one]) >= 1


def in_sdf(folder: Path) -> Path:
    """The same in SDF, in links that are turned against each other and the joints."""

    def joint(name: str, parent: str, child: str, more: str = "") -> str:
        return (
            f'<joint name="{name}" type="revolute"><parent>{parent}</parent><child>{child}</child>'
            f"<axis><xyz>0 -1 0</xyz>{more}</axis></joint>"
        )

    body = "<inertial><mass>1</mass><inertia><ixx>1e-3</ixx><iyy>1e-3</iyy><izz>1e-3</izz></inertia></inertial>"
    places = {"crank_link": "0 0 0", "rocker_link": "0.3 0 0", "coupler_link": "0 0 0.1", "tip": "0.3 0 0.2"}
    links = "".join(f'<link name="{name}"><pose>{at} 0 0 0.3</pose>{body}</link>' for name, at in places.items())
    limits = "<limit><lower>-0.7</lower><upper>1.3</upper></limit><dynamics><damping>0.4</damping></dynamics>"
    file = folder / "it.sdf"
    file.write_text(
        f'<sdf version="1.8"><model name="it">{links}{joint("crank", "world", "crank_link")}'
        f"{joint('rocker', 'world', 'rocker_link')}{joint('coupler', 'crank_link', 'coupler_link')}"
        f'<joint name="weld" type="fixed"><parent>rocker_link</parent><child>tip</child></joint>'
        f"{joint('last', 'coupler_link', 'tip', limits)}</model></sdf>"
    )
    return file


def test_limits_of_an_sdf_come_back_too(tmp_path: Path) -> None:
    found = propose(in_sdf(tmp_path))
    assert [cut.name for cut in found.cuts] == ["last"]
    assert [one for one in found.told if one.startswith("'last' has limits, which a cut cannot have: --cut coupler")]
    again = propose(in_sdf(tmp_path), ["coupler"])
    last = again.robot.joint("last")
    assert (last.limits.lower, last.limits.upper, last.physics.damping) == (-0.7, 1.3, 0.4)
    assert not [one for one in again.told if "'last'" in one]
    # the same way round: limits are of the same angle, which is that of the tip against the coupler
    chain = ClosedChain(again.robot)
    at = chain.close([chain.home.q[0] + 0.2])
    tip, coupler = (chain.link_placements(at)[name][:3, :3] for name in ("tip", "coupler_link"))
    axis = chain.link_placements(at)["coupler_link"][:3, :3] @ [0.0, -1.0, 0.0]
    skew = coupler.T @ tip - (coupler.T @ tip).T
    turned = 0.5 * coupler @ [skew[2, 1], skew[0, 2], skew[1, 0]] @ axis
    assert np.arcsin(turned) == pytest.approx(at["last"], abs=1e-9)
    assert abs(turned) > 0.01


def flat_parallelogram(folder: Path) -> Path:
    """All links on one line at zero, where a parallelogram may fold over into an antiparallelogram."""
    joints = (
        ("crank", "continuous", "base", "crank_link", "0 0 0", ""),
        ("rocker", "continuous", "base", "rocker_link", "0.3 0 0", ""),
        ("coupler", "continuous", "crank_link", "coupler_link", "0.1 0 0", ""),
        ("at_tip", "fixed", "rocker_link", "tip_loop_a", "0.1 0 0", ""),
        ("at_far", "fixed", "coupler_link", "tip_loop_b", "0.3 0 0", ""),
    )
    links = "".join(LINK.format(name) for name in ("base", "crank_link", "rocker_link", "coupler_link"))
    frames = '<link name="tip_loop_a"/><link name="tip_loop_b"/>'
    file = folder / "flat.urdf"
    file.write_text(f'<robot name="flat">{links}{frames}{"".join(JOINT.format(*one) for one in joints)}</robot>')
    return file


def test_home_is_not_where_the_loops_are_singular(tmp_path: Path) -> None:
    found = propose(flat_parallelogram(tmp_path))
    assert [one for one in found.told if "allow 2 independent motions there, 1 around it" in one]
    assert (found.report.mobility, found.robot.actuators) == (1, ("crank",))
    assert found.report.determined
    assert found.report.type2 > 0.01
    assert not kinematic_problems(found.robot)[0]
    at_zero = replace(found.robot, homes=(Home("default", {"crank": 0.0}, {}),))
    assert [
        one for one in kinematic_problems(at_zero)[0] if one.found.startswith("home is singular: the loops allow 2")
    ]


def test_a_robot_without_loops_has_nothing_to_close(tmp_path: Path) -> None:
    robot = load_description("fivebar")
    (file,) = [one for one in write(robot, tmp_path / "a", "loops") if one.suffix == ".urdf"]
    found = propose(file)
    assert (found.robot, found.cuts, found.report) == (None, (), None)
    assert found.ends == ("tool", "right_distal")


@pytest.mark.parametrize(
    ("cut", "types", "error", "told"),
    [
        (["left_shoulder"], {}, InputError, "it is actuated; joints that can be: left_elbow, right_elbow"),
        (["tool_mount"], {}, InputError, "no loop goes through it"),
        (["left_elbow", "right_elbow"], {}, InputError, "no loop goes through it"),
        (["elbow"], {}, UnknownNameError, "Known: left_shoulder"),
        ([], {"tip": "fixed"}, UnknownNameError, "unknown cut at a pair of frames 'tip'"),
    ],
)
def test_what_cannot_be_cut(cut: list[str], types: dict[str, str], error: type[CutjointError], told: str) -> None:
    with pytest.raises(error) as caught:
        propose("fivebar", cut, types)
    assert told in str(caught.value)


@pytest.mark.slow
def test_frames_that_cannot_meet_are_refused(tmp_path: Path) -> None:
    chain = original("parallelogram", tmp_path / "a")
    robot = uncut(chain.description, ENDS[0])
    far = robot.joints[-1].placement.copy()
    far[:3, 3] += [0.0, 0.0, 50.0]
    joints = (*robot.joints[:-1], replace(robot.joints[-1], placement=far))
    changed = replace(robot, joints=joints)
    with pytest.raises(InputError, match="do not close it"):
        propose(written(changed, tmp_path / "b", tree_alone=False))
