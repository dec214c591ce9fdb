"""Which links have the colour of a limb, and that robots of every size look the same."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from kit.pages import data_of, scene_of, tracks_of
from kit.sized import Size

from cutjoint.chain import ClosedChain
from cutjoint.description.model import Joint, JointType, Link, RobotDescription, Shape
from cutjoint.robots import load
from cutjoint.simulation import run
from cutjoint.simulation.result import Result
from cutjoint.viewer import play, show
from cutjoint.viewer.film.arrows import LARGEST, full_size, largest_efforts
from cutjoint.viewer.film.recording import from_result
from cutjoint.viewer.picture.figure import Figure
from cutjoint.viewer.picture.limbs import PALETTE, limb_of

NO_LIMB = {
    "cpm": {"base", "limb1_platform", "limb2_platform", "limb3_platform", "tool"},
    "omega3": {"base", "platform_link", "payload", "tool"},
    "stewart": {"base", "platform_link", "tool"},
    "fivebar": {"base", "tool"},
    "redundant": {"base", "tool"},
    "fourbar": {"base", "coupler_link", "rocker_link", "tool"},
}


def limbs(description: RobotDescription) -> dict[str, set[str]]:
    found: dict[str, set[str]] = {}
    for link, limb in limb_of(description).items():
        found.setdefault(limb, set()).add(link)
    return found


@pytest.mark.parametrize("name", NO_LIMB)
def test_every_limb_and_nothing_else_has_a_colour(name: str) -> None:
    robot = load(name).description
    found = limbs(robot)
    assert {link.name for link in robot.links} - set().union(*found.values()) == NO_LIMB[name]
    assert set(found) == set(robot.actuators)
    assert len({len(links) for links in found.values()}) == 1  # the limbs of these robots are alike


def test_a_platform_without_a_tool_is_none_either() -> None:
    robot = load("cpm").description
    assert limb_of(replace(robot, tool=None)) == limb_of(robot)


@pytest.mark.parametrize("name", ["cpm", "omega3", "stewart"])
def test_what_is_fixed_to_base_or_platform_is_no_limb(name: str) -> None:
    robot = load(name).description
    more = [
        Joint(f"weld{i}", JointType.FIXED, link, f"more{i}", np.eye(4), np.array([0.0, 0.0, 1.0]))
        for i, link in enumerate((robot.root, robot.tool.link))
    ]
    links = (*robot.links, Link("more0"), Link("more1"))
    assert limb_of(replace(robot, links=links, joints=(*robot.joints, *more))) == limb_of(robot)


def test_an_arm_has_the_colour_of_the_actuator_before_and_its_base_none() -> None:
    robot = load("fivebar").description
    turning = tuple(joint.name for joint in robot.joints if joint.type.dof)
    arm = replace(robot, cuts=(), actuators=turning)
    owners = limb_of(arm)
    assert owners == {joint.child: joint.name for joint in robot.joints if joint.type.dof}
    assert robot.root not in owners


def plain(description: RobotDescription) -> RobotDescription:
    """Without colours of its own."""
    links = [
        replace(link, visuals=tuple(replace(shape, colour=None) for shape in link.visuals))
        for link in description.links
    ]
    return replace(description, links=tuple(links))


def test_only_limbs_that_are_seen_in_a_colour_are_said_to_have_it() -> None:
    chain = load("fivebar")
    figure = Figure(ClosedChain(plain(chain.description)), chain.home)
    assert figure.colours == dict(zip(chain.description.actuators, PALETTE, strict=False))
    black = (0.05, 0.05, 0.05, 1.0)
    links = tuple(
        replace(link, visuals=tuple(replace(shape, colour=black) for shape in link.visuals))
        for link in chain.description.links
    )
    dark = ClosedChain(replace(chain.description, links=links))
    assert Figure(dark, dark.home).colours == {}
    data = data_of(show(dark).html)
    assert data["legend"] == []
    assert all(label["colour"] == "" for label in data["labels"])


# ---- sizes


def sized(name: str, length: float) -> tuple[ClosedChain, Result]:
    """A robot built `length` times as large, its shapes as well, and a run of it from rest, as long in its own time."""
    size = Size(length=length)
    robot = load(name).description
    grown = size.of(robot)
    shapes = {link.name: link.visuals for link in robot.links}
    links = [replace(link, visuals=tuple(map_shape(one, length) for one in shapes.get(link.name, ())), collisions=())
             for link in grown.links]  # fmt: skip
    chain = ClosedChain(replace(grown, links=tuple(links)))
    return chain, run(chain, duration=0.1 * size.time, every=0.01 * size.time, joint_limits="ignore")


def map_shape(shape: Shape, length: float) -> Shape:
    placement = np.array(shape.placement)
    placement[:3, 3] *= length
    own = (length, length, length) if shape.kind == "mesh" else tuple(length * one for one in shape.size)
    return replace(shape, size=own, placement=placement)


def seen(chain: ClosedChain, result: Result) -> dict[str, Any]:
    """Everything that a page is sent of lengths, times the scale of the scene's root."""
    efforts = np.ones_like(result.effort) * np.linspace(1.0, -1.0, len(result))[:, None]
    page = play(chain, replace(result, effort=efforts)).html
    commands = scene_of(page)
    roots = [np.array(c["matrix"]).reshape(4, 4).T for c in commands if c["type"] == "set_transform" and
             c["path"] == "/robot"]  # fmt: skip
    scale = float(np.linalg.norm(roots[0][:3, 0]))
    found: dict[str, Any] = {"root": roots[0][:3, 3]}
    for command in commands:
        path = command.get("path", "")
        if (
            command["type"] == "set_object"
            and path.startswith("/robot/")
            and not path.endswith(("/gap", "/shaft/solid"))
        ):
            for geometry in command["object"]["geometries"]:
                found[path] = [scale * value for key, value in geometry.items() if isinstance(value, float) and
                               not key.endswith("egments")]  # fmt: skip
                if path.startswith("/robot/gravity"):  # a shaft of unit length, stretched where it is put
                    found[path] = found[path][:2]
                if "data" in geometry:
                    vertices = np.frombuffer(geometry["data"]["attributes"]["position"]["array"].data, "<f4")
                    found[path] = [scale * float(np.abs(vertices).max())]
    for path, name, values in tracks_of(page):
        if name == ".position" and path.startswith("/robot/"):
            found[path + name] = scale * values
        elif name == ".scale":
            found[path + name] = values * ([1, 1, scale] if path.endswith("shaft") else 1.0)
    return found


