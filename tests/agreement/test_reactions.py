"""Reactions in all joints, cuts and couplings against the maximal-coordinate oracle, with all joint physics."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.blueprint import random_mounting
from kit.built import built_with_physics
from kit.by_joint import by_joint, coordinates
from kit.loops import CUTS, EXTRAS, SPACES, loop
from kit.mechanisms import MECHANISMS
from kit.postures import moving, random_posture
from kit.quickly import few
from kit.random_robots import random_robot
from kit.verdict import CLEAR
from oracles.maximal import Maximal
from oracles.motion import Motion
from oracles.reactions import Reactions as Judge

from cutjoint.chain import ClosedChain
from cutjoint.errors import CutjointError
from cutjoint.mechanism import Load

Array = np.ndarray


def named(found: Any) -> dict[str, Any]:
    return {**found.joints, **found.cuts}


def distance(found: Any, judge: Judge, *, everything: bool) -> float:
    """Largest difference of a component, forces times the length, against the largest there is; the unique ones, or,
    where everything is decided alike, all of them."""
    length, pairs, size = judge.p.oracle.length, [], 1e-300
    for name, one in named(found).items():
        force, moment = judge.of[name]
        wanted, given = np.r_[length * force, moment], np.r_[length * one.force, one.moment]
        chosen = np.ones(6, dtype=bool) if everything else np.array(one.unique)
        pairs.append(np.abs(given - wanted)[chosen])
        size = max(size, float(np.abs(wanted).max()))
        np.testing.assert_allclose(one.point, judge.p.oracle.origin + point(judge, name), atol=1e-9 * length, rtol=0)
    return float(np.concatenate([np.zeros(1), *pairs]).max()) / size


def point(judge: Judge, name: str) -> Array:
    p = judge.p
    return p.points[name] if name in p.points else p.poses[next(
        joint.child for joint in p.oracle.robot.joints if joint.name == name
    )].position  # fmt: skip


def loads_on(oracle: Maximal, placed: Any, rng: np.random.Generator, weight: float) -> tuple[list[Load], Array]:
    """A load on every other link, in world or link axes, and the oracle's wrenches of them."""
    found, outside = [], np.zeros(oracle.size)
    for index, link in enumerate(oracle.column):
        force, moment, at = rng.normal(size=(3, 3)) * [[weight], [weight * oracle.length], [oracle.length]]
        if index % 2:
            axes = "link" if index % 4 == 1 else "world"
            found.append(Load(force, moment, link, at, axes))
            turn = placed.poses[link].rotation if axes == "link" else np.eye(3)
            outside += placed.wrench(link, turn @ force, turn @ moment, at)
    return found, outside


def motion_of(
    chain: ClosedChain, oracle: Maximal, at: Any, rng: np.random.Generator, weight: float
) -> tuple[Motion, Mapping[str, Any]]:
    """A random motion of all joints with random efforts and loads, as the oracle has it and as arguments."""
    placed = oracle.at(coordinates(chain, at.q_full))
    speed = np.sqrt(9.81 / oracle.length)
    scale = placed._velocity_scale
    v = moving(chain, placed, speed * rng.normal(size=placed.mobility))
    loads, outside = loads_on(oracle, placed, rng, weight)
    state = placed.moving(by_joint(chain, v), outside)
    effort = {name: weight * oracle.length / scale[own] * rng.normal(size=own.stop - own.start)
              for name, own in oracle.velocity.items()}  # fmt: skip
    motion = state.driven(effort)
    flat = {name: motion.flat[own] for name, own in oracle.velocity.items()}
    full = [np.concatenate([np.zeros(0)] + [np.atleast_1d(one[chain.model.names[i]]) for i in
            range(1, chain.model.njoints)]) for one in (flat, effort)]  # fmt: skip
    return motion, {"v_full": v, "a_full": full[0], "effort_full": full[1], "loads": loads}


