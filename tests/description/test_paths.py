"""Every number of a description has a path: read back what was set, leave the rest, and name the nearest path."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from kit.quickly import few
from kit.shipped import SHIPPED
from kit.two_bodies import two_bodies

from cutjoint.description import Bushing, Joint, JointType, Link, load_description, paths, value, with_values
from cutjoint.description.model import RobotDescription
from cutjoint.errors import InputError, UnknownNameError

GROUPS = {
    "links.one.com": ("x", "y", "z"),
    "links.one.inertia": ("xx", "yy", "zz", "xy", "xz", "yz"),
    "cuts.cut.a.xyz": ("x", "y", "z"),
    "cuts.cut.b.rpy": ("roll", "pitch", "yaw"),
    "joints.f1.origin.xyz": ("x", "y", "z"),
    "gravity": ("x", "y", "z"),
}


def everything(robot: RobotDescription) -> dict[str, float]:
    return {path: float(value(robot, path)) for path in paths(robot)}


@pytest.mark.parametrize("name", few(SHIPPED, "fourbar", "cpm"))
def test_a_number_that_is_set_is_read_back_and_no_other_changes(name: str) -> None:
    robot, rng = load_description(name), np.random.default_rng(0)
    before = everything(robot)
    same = everything(with_values(robot, before))
    for path, x in before.items():
        assert same[path] == pytest.approx(x, rel=1e-14, abs=1e-14), path
    for path in rng.choice(list(before), 60):
        # of a rotation with a pitch of a quarter turn only the sum of two angles can be read back
        new = before[path] + rng.uniform(0.01, 0.2)
        angle = path.rpartition(".")[2] in ("roll", "pitch", "yaw")
        place = path.rpartition(".")[0]
        if angle and abs(abs(before[f"{place}.pitch"]) - np.pi / 2) < 0.3:
            continue
        after = everything(with_values(robot, {path: new}))
        turned = new - 2 * np.pi * np.round(new / (2 * np.pi)) if angle else new
        assert after[path] == pytest.approx(turned, abs=1e-12), path
        own = f"{place}." if angle else path
        for other in before:
            if other != path and not (angle and other.startswith(own)):
                assert after[other] == pytest.approx(before[other], abs=1e-14), (path, other)


@pytest.mark.parametrize("path", GROUPS)
def test_some_paths_are_several_numbers(path: str) -> None:
    robot, rng = two_bodies("revolute"), np.random.default_rng(1)
    parts = GROUPS[path]
    start = path if path == "gravity" or path.startswith("links") else path.rpartition(".")[0]
    new = rng.uniform(0.1, 0.5, len(parts))
    changed = with_values(robot, {path: new})
    np.testing.assert_allclose(value(changed, path), new, rtol=0, atol=1e-14)
    np.testing.assert_allclose([value(changed, f"{start}.{part}") for part in parts], new, rtol=0, atol=1e-14)
    assert changed.name == robot.name
    with pytest.raises(InputError, match=f"{len(parts)} numbers"):
        with_values(robot, {path: 1.0})


def test_names_may_hold_dots_and_end_like_fields() -> None:
    links = tuple(Link(name) for name in ("base", "a", "a.com", "a.com.x"))
    joints = tuple(
        Joint(f"j.{link.name}", JointType.PRISMATIC, parent.name, link.name) for parent, link in pairwise(links)
    )
    robot = RobotDescription("dots", links, joints)
    for link in links:
        changed = with_values(robot, {f"links.{link.name}.mass": 2.0, f"links.{link.name}.com.x": 0.5})
        assert [one.name for one in changed.links if one.inertial is not None] == [link.name]
    moved = with_values(robot, {"joints.j.a.com.origin.x": 0.5})
    assert [joint.placement[0, 3] for joint in moved.joints] == [0.0, 0.5, 0.0]


def test_a_bushing_has_numbers_and_a_rigid_cut_has_none() -> None:
    rigid = two_bodies("revolute")
    soft = replace(rigid, cuts=(replace(rigid.cuts[0], bushing=Bushing(1e4)),))
    changed = with_values(soft, {"cuts.cut.bushing.stiffness": 5e4})
    assert changed.cuts[0].bushing == Bushing(5e4)
    for robot, path in ((rigid, "bushing.stiffness"), (soft, "damping")):
        with pytest.raises(UnknownNameError):
            value(robot, f"cuts.cut.{path}")


@pytest.mark.parametrize(
    ("bad", "near"),
    [
        ("links.on.mass", "links.one.mass"),
        ("links.one.mas", "links.one.mass"),
        ("link.one.mass", "links.one.mass"),
        ("joints.f1.orign.x", "joints.f1.origin.x"),
        ("cuts.cut.a.xy", "cuts.cut.a.xyz"),
        ("gravty", "gravity"),
        ("joints.f1.dampng", "joints.f1.damping"),
    ],
)
def test_an_unknown_path_names_the_nearest(bad: str, near: str) -> None:
    for ask in (lambda: value(two_bodies("revolute"), bad), lambda: with_values(two_bodies("revolute"), {bad: 1.0})):
        with pytest.raises(UnknownNameError, match=f"did you mean '{near}'"):
            ask()


def test_nonsense_is_refused() -> None:
    robot = two_bodies("revolute")
    for path in ("links.one.mass", "links.one.inertia.xx", "joints.f1.damping", "cuts.cut.friction"):
        with pytest.raises(InputError, match=">= 0"):
            with_values(robot, {path: -1e-9})
    for path in ("links.one.inertia.xy", "joints.f1.origin.x", "cuts.cut.rest", "gravity.x"):
        assert value(with_values(robot, {path: -0.25}), path) == -0.25
    for bad in (np.nan, np.inf, "x", [1.0, 2.0]):
        with pytest.raises(InputError):
            with_values(robot, {"links.one.mass": bad})
    with pytest.raises(InputError, match="given twice"):
        with_values(robot, {"links.one.com": np.zeros(3), "links.one.com.x": 0.0})
