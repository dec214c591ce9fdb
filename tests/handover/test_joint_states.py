"""Joint states of a run: all joints, passive ones too; those with several coordinates are told by their place."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError
from cutjoint.handover import JointStates, joint_states
from cutjoint.mechanism.rotations import matrix_of
from cutjoint.simulation import ConstrainedPlant, Result, run


@cache
def made(name: str) -> tuple[ClosedChain, Result, JointStates]:
    """A robot, a fall of it, and the joint states of that."""
    chain = cutjoint.load(name)
    result = run(ConstrainedPlant(chain), duration=0.02, every=0.002)
    return chain, result, joint_states(result, chain)


def test_every_joint_with_one_coordinate_is_there_in_the_order_of_the_tree() -> None:
    chain, result, states = made("fivebar")
    assert states.names == tuple(chain.model.names[1:])
    np.testing.assert_array_equal(states.position, result.q_full)
    assert states.position.shape == states.velocity.shape == states.effort.shape == (len(result), 4)
    assert states.carried == ()


@pytest.mark.parametrize("name", ["fivebar", pytest.param("omega3", marks=pytest.mark.slow)])
def test_velocities_are_the_rates_of_the_positions(name: str) -> None:
    chain, result, states = made(name)
    middle = slice(1, -1)
    rates = (states.position[2:] - states.position[:-2]) / (result.time[2:] - result.time[:-2])[:, None]
    np.testing.assert_allclose(states.velocity[middle], rates, rtol=0, atol=1e-2 * np.abs(states.velocity).max())
    motors = {one.name for one in chain.actuators}
    passive = [one not in motors for one in states.names]
    assert np.abs(states.velocity[:, passive]).max() > 0.1


def test_motors_have_their_effort_and_passive_joints_none() -> None:
    chain, result, _ = made("fivebar")
    pushed = replace(result, effort=np.outer(np.arange(len(result)), [1.0, -2.0]))
    states = joint_states(pushed, chain)
    motors = [states.names.index(one.name) for one in chain.actuators]
    np.testing.assert_array_equal(states.effort[:, motors], pushed.effort)
    assert not np.delete(states.effort, motors, axis=1).any()


@pytest.mark.slow
def test_what_flies_is_told_by_its_place_in_its_parent() -> None:
    chain, result, states = made("stewart")
    (platform,) = states.carried
    assert (platform.joint, platform.parent, platform.child) == ("platform", "base", "platform_link")
    assert "platform" not in states.names
    assert len(states.names) == 18
    for i, q in enumerate(result.q_full):
        links = chain.link_placements(q)
        found = np.eye(4)
        found[:3, :3], found[:3, 3] = matrix_of(platform.orientation[i]), platform.position[i]
        np.testing.assert_allclose(links[platform.parent] @ found, links[platform.child], atol=1e-12)


@pytest.mark.slow
def test_velocities_that_nobody_knows_are_left_out() -> None:
    chain, result, states = made("underactuated")
    assert states.velocity.shape == (len(result), 0)
    assert states.position.shape == (len(result), chain.nq)


@pytest.mark.slow
def test_a_compiled_robot_is_as_good() -> None:
    chain, result, states = made("fivebar")
    again = joint_states(result, chain.compile())
    assert again.names == states.names
    np.testing.assert_array_equal(again.velocity, states.velocity)


def test_a_run_of_another_robot_is_refused() -> None:
    chain, result, _ = made("fivebar")
    with pytest.raises(InputError, match="found"):
        joint_states(result, cutjoint.published("cpm"))
    with pytest.raises(InputError, match="found"):
        joint_states(chain.home, chain)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="not of the chain fourbar"):
        joint_states(result, cutjoint.load("fourbar"))