def judged(chain: ClosedChain, oracle: Maximal, at: Any, rng: np.random.Generator, weight: float) -> bool:
    """Least reactions, those by stiffnesses of some and of all; what is unique, and how often redundant."""
    motion, given = motion_of(chain, oracle, at, rng, weight)
    p = motion.state.placed
    bare = motion.state.massless.shape[1] or motion.unmet[0] > 1e-9 * max(1.0, np.abs(motion.accelerations).max())
    if bare or p.margin[0] < CLEAR[0] or p.margin[1] > CLEAR[1]:
        return False
    allowed = max(1e-9, 1e-13 * p.margin[0] ** -2)
    found, judge = chain.full_reactions(at, **given), Judge(motion)
    assert found.redundancy == found.undecided == judge.null.shape[1]
    assert distance(found, judge, everything=True) < allowed
    for name, one in named(found).items():
        sizes = np.abs(judge.stresses(name)).max(axis=1, initial=0.0)
        assert one.unique == tuple(sizes < 1e-9), (name, sizes)
    for name, one in found.couplings.items():
        own = judge.multipliers[judge.own[name]][0] / p._unit(next(
            gear.joint for gear in oracle.robot.couplings if gear.name == name))  # fmt: skip
        largest = max(
            float(np.abs(np.r_[one.force * oracle.length, one.moment]).max()) for one in named(found).values()
        )
        assert abs(one.force - own) < allowed * max(abs(own), largest)
    for part in (1.0, 0.4):
        stiffness = _stiffness(judge, rng, weight, part)
        decided = chain.full_reactions(at, **given, stiffness=stiffness)
        assert distance(decided, Judge(motion, stiffness), everything=True) < 10.0 * allowed
        assert decided.undecided == 0 or part < 1.0
        assert distance(decided, judge, everything=False) < allowed or decided.undecided < found.undecided
    return True


def _stiffness(judge: Judge, rng: np.random.Generator, weight: float, part: float) -> dict[str, Any]:
    length, found = judge.p.oracle.length, {}
    k = 1e6 * weight / length
    for name in judge.own:
        if rng.uniform() < part:
            if name not in judge.rows:
                found[name] = k * rng.uniform(0.2, 1.0)
            elif rng.integers(2):
                found[name] = rng.uniform(0.2, 1.0, 6) * k * np.r_[1.0, 1.0, 1.0, [length**2] * 3]
            else:
                found[name] = k * rng.uniform(0.2, 1.0)
    return found


@pytest.mark.parametrize("extra", EXTRAS)
@pytest.mark.parametrize("cut", CUTS)
@pytest.mark.parametrize("space", few(SPACES))
def test_loops_of_every_kind(space: str, cut: str, extra: str, tmp_path: Path) -> None:
    rng = np.random.default_rng([SPACES.index(space), CUTS.index(cut), EXTRAS.index(extra)])
    plan, _ = loop(space, cut, extra, rng)
    chain, oracle = built_with_physics(plan, tmp_path, rng, random_mounting(rng))
    assert judged(chain, oracle, chain.home, rng, 9.81)


@pytest.mark.parametrize("name", few(MECHANISMS, "planar_3rrr", "geared_fivebar", "upu_3", "hexapod"))
@pytest.mark.parametrize("scale", few([1e-3, 1.0, 1e3], 1e-3, 1e3))
def test_mechanisms_at_every_scale(name: str, scale: float, tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    plan = MECHANISMS[name](rng).plan
    chain, oracle = built_with_physics(plan, tmp_path, rng, random_mounting(rng, scale), scale)
    at = random_posture(chain, oracle, rng)
    assert judged(chain, oracle, at, rng, 9.81) or name in ("upu_3_equal", "parallelogram_flat")


@pytest.mark.parametrize("seed", few(range(200), *range(20)))
def test_random_robots(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    plan = random_robot(rng, int(rng.integers(1, 8)), int(rng.integers(0, 4)), tmp_path / "tried")
    rubber = tuple(cut.name for cut in plan.cuts if rng.integers(4) == 0)
    try:
        chain, oracle = built_with_physics(plan, tmp_path, rng, random_mounting(rng), rubber=rubber)
    except CutjointError as error:
        pytest.skip(f"refused: {error}")
    if not judged(chain, oracle, chain.home, rng, 9.81):
        pytest.skip("nearly singular, without mass, or no acceleration keeps it closed")
