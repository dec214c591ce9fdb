"""Joint physics in the maximal-coordinate oracle, by its own laws: energy, momentum, the balance of every link."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from agreement.test_maximal_laws import advanced, near, tree_state, values, write_tree
from kit.built import at_home
from kit.loops import CUTS, SPACES, loop
from kit.quickly import few
from kit.random_robots import random_robot
from oracles.maximal import Maximal
from oracles.motion import Motion
from oracles.physics import Bush, Law, smooth_sign
from oracles.reactions import Reactions

Array = np.ndarray
SPRUNG = ("revolute", "continuous", "prismatic", "universal", "spherical")


def random_law(rng: np.random.Generator, kind: str) -> Law:
    """Everything that a joint or cut of this kind may have, its stops so near that they are hit."""
    damping, armature = rng.uniform(0.1, 2.0, 2)
    if kind not in SPRUNG:
        return Law(damping=damping, armature=armature)
    friction, stiffness, stop, stop_damping = rng.uniform(0.1, 5.0, 4)
    speed = float(rng.choice([0.01, 3.0]))
    law = Law(damping, friction, speed, stiffness, 0.0 if kind == "spherical" else float(rng.normal()), armature)
    if kind in ("revolute", "continuous", "prismatic"):
        law = Law(**{**vars(law), "stop_stiffness": 20.0 * stop, "stop_damping": stop_damping, "upper": -0.3})
    return law


def random_laws(oracle: Maximal, rng: np.random.Generator) -> dict[str, Law]:
    robot = oracle.robot
    return {one.name: random_law(rng, one.kind) for one in (*robot.joints, *robot.cuts) if one.kind != "fixed"}


def energy_rate(oracle: Maximal, at: dict[str, Any], rates: Array, motion: Motion, h: float = 1e-5) -> float:
    def energy(time: float) -> float:
        step = values(oracle, time * rates + 0.5 * time**2 * motion.flat)
        there = oracle.at(advanced(oracle, at, step)).moving(values(oracle, rates + time * motion.flat))
        return there.kinetic_energy + there.placed.potential_energy

    return (energy(h) - energy(-h)) / (2 * h)


def balanced(motion: Motion) -> float:
    """Largest part of any link's momentum change that its joints and cuts, gravity and loads do not make."""
    p, found = motion.state.placed, Reactions(motion).of
    robot, rates = p.oracle.robot, p.bodies @ motion.accelerations + motion.state.gyroscopic_of_bodies
    left, terms = rates - p.weight - motion.state.outside, np.abs(rates) + np.abs(p.weight)
    pairs = [(joint.name, joint.parent, joint.child, p.poses[joint.child].position) for joint in robot.joints]
    pairs += [(cut.name, cut.a.link, cut.b.link, p.points[cut.name]) for cut in robot.cuts]
    for name, parent, child, point in pairs:
        force, moment = found[name]
        for link, sign in ((parent, -1.0), (child, 1.0)):
            if link in p.oracle.column:
                arm = point - p.poses[link].position
                own = slice(p.oracle.column[link], p.oracle.column[link] + 6)
                left[own] -= sign * np.r_[force, moment + np.cross(arm, force)]
                terms[own] += np.abs(np.r_[force, moment])
    return float(np.abs(left).max() / max(terms.max(), 1e-300))


def test_the_sign_of_friction_is_smooth() -> None:
    """1 from its speed on, odd, and with two derivatives that meet there."""
    h, u = 1e-4, 0.3
    for speed in (1e-3, 1.0, 50.0):
        found = [smooth_sign(x * speed, speed) for x in (1.0 - 2 * h, 1.0 - h, 1.0, 1.2)]
        assert found[2:] == [1.0, 1.0]
        assert 0.0 < found[2] - found[1] < 8 * h**3
        assert 0.0 < found[1] - found[0] < 60 * h**3
        assert smooth_sign(-u * speed, speed) == -smooth_sign(u * speed, speed)
    assert [smooth_sign(x, 0.0) for x in (-1e-9, 0.0, 2.0)] == [-1.0, 0.0, 1.0]


