"""Links that are stretched, and mounted robots: against point masses, and against robots that are turned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.description import Inertial, RobotDescription, load_description, mounted, stretched
from cutjoint.description.transforms import rotation_from_rpy
from cutjoint.errors import InputError, UnknownNameError


def of_points(masses: np.ndarray, points: np.ndarray) -> Inertial:
    """The inertia of point masses."""
    mass = masses.sum()
    com = masses @ points / mass
    away = points - com
    inertia = sum(m * ((r @ r) * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, away, strict=True))
    return Inertial(float(mass), com, np.asarray(inertia))


@pytest.mark.parametrize("seed", range(8))
def test_a_stretched_body_is_its_points_stretched(seed: int) -> None:
    rng = np.random.default_rng(seed)
    masses, points = rng.uniform(0.1, 2.0, 7), rng.normal(size=(7, 3))
    along, ratio = rng.normal(size=3), float(rng.uniform(0.3, 3.0))
    u = along / np.linalg.norm(along)
    robot = load_description("fivebar").with_inertial("left_proximal", of_points(masses, points))
    found = stretched(robot, "left_proximal", along, ratio).link("left_proximal").inertial
    wanted = of_points(ratio * masses, points + np.outer(points @ u, (ratio - 1.0) * u))
    assert found is not None
    assert np.isclose(found.mass, wanted.mass, rtol=1e-12)
    assert np.allclose(found.com, wanted.com, atol=1e-12)
    assert np.allclose(found.inertia, wanted.inertia, rtol=1e-11, atol=1e-11)


def numbers(robot: RobotDescription) -> np.ndarray:
    """All that a stretch may change."""
    parts = [one.placement for one in robot.joints] + [one.placement for cut in robot.cuts for one in (cut.a, cut.b)]
    bodies = [one.inertial for one in robot.links if one.inertial is not None]
    bodies += [one for variant in robot.variants for one in variant.inertials.values()]
    sizes = [np.array(shape.size) for link in robot.links for shape in (*link.visuals, *link.collisions)]
    parts += [shape.placement for link in robot.links for shape in (*link.visuals, *link.collisions)]
    return np.concatenate([np.ravel(one) for one in [*parts, *(x for b in bodies for x in (b.com, b.inertia)), *sizes]])


@pytest.mark.parametrize("name", ["omega3", "cpm", "stewart", "fivebar"])
def test_stretches_follow_each_other_and_come_back(name: str) -> None:
    robot = load_description(name)
    links = [one.name for one in robot.links if one.name != robot.root]
    for along in np.eye(3):
        twice = stretched(stretched(robot, links, along, 1.25), links, along, 1.6)
        assert np.allclose(numbers(twice), numbers(stretched(robot, links, along, 2.0)), rtol=1e-12, atol=1e-14)
        back = stretched(stretched(robot, links, along, 2.0), links, along, 0.5)
        assert np.allclose(numbers(back), numbers(robot), rtol=1e-12, atol=1e-14)


def test_stretched_along_all_axes_it_is_a_larger_robot() -> None:
    robot = load_description("fivebar")
    larger = robot
    for along in np.eye(3):
        larger = stretched(larger, [one.name for one in robot.links], along, 1.5)
    small, large = ClosedChain(robot), ClosedChain(larger)
    q = small.home.q + 0.1
    assert np.allclose(large.tool(large.close(q)).position, 1.5 * small.tool(small.close(q)).position, atol=1e-12)
    v = np.array([0.3, -0.2])
    masses = small.terms(small.close(q)).mass, large.terms(large.close(q)).mass
    assert np.allclose(masses[1], 1.5**5 * masses[0], rtol=1e-10)  # mass 1.5^3, lengths 1.5^2
    assert np.allclose(large.tangent(large.close(q)) @ v, small.tangent(small.close(q)) @ v, atol=1e-11)


@pytest.mark.parametrize("angles", [(0.3, 0.0), (0.0, -0.7), (0.4, 1.1)])
def test_a_mounted_robot_weighs_what_a_turned_one_weighs(angles: tuple[float, float]) -> None:
    robot = load_description("stewart")
    turn = np.eye(4)
    turn[:3, :3] = rotation_from_rpy((*angles, 0.0))
    joints = tuple(
        replace(one, placement=turn @ one.placement) if one.parent == robot.root else one for one in robot.joints
    )
    cuts = tuple(
        replace(
            cut,
            a=replace(cut.a, placement=turn @ cut.a.placement) if cut.a.link == robot.root else cut.a,
            b=replace(cut.b, placement=turn @ cut.b.placement) if cut.b.link == robot.root else cut.b,
        )
        for cut in robot.cuts
    )
    turned, hung = ClosedChain(replace(robot, joints=joints, cuts=cuts)), ClosedChain(mounted(robot, *angles))
    q = hung.home.q
    wanted = turned.terms(turned.close(q)).holding
    assert np.allclose(hung.terms(hung.home).holding, wanted, rtol=1e-8, atol=1e-9)


def test_what_cannot_be_is_refused() -> None:
    robot = load_description("fivebar")
    with pytest.raises(UnknownNameError, match="left_proximal"):
        stretched(robot, "left_proximl", [1, 0, 0], 1.1)
    for along, ratio in (([0, 0, 0], 1.1), ([1, 0, 0], 0.0), ([1, 0, 0], -1.0), ([1, 0, 0], np.nan), ([1, 0], 1.1)):
        with pytest.raises(InputError):
            stretched(robot, "left_proximal", along, ratio)
    with pytest.raises(InputError, match="twice"):
        stretched(robot, ["left_proximal", "left_proximal"], [1, 0, 0], 1.1)
    with pytest.raises(InputError):
        mounted(robot, roll=np.inf)
