"""Joint states of a run: all joints, passive ones too; those with several coordinates are told by their place."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from kit.two_bodies import body

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.description.model import CutJoint, CutType, Frame, Joint, JointType, Link, RobotDescription
from cutjoint.description.transforms import placement
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


def carriage() -> ClosedChain:
    """A slide that carries a body which flies from the base, and one that flies from its carriage; flying ones first,
    so that places in configurations and in velocities differ."""
    turned = placement((0.1, -0.2, 0.3), (0.3, -0.4, 0.5))
    return ClosedChain(
        RobotDescription(
            name="carriage",
            links=(Link("base"), *(Link(name, body()) for name in ("carriage", "flyer", "rider"))),
            joints=(
                Joint("f1", JointType.FLOATING, "base", "flyer"),
                Joint("slide", JointType.PRISMATIC, "base", "carriage"),
                Joint("f2", JointType.FLOATING, "carriage", "rider", turned),
            ),
            cuts=(
                CutJoint("c1", CutType.FIXED, Frame("carriage", turned), Frame("flyer")),
                CutJoint("c2", CutType.FIXED, Frame("carriage"), Frame("rider")),
            ),
            actuators=("slide",),
        )
    )


def test_places_are_those_in_the_parent_and_velocities_those_of_the_joint() -> None:
    chain, time = carriage(), np.array([0.0, 0.1])
    at = [chain.close([0.2]), chain.close([0.5])]
    column, twice = np.zeros(2), np.zeros((2, 3))
    result = Result(
        time,
        q=np.array([[0.2], [0.5]]),
        v=np.array([[3.0], [-4.0]]),
        tool=twice,
        tool_velocity=twice,
        effort=np.array([[7.0], [8.0]]),
        gap=np.zeros((2, 2)),
        kinetic=column,
        potential=column,
        work=column,
        q_full=np.array([one.q_full for one in at]),
    )
    states = joint_states(result, chain)
    assert states.names == ("slide",)
    assert states.position.tolist() == [[0.2], [0.5]]
    np.testing.assert_allclose(states.velocity, [[3.0], [-4.0]])
    assert states.effort.tolist() == [[7.0], [8.0]]
    flyer, rider = states.carried
    assert (flyer.parent, rider.parent) == ("base", "carriage")
    np.testing.assert_allclose(flyer.position[1] - flyer.position[0], [0.3, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(rider.position, twice, atol=1e-9)  # frame and carriage are one
    np.testing.assert_allclose(np.abs(rider.orientation[:, 3]), 1.0, atol=1e-9)


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
