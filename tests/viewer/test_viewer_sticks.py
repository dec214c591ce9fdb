from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.built import built
from kit.mechanisms import MECHANISMS
from kit.random_robots import random_robot

from cutjoint.chain import ClosedChain
from cutjoint.description.model import Shape
from cutjoint.robots import load
from cutjoint.viewer.picture.figure import Figure
from cutjoint.viewer.picture.sticks import is_bare, sticks

THIN = 1e-9


def ends(shape: Shape, link: np.ndarray) -> np.ndarray:
    """Both ends of a stick in the world, shape (2, 3)."""
    half = np.array([[0.0, 0.0, -0.5 * shape.size[1], 1.0], [0.0, 0.0, 0.5 * shape.size[1], 1.0]])
    return (half @ (link @ shape.placement).T)[:, :3]


def joined(chain: ClosedChain, links: dict[str, np.ndarray]) -> dict[str, list[np.ndarray]]:
    """Points at which links hold each other, in the world, by link."""
    found: dict[str, list[np.ndarray]] = {link.name: [] for link in chain.description.links}
    for joint in chain.description.joints:
        if joint.type.value not in ("floating", "planar"):
            found[joint.parent].append((links[joint.parent] @ joint.placement)[:3, 3])
            found[joint.child].append(links[joint.child][:3, 3])
        if joint.type.value == "prismatic":
            found[joint.child].append((links[joint.parent] @ joint.placement)[:3, 3])
    for cut in chain.description.cuts:
        for frame in (cut.a, cut.b):
            found[frame.link].append((links[frame.link] @ frame.placement)[:3, 3])
    return found


@pytest.mark.parametrize("name", [*MECHANISMS, *range(6)])
def test_sticks_lead_from_joint_to_joint(name: str | int, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    if isinstance(name, int):
        rng = np.random.default_rng(name)
        plan = random_robot(rng, 7, 1, tmp_path / "try")
    else:
        plan = MECHANISMS[name](rng).plan
    chain = built(plan, tmp_path / "made")[0]
    description = chain.description
    assert is_bare(description)
    links = {name: np.asarray(at) for name, at in chain.link_placements(chain.home.q_full).items()}
    drawn = sticks(description, THIN, links)
    for link, points in joined(chain, links).items():
        if link == description.root:
            assert all(shape.kind == "sphere" for shape in drawn.get(link, ()))
            continue
        tips = [ends(shape, links[link]) for shape in drawn.get(link, ()) if shape.kind == "cylinder"]
        spread = np.ptp(np.array(points or [np.zeros(3)]), axis=0).max()
        if spread < 1e-6:
            continue
        for point in points:
            assert min(np.linalg.norm(tip - point, axis=1).min() for tip in tips) < 1e-6


def test_a_robot_without_shapes_is_seen_and_a_robot_with_shapes_has_its_own() -> None:
    chain = load("fivebar")
    assert not is_bare(chain.description)
    bare = replace(
        chain.description, links=tuple(replace(link, visuals=(), collisions=()) for link in chain.description.links)
    )
    assert is_bare(bare)
    figure = Figure(ClosedChain(bare), ClosedChain(bare).home)
    drawn = [path for path in figure.scene.paths() if "/visual/" in path]
    assert len(drawn) >= 4 + 5
    own = Figure(chain, chain.home)
    assert len([path for path in own.scene.paths() if "/visual/" in path]) == sum(
        len(link.visuals) for link in chain.description.links
    )


def test_collision_shapes_are_shown_where_there_are_no_others() -> None:
    chain = load("fivebar")
    shape = Shape("sphere", (0.01,))
    links = tuple(replace(link, visuals=(), collisions=(shape,)) for link in chain.description.links)
    hidden = tuple(replace(link, collisions=(shape,)) for link in chain.description.links)
    for made, shown in ((links, True), (hidden, False)):
        robot = ClosedChain(replace(chain.description, links=made))
        assert Figure(robot, robot.home).toggles["Collision shapes"][1] is shown
