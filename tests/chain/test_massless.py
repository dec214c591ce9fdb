"""A limb may end in a link without mass, as exported robots do: the loops carry it, and dynamics stays defined."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.description import Inertial, JointType, RobotDescription, load_description
from cutjoint.errors import DynamicsError


def without_mass(name: str, *links: str) -> RobotDescription:
    robot = load_description(name)
    for link in links:
        robot = robot.with_inertial(link, Inertial(0.0))
    return robot


@pytest.mark.parametrize(
    ("name", "links"), [("cpm", ["limb2_platform"]), ("cpm", ["limb2_platform", "limb3_platform"])]
)
def test_dynamics_of_a_limb_that_ends_without_mass(name: str, links: list[str]) -> None:
    chain, random = ClosedChain(without_mass(name, *links)), np.random.default_rng(0)
    for _ in range(5):
        at = chain.reach(chain.tool(chain.home).position + random.uniform(-0.05, 0.05, 3))
        v, effort = random.normal(size=chain.n), random.normal(size=chain.n)
        a = chain.forward_dynamics(at, v, effort)
        np.testing.assert_allclose(chain.inverse_dynamics(at, v, a), effort, rtol=0, atol=1e-11)
        terms = chain.terms(at, v)
        np.testing.assert_allclose(terms.mass @ a + terms.coriolis + terms.gravity, effort, rtol=0, atol=1e-11)


def test_little_mass_and_none_are_nearly_the_same() -> None:
    """The null-space solution without mass is the limit of Pinocchio's with ever less of it."""
    none, v, effort = ClosedChain(without_mass("cpm", "limb2_platform")), np.ones(3), np.array([1.0, -2.0, 3.0])
    wanted = none.forward_dynamics(none.home, v, effort)
    errors = []
    for mass in (1e-2, 1e-3):
        little = Inertial(mass, np.zeros(3), mass * 1e-3 * np.eye(3))
        chain = ClosedChain(load_description("cpm").with_inertial("limb2_platform", little))
        errors.append(float(np.abs(chain.forward_dynamics(chain.home, v, effort) - wanted).max()))
    assert errors[1] == pytest.approx(0.1 * errors[0], rel=0.02)


def test_bars_without_mass_may_spin_with_rods_on_balls() -> None:
    """Their spin is no motion of mass; what is computed of it is rounding of the rods' far larger terms."""
    robot = load_description("omega3")
    loose = [replace(one, type=JointType.SPHERICAL) if one.name.startswith("rod") else one for one in robot.joints]
    homes = [
        replace(home, passive={k: (at, 0.0, 0.0) if k.startswith("rod") else at for k, at in home.passive.items()})
        for home in robot.homes
    ]
    balls, hinges = ClosedChain(replace(robot, joints=tuple(loose), homes=tuple(homes))), ClosedChain(robot)
    random = np.random.default_rng(6)
    for _ in range(5):
        q = 0.05 + random.uniform(-0.3, 0.3, 3)
        found, wanted = balls.terms(balls.close(q), np.zeros(3)), hinges.terms(hinges.close(q), np.zeros(3))
        # hinges have to turn the bars' rods about their axes, by an inertia of 8e-8 kg m2 each
        np.testing.assert_allclose(found.mass, wanted.mass, rtol=0, atol=1e-6)
        np.testing.assert_allclose(found.gravity, wanted.gravity, rtol=0, atol=1e-9)


def test_a_motion_that_moves_no_mass_is_refused() -> None:
    robot = load_description("fourbar")
    bare = robot.with_inertial("crank_link", Inertial(0.0))
    for link in robot.links:
        bare = bare.with_inertial(link.name, Inertial(0.0)) if link.inertial else bare
    chain = ClosedChain(bare)
    with pytest.raises(DynamicsError, match="no mass"):
        chain.forward_dynamics(chain.home, [1.0], [1.0])
