"""Inverse dynamics of robots with more or fewer motors than degrees of freedom."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from kit.shipped import DETERMINED

from cutjoint.errors import ActuationError, InputError


def allowed_motion(chain: Any, state: Any, rng: np.random.Generator, kit: Any) -> np.ndarray:
    """An acceleration of all joints that the loops allow: that of some efforts, plus a free motion."""
    q = np.array(state.at.q_full)
    free = kit.motions(chain, q)
    start = chain.full_forward_dynamics(state.at, state.v_full, np.zeros(chain.nv)).acceleration
    return start + free @ rng.normal(size=free.shape[1])


def test_redundant_motors_do_the_motion_with_the_least_effort(kit: Any) -> None:
    chain, rng = kit.robot("redundant"), np.random.default_rng(1)
    for state in kit.random_states(chain, 5):
        a = allowed_motion(chain, state, rng, kit)
        found = chain.full_inverse_dynamics(state.at, state.v_full, a)
        assert found.preload.shape == (3, 1)
        np.testing.assert_allclose(np.linalg.norm(found.preload, axis=0), 1.0)
        assert np.abs(found.preload.T @ found.effort).max() < 1e-10, "least: nothing of it is preload"
        forces = []
        for amount in (0.0, 5.0, -2.0):
            effort = found.effort + found.preload[:, 0] * amount
            motion = chain.full_forward_dynamics(state.at, state.v_full, chain.full_effort(effort))
            np.testing.assert_allclose(motion.acceleration, a, atol=1e-9 * max(1.0, np.abs(a).max()))
            forces.append(motion.loop_forces["tip2"].force)
        assert np.abs(forces[1] - forces[0]).max() > 0.1, "preload is felt in the hinges"
        assert not found.effort.flags.writeable
        assert not found.preload.flags.writeable


@pytest.mark.parametrize("name", DETERMINED)
def test_with_as_many_motors_as_needed_it_is_the_reduced_inverse_dynamics(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    for state in kit.random_states(chain, 3):
        a = chain.tangent(state.at) @ state.a + chain.drift(state.at, state.v)
        found = chain.full_inverse_dynamics(state.at, state.v_full, a)
        wanted = chain.inverse_dynamics(state.at, state.v, state.a)
        np.testing.assert_allclose(found.effort, wanted, atol=1e-9 * max(1.0, np.abs(wanted).max()))
        assert found.preload.shape == (chain.n, 0)


def test_too_few_motors_can_do_what_the_robot_does_by_itself_and_no_more(kit: Any) -> None:
    chain, rng = kit.robot("underactuated"), np.random.default_rng(2)
    for state in kit.random_states(chain, 4):
        torque = 7.0 * rng.normal(size=1)
        own = chain.full_forward_dynamics(state.at, state.v_full, chain.full_effort(torque)).acceleration
        np.testing.assert_allclose(chain.full_inverse_dynamics(state.at, state.v_full, own).effort, torque, atol=1e-9)
        with pytest.raises(ActuationError) as caught:
            chain.full_inverse_dynamics(state.at, state.v_full, allowed_motion(chain, state, rng, kit))
        error = caught.value
        assert (error.mobility, error.actuators) == (2, 1)
        assert error.free
        assert set(error.free) <= {"cart", "left", "load", "right"}
        assert all(name in str(error) for name in error.free)


@pytest.mark.parametrize("name", ["redundant", "cpm", "fivebar"])
def test_a_motion_of_the_tool_becomes_one_of_all_joints(name: str, kit: Any) -> None:
    chain, rng = kit.robot(name), np.random.default_rng(3)
    mask = {"redundant": (1.0, 1.0, 0.0), "fivebar": (1.0, 0.0, 1.0)}.get(name, (1.0, 1.0, 1.0))
    for state in kit.random_states(chain, 3):
        velocity, acceleration = (mask * rng.normal(size=3) for _ in range(2))
        v, a = chain.full_motion(state.at, velocity, acceleration)
        q, h = np.array(state.at.q_full), 1e-4
        assert np.abs(chain.constraint_jacobian(q) @ v).max() < 1e-10

        def tool(t: float, q: np.ndarray = q, v: np.ndarray = v, a: np.ndarray = a) -> np.ndarray:
            frame = chain.description.tool
            there = chain.integrate(q, t * v + 0.5 * t * t * a)
            return (chain.link_placements(there)[frame.link] @ frame.placement)[:3, 3]

        np.testing.assert_allclose((tool(h) - tool(-h)) / (2 * h), velocity, atol=2e-5)
        np.testing.assert_allclose((tool(h) - 2 * tool(0.0) + tool(-h)) / h**2, acceleration, atol=1e-4)


def test_a_motion_that_the_tool_cannot_have_is_refused(kit: Any) -> None:
    chain = kit.robot("fivebar")
    with pytest.raises(InputError, match="velocity"):
        chain.full_motion(chain.home, [0.0, 1.0, 0.0], [0.0, 0.0, 0.0])
    with pytest.raises(InputError, match="acceleration"):
        chain.full_motion(chain.home, [0.0, 0.0, 0.0], [0.0, 1.0, 0.0])
