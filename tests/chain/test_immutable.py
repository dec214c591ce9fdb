"""Nothing that is handed out can be written into, and no call changes what another one sees."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import FrozenInstanceError
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.description import load_description
from cutjoint.mechanism import Mechanism

V, A = np.array([0.3, -0.2, 0.5]), np.array([1.0, 2.0, -1.0])


@pytest.mark.parametrize("name", ["cpm", "omega3"])
def test_arrays_of_results_cannot_be_written_into(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    at = chain.close(chain.home.q + 0.01)
    tool, terms = chain.tool(at, V), chain.terms(at, V)
    motion = chain.full_forward_dynamics(at, np.array(chain.full_velocity(at, V)), chain.full_effort(A))
    wrench = next(iter(motion.loop_forces.values()))
    for array in (
        at.q,
        at.q_full,
        chain.home.q_full,
        tool.position,
        tool.jacobian,
        tool.drift,
        terms.mass,
        terms.coriolis,
        terms.gravity,
        chain.tangent(at),
        motion.acceleration,
        wrench.force,
        wrench.moment,
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0
    with pytest.raises(FrozenInstanceError):
        at.q = at.q


@pytest.mark.parametrize("name", ["cpm", "omega3"])
def test_results_are_not_views_of_a_workspace(name: str, kit: Any) -> None:
    """What a call returned stays as it was while the chain goes on working."""
    chain = kit.robot(name)
    at = chain.home

    def everything() -> list[np.ndarray]:
        tool, terms = chain.tool(at, V), chain.terms(at, V)
        effort = chain.inverse_dynamics(at, V, A)
        motion = chain.full_forward_dynamics(at, chain.full_velocity(at, V), chain.full_effort(A))
        return [
            tool.position,
            tool.jacobian,
            tool.drift,
            terms.mass,
            terms.coriolis,
            terms.gravity,
            effort,
            chain.forward_dynamics(at, V, effort),
            motion.acceleration,
            chain.constraint_jacobian(at),
            chain.drift(at, V),
            *chain.link_placements(at).values(),
        ]

    first = everything()
    copies = [np.array(one) for one in first]
    other = chain.close(chain.home.q + 0.02)
    chain.tool(other, A)
    chain.terms(other, A)
    chain.inverse_dynamics(other, A, V)
    chain.forward_dynamics(other, A, V)
    chain.mobility(other)
    chain.working_modes(starts=2)
    for one, copy in zip(first, copies, strict=True):
        np.testing.assert_array_equal(one, copy)
    for one, copy in zip(everything(), copies, strict=True):
        np.testing.assert_array_equal(one, copy)


def test_arguments_are_not_kept_or_changed(kit: Any) -> None:
    chain = kit.robot("cpm")
    q, v = np.array(chain.home.q) + 0.01, V.copy()
    at = chain.close(q)
    terms = chain.terms(at, v)
    kept = np.array(terms.coriolis)
    q += 1.0
    v += 1.0
    np.testing.assert_array_equal(at.q, chain.home.q + 0.01)
    np.testing.assert_array_equal(terms.coriolis, kept)
    np.testing.assert_array_equal(chain.terms(at, V).coriolis, kept)


def test_the_model_is_not_touched(kit: Any) -> None:
    chain = ClosedChain(load_description("omega3"))
    before = chain.model.copy()
    at = chain.reach(chain.tool(chain.home).position + 0.01)
    chain.terms(at, V)
    chain.forward_dynamics(at, V, A)
    chain.with_payload(2.0).terms(at, V)
    chain.working_modes(starts=3)
    assert chain.model == before
    assert chain.with_payload(2.0).model != before


def test_two_chains_of_one_description_do_not_share_a_workspace() -> None:
    description = load_description("cpm")
    one, two = ClosedChain(description), ClosedChain(description)
    wanted = one.inverse_dynamics(one.home, V, A)
    moved = two.close(two.home.q + 0.05)
    two.terms(moved, A)
    np.testing.assert_array_equal(one.inverse_dynamics(one.home, V, A), wanted)
    np.testing.assert_array_equal(two.inverse_dynamics(two.home, V, A), wanted)
    assert one.model is not two.model


def test_postures_are_shared_between_a_robot_and_its_variants_and_payloads(kit: Any) -> None:
    lumped, uniform = kit.robot("cpm", "lumped"), kit.robot("cpm", "distributed")
    at = lumped.close(lumped.home.q + 0.02)
    for other in (uniform, lumped.with_payload(1.0), lumped.with_payload(0.0)):
        np.testing.assert_allclose(other.tool(at).position, lumped.tool(at).position, atol=1e-14)
        np.testing.assert_allclose(other.close(at.q, at).q_full, at.q_full, atol=1e-12)
    zero = lumped.with_payload(0.0).terms(at, V)
    np.testing.assert_array_equal(zero.mass, lumped.terms(at, V).mass)


def test_chains_work_in_threads_of_their_own() -> None:
    description = load_description("fivebar")

    def run(seed: int) -> np.ndarray:
        chain, rng = ClosedChain(description), np.random.default_rng(seed)
        at = chain.home
        for _ in range(10):
            at = chain.close(chain.home.q + 0.1 * rng.normal(size=2), at)
        return np.array(chain.forward_dynamics(at, [1.0, 2.0], [0.5, -0.5]))

    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(run, [1, 2, 3, 1, 2, 3]))
    for seed, found in zip([1, 2, 3, 1, 2, 3], together, strict=True):
        np.testing.assert_array_equal(found, run(seed))


def test_a_closed_chain_is_a_mechanism(kit: Any) -> None:
    chain = kit.robot("omega3", "lumped")
    assert isinstance(chain, Mechanism)
    assert chain.name == "omega3 (lumped)"
    assert [one.kind for one in chain.actuators] == ["rotation"] * 3
    assert [one.unit for one in kit.robot("cpm").actuators] == ["m"] * 3
    assert [one.effort_unit for one in kit.robot("cpm").actuators] == ["N"] * 3
    assert pin.__version__.startswith("4.")
