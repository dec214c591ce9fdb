"""Mechanisms of the textbooks, in random shapes and mountings: mobility as known, dynamics as the oracle's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kit import judge
from kit.blueprint import random_mounting
from kit.built import at_home, built
from kit.by_joint import by_joint, placed
from kit.mechanisms import MECHANISMS, Mechanism
from kit.postures import moving, random_posture
from oracles.maximal import Maximal
from oracles.placed import Placed

from cutjoint.errors import CompileError, CutjointError, SingularError

ACCURACY = 1e-10
"""Relative: two formulations in double precision, away from singular postures."""

SINGULAR_HOMES = [name for name, builder in MECHANISMS.items() if builder(np.random.default_rng(0)).at_home]


def drawn(name: str, seed: int, folder: Path) -> tuple[Mechanism, Placed]:
    rng = np.random.default_rng(seed)
    mechanism = MECHANISMS[name](rng)
    oracle = Maximal(mechanism.plan.write(folder, random_mounting(rng)), length=0.3)
    return mechanism, oracle.at(at_home(mechanism.plan, oracle))


@pytest.mark.parametrize("name", MECHANISMS)
def test_the_oracle_counts_what_the_books_say(name: str, tmp_path: Path) -> None:
    for seed in range(3):
        mechanism, home = drawn(name, seed, tmp_path / str(seed))
        assert max(map(max, home.gaps.values())) < 1e-14
        assert home.mobility == (mechanism.at_home or mechanism.mobility)
        assert home.margin[0] > 1e-3 > 1e9 * home.margin[1]


def test_what_the_tools_do(tmp_path: Path) -> None:
    """Peaucellier's point moves square to the line O-Q, Sarrus's plate straight, that of the 3-UPU without turning."""
    mechanism, home = drawn("peaucellier", 5, tmp_path / "p")
    state = home.moving({})
    state.twists = home.motions[:, 0]
    link, point = mechanism.plan.tool
    base = home.poses["base"]
    pose = mechanism.plan.poses[link]
    arm = home.poses[link].rotation @ (pose.rotation.T @ (point - pose.position))
    v, w = state.twist(link)
    speed = v + np.cross(w, arm)
    across = base.rotation @ np.array([0.0, 1.0, 0.0])
    assert np.linalg.norm(np.cross(speed, across)) < 1e-13 < 1e-3 < np.linalg.norm(speed)
    for name, link, motions in (("sarrus", "a_link3", 1), ("upu_3", "plate", 3)):
        _, home = drawn(name, 6, tmp_path / name)
        twists = home.motions[home.oracle.column[link] :][:6]
        assert np.abs(twists[3:]).max() < 1e-13, "it turns"
        assert np.linalg.matrix_rank(twists[:3], tol=1e-3) == motions


def check(name: str, seeds: range, postures: int, folder: Path) -> None:
    for seed in seeds:
        rng = np.random.default_rng([seed, *name.encode()])
        mechanism = MECHANISMS[name](rng)
        chain, oracle = built(mechanism.plan, folder / str(seed), random_mounting(rng))
        stops = [random_posture(chain, oracle, rng, mobility=mechanism.mobility) for _ in range(postures)]
        if not mechanism.at_home:
            stops.append(chain.home)
        for at in stops:
            p = placed(chain, oracle, at.q_full)
            assert p.mobility == mechanism.mobility
            v, effort = moving(chain, p, rng.normal(size=p.mobility)), rng.normal(size=chain.nv)
            judge.require(judge.everything(chain, oracle, at, v, effort, rng), ACCURACY)


@pytest.mark.parametrize("name", MECHANISMS)
def test_everything(name: str, tmp_path: Path) -> None:
    check(name, range(1), 1, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", MECHANISMS)
def test_everything_in_many_shapes(name: str, tmp_path: Path) -> None:
    check(name, range(1, 13), 3, tmp_path)


@pytest.mark.parametrize("name", SINGULAR_HOMES)
def test_at_a_singular_home(name: str, tmp_path: Path) -> None:
    """Counted as what it is, at rest as Newton says, and no branch is picked in silence."""
    rng = np.random.default_rng(3)
    mechanism = MECHANISMS[name](rng)
    chain, oracle = built(mechanism.plan, tmp_path, random_mounting(rng))
    judge.mobility(chain, oracle, chain.home)
    assert chain.mobility().mobility == mechanism.at_home
    rest = np.zeros(chain.nv)
    state = placed(chain, oracle, chain.home.q_full).moving({})
    judge.require(judge.forward(chain, state, chain.home, rest, rng.normal(size=chain.nv)), ACCURACY)
    with pytest.raises(SingularError):
        chain.close(chain.home.q + 0.1)
    opening = 0
    for _ in range(8):
        v = moving(chain, state.placed, rng.normal(size=state.placed.mobility))
        motion = state.placed.moving(by_joint(chain, v)).driven({})
        if judge.opens(motion):
            opening += 1
            with pytest.raises(CutjointError):
                chain.full_forward_dynamics(chain.home, v, rest)
    assert opening, "speeds that belong to no branch have no acceleration"


@pytest.mark.slow
@pytest.mark.parametrize("name", MECHANISMS)
def test_compiled(name: str, tmp_path: Path) -> None:
    pytest.importorskip("llvmlite")
    rng = np.random.default_rng(4)
    mechanism = MECHANISMS[name](rng)
    chain, oracle = built(mechanism.plan, tmp_path, random_mounting(rng))
    at = random_posture(chain, oracle, rng, mobility=mechanism.mobility)
    p = placed(chain, oracle, at.q_full)
    v, effort = moving(chain, p, rng.normal(size=p.mobility)), rng.normal(size=chain.nv)
    try:
        found = judge.everything(chain, oracle, at, v, effort, rng, chain.compile())
    except CompileError:
        if not mechanism.at_home:
            raise
        return  # where branches meet at home, no order of elimination is good
    judge.require(found, ACCURACY)
