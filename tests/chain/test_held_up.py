"""Weights that are compensated in part: as loads that lift the centres of mass, in energy, and with a payload."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.held_up import held_up, lifts, weighing
from kit.quickly import few
from kit.random_robots import random_robot

from cutjoint.chain import ClosedChain
from cutjoint.chain.rank import null_space
from cutjoint.chain.reactions.link_needs import LinkNeeds
from cutjoint.description import load_description, with_values
from cutjoint.errors import CutjointError

SHIPPED = ("fourbar", "fivebar", "omega3", "cpm", "stewart")


def drawn(seed: int, folder: Path) -> tuple[ClosedChain, ClosedChain]:
    """A random robot that is held up, and the same without."""
    rng = np.random.default_rng(seed)
    plan = random_robot(rng, int(rng.integers(2, 7)), int(rng.integers(1, 4)), folder)
    robot = held_up(load_description(plan.write(folder)), rng)
    return ClosedChain(robot), ClosedChain(weighing(robot))


def near(found: np.ndarray, wanted: np.ndarray, terms: float) -> None:
    assert np.abs(np.asarray(found) - wanted).max(initial=0.0) <= 1e-9 * terms


@pytest.mark.parametrize("seed", few(range(40), 0, 1, 2))
def test_random_robots_move_as_if_lifted(seed: int, tmp_path: Path) -> None:
    """Accelerations, loop forces and reactions are those of loads at the centres of mass."""
    (chain, plain), rng = drawn(seed, tmp_path), np.random.default_rng(seed)
    loads, home = lifts(chain.description), plain.home
    motions = null_space(plain._k.at(home.q_full).scaled)
    v = plain._k.column_scale * (motions @ rng.normal(size=motions.shape[1]))
    effort = rng.normal(size=plain.nv)
    try:
        wanted = plain.full_forward_dynamics(home, v, effort, loads)
    except CutjointError as error:
        with pytest.raises(type(error)):
            chain.full_forward_dynamics(chain.home, v, effort)
        return
    found = chain.full_forward_dynamics(chain.home, v, effort)
    unit = plain._k.column_scale
    near(found.acceleration / unit, wanted.acceleration / unit, 1.0 + np.abs(wanted.acceleration / unit).max(initial=0))
    near(chain.full_acceleration(home.q_full, v, effort) / unit, wanted.acceleration / unit,
         1.0 + np.abs(wanted.acceleration / unit).max(initial=0))  # fmt: skip
    for name, force in wanted.loop_forces.items():
        near(found.loop_forces[name].force, force.force, 100.0 + np.abs(force.force).max())
    lifted = chain.full_reactions(chain.home, v, wanted.acceleration, effort)
    for one, other in zip(lifted, plain.full_reactions(home, v, wanted.acceleration, effort, loads), strict=True):
        near(one.wrench, other.wrench, 100.0 + np.abs(other.wrench).max())


@pytest.mark.parametrize("name", few(SHIPPED, "fivebar", "stewart"))
def test_motors_feel_it(name: str) -> None:
    """Efforts, accelerations and reactions in actuated coordinates, and what a compensated link and a payload weigh."""
    rng = np.random.default_rng(1)
    robot = held_up(load_description(name), rng)
    assert robot.tool is not None
    links = (replace(one, gravity_compensation=1.0) if one.name == robot.tool.link else one for one in robot.links)
    chain = ClosedChain(replace(robot, links=tuple(links))).with_payload(1.5)
    robot, plain = chain.description, ClosedChain(weighing(chain.description))
    at, home, loads = chain.home, plain.home, lifts(robot)
    v, a, effort = rng.normal(size=(3, chain.n))
    needed = plain.inverse_dynamics(home, v, a, loads)
    near(chain.inverse_dynamics(at, v, a), needed, np.abs(needed).max())
    made = plain.forward_dynamics(home, v, effort, loads)
    near(chain.forward_dynamics(at, v, effort), made, np.abs(made).max())
    for one, other in zip(chain.reactions(at, v, a), plain.reactions(home, v, a, loads=loads), strict=True):
        near(one.wrench, other.wrench, 100.0 + np.abs(other.wrench).max())


@pytest.mark.parametrize("seed", few(range(40), 0, 1))
@pytest.mark.parametrize("far", [0.0, 2e4])
def test_energy_is_that_of_what_is_left_of_the_weights(seed: int, far: float, tmp_path: Path) -> None:
    """Sum of -(1 - share) m g . c over all moving links, also of a robot that stands far from the origin."""
    robot = drawn(seed, tmp_path)[0].description
    moved = np.eye(4)
    moved[:3, 3] = far * np.array([0.6, -0.5, 0.62])
    based = {one.name: moved @ one.placement for one in robot.joints if one.parent == robot.root}
    joints = [replace(one, placement=based.get(one.name, one.placement)) for one in robot.joints]
    ends = [[replace(end, placement=moved @ end.placement) if end.link == robot.root else end for end in (cut.a, cut.b)]
            for cut in robot.cuts]  # fmt: skip
    cuts = [replace(cut, a=a, b=b) for cut, (a, b) in zip(robot.cuts, ends, strict=True)]
    chain = ClosedChain(replace(robot, joints=tuple(joints), cuts=tuple(cuts)))
    k, q = chain._k, chain.home.q_full
    wanted = terms = 0.0
    needs = LinkNeeds(k)
    for link, joint, place in zip(robot.links, needs.joint, needs.placements(q), strict=True):
        if joint and link.inertial is not None:
            centre = place[:3, :3] @ link.inertial.com + place[:3, 3] + k.origin
            wanted -= (1.0 - link.gravity_compensation) * link.inertial.mass * float(robot.gravity @ centre)
            terms += link.inertial.mass * np.abs(robot.gravity) @ np.abs(centre)
    assert chain.potential_energy(chain.home) == pytest.approx(wanted, abs=1e-12 * terms)


def test_with_values_the_share_stays() -> None:
    robot = load_description("fivebar")
    name = next(link.name for link in robot.links if link.inertial)
    links = (replace(one, gravity_compensation=0.4) if one.name == name else one for one in robot.links)
    robot = with_values(replace(robot, links=tuple(links)), {f"links.{name}.mass": 3.0})
    assert robot.link(name).held_up == pytest.approx(1.2)
    assert robot.ideal().link(name).gravity_compensation == 0.4