@pytest.mark.parametrize("length", [1e-3, 1e2])
@pytest.mark.parametrize("name", ["fivebar", "stewart"])
@pytest.mark.slow
def test_a_robot_of_a_millimetre_and_one_of_a_hundred_metres_look_the_same(name: str, length: float) -> None:
    usual, other = seen(*sized(name, 1.0)), seen(*sized(name, length))
    assert usual.keys() == other.keys()
    assert len(usual) > 30
    for path, value in usual.items():
        np.testing.assert_allclose(other[path], value, rtol=2e-4, atol=2e-4, err_msg=path)


def test_arrows_have_room_between_the_actuators() -> None:
    for name in ("cpm", "omega3", "stewart"):
        chain = load(name)
        figure = Figure(chain, chain.home)
        size = full_size(figure, chain.home)
        placed = chain.link_placements(chain.home)
        places = [placed[chain.description.joint(one.name).child][:3, 3] for one in chain.actuators]
        apart = np.median([min(np.linalg.norm(a - b) for b in places if b is not a) for a in places])
        assert 0.0 < size <= min(LARGEST * figure.radius, apart)


def test_efforts_that_are_rounding_have_no_arrows() -> None:
    chain = load("fivebar")
    result = run(chain, duration=0.05, every=0.01)
    noise = from_result(chain, replace(result, effort=np.full_like(result.effort, 1e-13)))
    assert set(largest_efforts(chain, noise).values()) == {0.0}
    assert not any("effort" in entry["text"] for entry in data_of(play(chain, result).html)["legend"])
    real = from_result(chain, replace(result, effort=np.full_like(result.effort, -0.2)))
    assert set(largest_efforts(chain, real).values()) == {0.2}
