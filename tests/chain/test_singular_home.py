"""Robots whose home is singular: elsewhere they work, and where branches meet nobody picks one in silence."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.blueprint import Blueprint, random_mounting, random_rotation
from kit.built import built
from kit.judge import actuated, require
from kit.mechanisms import MECHANISMS, limb, on_circle

from cutjoint.chain import ClosedChain
from cutjoint.description import load_description
from cutjoint.errors import ActuationError, ClosureError, CutjointError, SingularError

Rng = np.random.Generator
_, _, Z = np.eye(3)


def parallelogram(rng: Rng) -> Blueprint:
    """Flat: all four hinges on one line."""
    return MECHANISMS["parallelogram_flat"](rng).plan


def kite(rng: Rng) -> Blueprint:
    """Two pairs of equal sides, folded onto one line: crank and coupler are equal, base and rocker are.

    From there it opens as a kite, or crank and coupler turn together about one point while the rocker stays.
    """
    plan, tilt = Blueprint("kite", rng), random_rotation(rng)
    axis, start = tilt @ Z, np.zeros(3)
    crank, base = tilt @ on_circle(rng.uniform(0.15, 0.25), 0.0), tilt @ on_circle(rng.uniform(0.35, 0.5), 0.0)
    limb(plan, "a", "base", [("continuous", start, axis), ("continuous", crank, axis)])
    limb(plan, "b", "base", [("continuous", base, axis)])
    plan.cut("pin", "revolute", "a_link2", "b_link1", start, axis)
    plan.actuators, plan.tool = ["a1"], ("a_link2", 0.5 * crank)
    return plan


def antiparallelogram(rng: Rng) -> Blueprint:
    """Driven at the second crank, and gravity across."""
    plan = parallelogram(rng)
    plan.actuators, plan.gravity = ["b1"], rng.normal(size=3) * 5.0
    return plan


FAMILIES: dict[str, Callable[[Rng], Blueprint]] = {
    "parallelogram": parallelogram,
    "kite": kite,
    "driven at the other end": antiparallelogram,
}


def at_some_size(plan: Blueprint, folder: Path, rng: Rng) -> ClosedChain:
    """The robot mounted anywhere, from a millimetre to a kilometre."""

    scale = 10.0 ** rng.uniform(-3, 3)
    return ClosedChain(
        load_description(plan.write(folder, random_mounting(rng, scale), scale, 10.0 ** rng.uniform(-3, 3)))
    )


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("seed", range(6))
def test_no_branch_is_picked_in_silence(name: str, seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    chain = at_some_size(FAMILIES[name](rng), tmp_path, rng)
    report = chain.mobility()
    assert report.mobility == 2
    assert not report.determined
    assert not report.type2 > 1e-6
    for step in (1e-6, 1e-3, 0.1, -0.3, 1.0):
        with pytest.raises(SingularError) as caught:
            chain.close(chain.home.q + step)
        assert caught.value.kind == "type-2"
    assert np.allclose(chain.close(chain.home.q).q, chain.home.q), "staying is no choice"
    for call in (chain.tangent, chain.terms):
        with pytest.raises(SingularError):
            call(chain.home)
    with pytest.raises(SingularError):
        chain.inverse_dynamics(chain.home, [0.0], [0.0])
    # through the meeting point from outside: also there no branch is picked
    beside = regular(chain, rng)
    with pytest.raises((SingularError, ClosureError)):
        chain.close(2.0 * chain.home.q - beside.q, beside)


def regular(chain: ClosedChain, rng: Rng) -> Any:
    """A posture away from home that is none of the singular ones."""
    for _ in range(40):
        q = chain.integrate(chain.home.q_full, 0.5 * rng.uniform(-1.0, 1.0, chain.nv) * chain._k.column_scale)
        try:
            at = chain.assemble(q)
        except CutjointError:
            continue
        if chain.mobility(at).type2 > 0.05:
            return at
    raise AssertionError("no regular posture")


@pytest.mark.parametrize("name", [*FAMILIES, "upu_3_equal"])
def test_away_from_home_everything_works(name: str, tmp_path: Path) -> None:
    """By the oracle, from postures given by assemble() and by close() near them."""
    for seed in range(3):
        rng = np.random.default_rng(10 + seed)
        plan = FAMILIES[name](rng) if name in FAMILIES else MECHANISMS[name](rng).plan
        chain, oracle = built(plan, tmp_path / str(seed))
        assert not chain.mobility().determined
        at = regular(chain, rng)
        assert chain.mobility(at).determined
        found = actuated(chain, oracle, at, rng)
        assert found, "the oracle thinks so too"
        require(found, 1e-9, name)
        units = np.array([chain.length if one.kind == "translation" else 1.0 for one in chain.actuators])
        beside = chain.close(at.q + 0.01 * units * rng.uniform(-1.0, 1.0, chain.n), at)
        assert chain.mobility(beside).determined
        require(actuated(chain, oracle, beside, rng), 1e-9, name)
        tool = chain.tool(beside).position
        np.testing.assert_allclose(chain.tool(chain.reach(tool, at)).position, tool, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize(
    "name",
    [
        "parallelogram_flat",
        "upu_3_equal",
        "prs_3",
        "geared_fivebar",
        pytest.param("planar_3rrr", marks=pytest.mark.slow),
        pytest.param("ups_6", marks=pytest.mark.slow),
    ],
)
def test_mobility_and_inverse_dynamics_agree_at_every_posture(name: str, tmp_path: Path) -> None:
    """Determined there means effort there, and the other way round; home decides nothing."""
    rng = np.random.default_rng(3)
    chain, _ = built(MECHANISMS[name](rng).plan, tmp_path)
    still, seen = np.zeros(chain.n), 0
    for _ in range(100):
        step = rng.uniform(-1.0, 1.0, chain.nv) * chain._k.column_scale
        q = chain.integrate(chain.home.q_full, step * rng.uniform(0.0, 0.6))
        try:
            at = chain.assemble(q, keep_actuators=bool(rng.integers(2)))
        except ClosureError:
            continue
        try:
            chain.inverse_dynamics(at, still, still)
            works = True
        except (SingularError, ActuationError):
            works = False
        report = chain.mobility(at)
        if not 1e-7 < report.type2 < 1e-5:  # between the two limits a posture has full rank but too few digits
            assert report.determined is works, report
        seen += works
    assert seen > 20


@pytest.mark.parametrize("seed", range(4))
def test_a_shaky_structure_moves_only_for_a_moment(seed: int, tmp_path: Path) -> None:
    """Two links stretched between two hinges: by its rank it can move, and any speed opens it in the next moment."""
    rng = np.random.default_rng(seed)
    plan, tilt = Blueprint("arch", rng), random_rotation(rng)
    first, second = rng.uniform(0.2, 0.5, 2)
    along, axis = tilt @ on_circle(1.0, 0.0), tilt @ Z
    limb(plan, "a", "base", [("continuous", np.zeros(3), axis), ("continuous", first * along, axis)])
    plan.cut("end", "revolute", "a_link2", "base", (first + second) * along, axis)
    plan.actuators = ["a1"]
    chain, _ = built(plan, tmp_path, random_mounting(rng))
    assert chain.mobility().mobility == 1
    chain.inverse_dynamics(chain.home, [0.0], [0.0])
    for call in (chain.inverse_dynamics, chain.forward_dynamics):
        with pytest.raises(SingularError, match="only for a moment"):
            call(chain.home, [0.7], [0.0])
    v = np.array(chain.full_velocity(chain.home, [0.7]))
    with pytest.raises(CutjointError):
        chain.full_forward_dynamics(chain.home, v, np.zeros(chain.nv))