@pytest.mark.parametrize("seed", range(6))
def test_energy_changes_by_power_and_losses(seed: int, tmp_path: Path) -> None:
    """A tree of joints of every type, with everything that joints can do."""
    plain, rng = Maximal(write_tree(tmp_path, seed)), np.random.default_rng(seed)
    oracle = Maximal(tmp_path, laws=random_laws(plain, rng))
    at = tree_state(rng)
    placed = oracle.at(at)
    rates = placed.joint_motions() @ rng.normal(size=placed.mobility)
    state = placed.moving(values(oracle, rates), outside := rng.normal(size=oracle.size))
    efforts = 4.0 * rng.normal(size=oracle.velocities)
    motion = state.driven(values(oracle, efforts))
    power = float(efforts @ rates + outside @ state.twists) - state.wasted
    assert energy_rate(oracle, at, rates, motion) == pytest.approx(power, rel=3e-7, abs=1e-6)
    assert state.wasted > 0.1
    assert balanced(motion) < 1e-12
    inner = Maximal(tmp_path, laws={name: law for name, law in oracle.laws.items() if name != "j0"}).at(at)
    free = inner.moving(values(oracle, rates)).driven({})
    near(np.r_[Reactions(free).of["j0"]], np.zeros(6), 1e-10)


@pytest.mark.parametrize("cut", CUTS)
@pytest.mark.parametrize("space", few(SPACES, "spatial"))
@pytest.mark.parametrize("cushioned", [False, True])
def test_cuts_and_their_bushings(cut: str, space: str, cushioned: bool, tmp_path: Path) -> None:
    """The same in a loop, with physics at the cut or a bushing for it, which is open then."""
    rng = np.random.default_rng(7)
    plan, _ = loop(space, cut, "none", rng)
    plain = Maximal(plan.write(tmp_path))
    bush = {"cut": Bush(*rng.uniform(1.0, 30.0, 4))} if cushioned else {}
    laws = random_laws(plain, rng)
    if cushioned and "cut" in laws:  # the free motion of an open cut has coordinates of no sharp meaning
        del laws["cut"]
    oracle = Maximal(tmp_path, laws=laws, bushings=bush, length=0.3)
    at = at_home(plan, oracle)
    if cushioned:
        at = advanced(oracle, at, values(oracle, 0.2 * rng.normal(size=oracle.velocities)))
    placed = oracle.at(at)
    rates = placed.joint_motions() @ rng.normal(size=placed.mobility)
    state = placed.moving(values(oracle, rates))
    efforts = rng.normal(size=oracle.velocities)
    motion = state.driven(values(oracle, efforts))
    rate = energy_rate(oracle, at, rates, motion)
    assert rate == pytest.approx(float(efforts @ rates) - state.wasted, rel=1e-6, abs=1e-5)
    if not cushioned:  # what acts at two points while a bushing is open is no single wrench
        assert balanced(motion) < 1e-11


@pytest.mark.parametrize("seed", few(range(40), *range(8)))
def test_reactions_balance_every_link(seed: int, tmp_path: Path) -> None:
    """Random robots: the least reactions, and those by any stiffnesses, carry every link; stresses carry nothing."""
    rng = np.random.default_rng(seed)
    plan = random_robot(rng, int(rng.integers(2, 7)), int(rng.integers(1, 4)), tmp_path)
    plain = Maximal(plan.write(tmp_path), length=0.3)
    oracle = Maximal(tmp_path, length=0.3, laws=random_laws(plain, rng))
    placed = oracle.at(at_home(plan, oracle))
    state = placed.moving(values(oracle, placed.joint_motions() @ rng.normal(size=placed.mobility)))
    motion = state.driven(values(oracle, rng.normal(size=oracle.velocities)))
    if motion.unmet[0] > 1e-9 or placed.margin[0] < 1e-4:
        pytest.skip("no acceleration keeps it closed, or nearly singular")
    assert balanced(motion) < 1e-11
    least = Reactions(motion)
    stated = Reactions(motion, {name: rng.uniform(1.0, 3.0, 6) for name in least.rows})
    for name in least.of:
        shift = np.r_[stated.of[name]] - np.r_[least.of[name]]
        unique = np.abs(least.stresses(name)).max(axis=1, initial=0.0) < 1e-9
        size = max(float(np.abs(np.r_[least.of[name]]).max()), 1.0)
        assert float(np.abs(shift[unique]).max(initial=0.0)) < 1e-8 * size, name
