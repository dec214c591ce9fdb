"""Closing and reaching: exact, inverse to each other, continuous, never on another branch, honest where they fail."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from kit.shipped import DETERMINED, SHIPPED

from cutjoint.arrays import readonly
from cutjoint.chain import ClosedChain
from cutjoint.chain.closing.continuation import same_branch
from cutjoint.chain.closing.newton import Linearised
from cutjoint.description.model import CutJoint, CutType, Frame, Inertial, Joint, JointType, Link, RobotDescription
from cutjoint.description.transforms import placement
from cutjoint.errors import (
    ActuationError,
    ClosureError,
    CutjointError,
    InputError,
    LimitError,
    SingularError,
    UnknownNameError,
    UnreachableError,
)
from cutjoint.mechanism import Pose, Posture

SPATIAL = ("cpm", "omega3")


def angle(chain: ClosedChain, at: Posture, joint: str) -> float:
    return float(at.q_full[chain.model.idx_qs[chain.model.getJointId(joint)]])


def sines(*joints: str) -> Callable[[ClosedChain, Posture], tuple[int, ...]]:
    """Which way the named elbows are bent: the working mode."""
    return lambda chain, at: tuple(int(np.sign(np.sin(angle(chain, at, joint)))) for joint in joints)


WORKING = {
    "cpm": sines("limb1_elbow", "limb2_elbow", "limb3_elbow"),
    "cpm_rotary": sines("limb1_elbow", "limb2_elbow", "limb3_elbow"),
    "omega3": sines("bar1", "bar2", "bar3"),
    "fivebar": sines("left_elbow", "right_elbow"),
}


def tool_of(chain: ClosedChain, at: Posture) -> np.ndarray:
    frame = chain.description.tool
    return (chain.link_placements(at)[frame.link] @ frame.placement)[:3, 3]


def in_space(name: str, point: np.ndarray) -> np.ndarray:
    """A tool displacement that the robot can have: planar robots stay in the x-z plane."""
    return point * (1.0, 0.0, 1.0) if name == "fivebar" else point


# ---- exact -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", DETERMINED)
def test_closed_postures_are_closed_and_where_they_were_asked_for(name: str, kit: Any) -> None:
    chain, rng = kit.robot(name), np.random.default_rng(1)
    done = 0
    for _ in range(40):
        target = chain.home.q + 10.0 ** rng.uniform(-4, 0) * chain.length * rng.normal(size=chain.n)
        try:
            at = chain.close(target, limits="ignore")
        except CutjointError:
            continue
        done += 1
        assert max(at.gap) < 1e-12
        assert max(chain.gap(at.q_full)) < 1e-12
        np.testing.assert_allclose(at.q, target, atol=1e-13, rtol=1e-15)
        np.testing.assert_array_equal(chain.actuated(at.q_full), at.q)
    assert done > 15


@pytest.mark.parametrize("name", [name for name in DETERMINED if name != "fourbar"])
def test_reached_postures_hold_the_tool_where_it_was_asked_for(name: str, kit: Any) -> None:
    """A point where that says all, else a pose."""
    chain, rng = kit.robot(name), np.random.default_rng(2)
    start, done = Pose(tool_of(chain, chain.home), np.eye(3)), 0
    for _ in range(40):
        size = 10.0 ** rng.uniform(-4, 0)
        by, turn = in_space(name, size * chain.length * rng.normal(size=3)), size * rng.normal(size=3)
        target = start.moved(by, 0.0 * turn if chain.task.is_of_point else turn)
        try:
            at = chain.reach(target.position if chain.task.is_of_point else target, limits="ignore")
        except CutjointError:
            continue
        done += 1
        assert max(at.gap) < 1e-12
        np.testing.assert_allclose(tool_of(chain, at), target.position, atol=1e-12)
        if not chain.task.is_of_point:
            np.testing.assert_allclose(chain.tool(at).rotation, target.rotation, atol=1e-12)
    assert done > 15


def test_a_point_leaves_the_rest_of_a_pose_free_where_that_is_said(kit: Any) -> None:
    chain, rng = kit.robot("stewart"), np.random.default_rng(12)
    for _ in range(10):
        target = tool_of(chain, chain.home) + 0.05 * chain.length * rng.normal(size=3)
        with pytest.raises(InputError, match="a point does not fix stewart, whose task is x y z rx ry rz"):
            chain.reach(target)
        at = chain.reach(target, free=True)
        assert max(at.gap) < 1e-12
        np.testing.assert_allclose(tool_of(chain, at), target, atol=1e-12)


# ---- joint limits ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", DETERMINED)
def test_joint_limits_are_respected_unless_they_are_to_be_ignored(name: str, kit: Any) -> None:
    """A posture beyond them is the one that is found where they are ignored, and refused by name otherwise."""
    chain, rng = kit.robot(name), np.random.default_rng(13)
    units = np.array([chain.length if one.kind == "translation" else 1.0 for one in chain.actuators])
    for _ in range(15):
        q = chain.home.q + 10.0 ** rng.uniform(-2, 0.5) * units * rng.normal(size=chain.n)
        try:
            at = chain.close(q, limits="ignore")
        except CutjointError:
            continue
        beyond = chain.limit_violations(at)
        if not beyond:
            np.testing.assert_array_equal(chain.close(q).q_full, at.q_full)
            continue
        with pytest.raises(LimitError) as caught:
            chain.close(q)
        error = caught.value
        assert (error.value, *error.bounds) == pytest.approx(beyond[error.joint], abs=1e-9)
        assert 0.0 <= error.progress < 1.0
        try:  # the way of the tool may be barred, or wind up another joint
            reached = chain.reach(chain.tool(at).pose, free=True)
        except CutjointError:
            continue
        assert not chain.limit_violations(reached)


def test_a_four_bar_reaches_the_points_of_its_coupler_curve_alone(kit: Any) -> None:
    chain = kit.robot("fourbar")
    for crank in np.linspace(2.0, 4.0, 9):
        wanted = chain.close([crank])
        found = chain.reach(tool_of(chain, wanted))
        np.testing.assert_allclose(found.q_full, wanted.q_full, atol=1e-8)
    with pytest.raises(UnreachableError):
        chain.reach(tool_of(chain, chain.home) + np.array([0.0, 0.0, 0.02]))


@pytest.mark.parametrize("name", [*SPATIAL, "fivebar"])
def test_reach_and_close_undo_each_other(name: str, kit: Any) -> None:
    chain, rng = kit.robot(name), np.random.default_rng(3)
    for _ in range(25):
        at = chain.reach(tool_of(chain, chain.home) + in_space(name, 0.15 * chain.length * rng.uniform(-1, 1, 3)))
        np.testing.assert_allclose(chain.close(at.q).q_full, at.q_full, atol=1e-10)
        np.testing.assert_allclose(chain.reach(tool_of(chain, at)).q_full, at.q_full, atol=1e-10)
        np.testing.assert_allclose(chain.close(at.q, at).q_full, at.q_full, atol=1e-13)


@pytest.mark.parametrize("name", DETERMINED)
def test_closing_is_continuous(name: str, kit: Any) -> None:
    """A small step of the actuators moves the joints as far as the tangent map says, from any regular posture."""
    chain, rng = kit.robot(name), np.random.default_rng(4)
    for state in kit.random_states(chain, 5):
        if chain.mobility(state.at).type2 < 0.2:  # a stretched limb is near, and no room for the step
            continue
        for size in (1e-1, 1e-3, 1e-6, 1e-9, 0.0):
            step = 0.1 * size * rng.normal(size=chain.n)
            at = chain.close(state.at.q + step, state.at)
            moved = np.abs(at.q_full - state.at.q_full).max()
            allowed = np.abs(chain.tangent(state.at)).sum(axis=1).max() * np.abs(step).max()
            assert moved <= 2.0 * allowed + 1e-12


# ---- branches --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", list(WORKING))
def test_a_long_walk_of_the_tool_keeps_the_working_mode(name: str, kit: Any) -> None:
    """Each step starts from the last; steps are up to two links long and often ask for what cannot be reached."""
    chain, rng = kit.robot(name), np.random.default_rng(5)
    wanted, near = WORKING[name](chain, chain.home), chain.home
    centre, done = tool_of(chain, chain.home), 0
    for _ in range(80):
        target = centre + in_space(name, chain.length * 10.0 ** rng.uniform(-2, 0.3) * rng.normal(size=3))
        try:
            near = chain.reach(target, near, limits="ignore")
        except (UnreachableError, SingularError):
            continue
        done += 1
        assert WORKING[name](chain, near) == wanted
    assert done > 15


@pytest.mark.parametrize("name", DETERMINED)
def test_a_long_walk_of_the_actuators_comes_home(name: str, kit: Any) -> None:
    """Closing never jumps: wherever a walk of short steps led, short steps back lead home again."""
    chain, rng = kit.robot(name), np.random.default_rng(6)
    scale = np.array([chain.length if one.kind == "translation" else 1.0 for one in chain.actuators])
    path = [chain.home]
    for _ in range(30):
        try:
            path.append(chain.close(path[-1].q + 0.3 * scale * rng.normal(size=chain.n), path[-1], limits="ignore"))
        except (ClosureError, SingularError):
            continue
        assert max(path[-1].gap) < 1e-12
    assert len(path) > 8
    back = path[-1]
    for there in reversed(path[:-1]):
        back = chain.close(there.q, back, limits="ignore")
        np.testing.assert_allclose(back.q_full, there.q_full, atol=1e-9)


@pytest.mark.parametrize("name", [*SPATIAL, "fivebar"])
def test_a_sweep_in_fine_steps_and_one_leap_agree(name: str, kit: Any) -> None:
    chain, rng = kit.robot(name), np.random.default_rng(7)
    start = tool_of(chain, chain.home)
    for _ in range(4):
        step = in_space(name, rng.normal(size=3))
        step *= 0.25 * chain.length / np.linalg.norm(step)
        at = chain.home
        for fraction in np.linspace(0.0, 1.0, 41)[1:]:
            at = chain.reach(start + fraction * step, at)
        np.testing.assert_allclose(chain.reach(start + step).q_full, at.q_full, atol=1e-9)


def test_a_crank_turns_round_and_round(kit: Any) -> None:
    chain = kit.robot("fourbar")
    for turns in (1, -1, 3):
        at = chain.close(chain.home.q + 2.0 * np.pi * turns, limits="ignore")
        difference = (at.q_full - chain.home.q_full) / (2.0 * np.pi)
        np.testing.assert_allclose(difference, np.round(difference), atol=1e-10)
        assert difference[0] == pytest.approx(turns)
    with pytest.raises(LimitError, match=r"'crank' would be at 8\.28319 rad, its limits are -6\.28319"):
        chain.close(chain.home.q + 2.0 * np.pi)


def test_closing_starts_from_any_working_mode(kit: Any) -> None:
    for name in (*SPATIAL, "fivebar"):
        chain = kit.robot(name)
        for mode in chain.working_modes():
            at = chain.reach(tool_of(chain, mode) + in_space(name, np.full(3, 0.02 * chain.length)), mode)
            assert WORKING[name](chain, at) == WORKING[name](chain, mode)


# ---- singular --------------------------------------------------------------------------------------------------------


def parallelogram(kit: Any) -> ClosedChain:
    return ClosedChain(kit.planar_fourbar((0.3, 0.5, 0.3), 0.5, (1.0, -1.0, 1.0)))


@pytest.mark.parametrize("target", [0.0, -1e-3, -0.5, -2.0, 3.2, 4.5, 7.0])
@pytest.mark.parametrize("start", [1.0, 0.05])
def test_a_parallelogram_does_not_cross_its_change_points(target: float, start: float, kit: Any) -> None:
    """Flat, it can go on as a parallelogram or crossed; which one, the crank does not determine."""
    chain = parallelogram(kit)
    with pytest.raises(SingularError, match="branches meet") as caught:
        chain.close([target], chain.close([start]))
    assert caught.value.kind == "type-2"
    assert caught.value.measure < 1e-4
    assert caught.value.limit > 0.0


@pytest.mark.parametrize("crank", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, np.pi - 1e-3])
def test_a_parallelogram_stays_one_up_to_its_change_points(crank: float, kit: Any) -> None:
    chain = parallelogram(kit)
    at = chain.close([crank])
    np.testing.assert_allclose(at.q_full, [crank, -crank, crank], atol=1e-9)
    assert chain.tangent(at)[:, 0] == pytest.approx([1.0, -1.0, 1.0], abs=1e-6)
    assert 0.0 < chain.mobility(at).type2 < 10.0 * np.sin(crank)


def test_a_singular_posture_that_is_given_is_told_by_number(kit: Any) -> None:
    chain = parallelogram(kit)
    flat = chain.posture([0.0, 0.0, 0.0])
    report = chain.mobility(flat)
    assert (report.mobility, report.rank, report.determined) == (2, 1, False)
    assert report.type2 < 1e-12
    assert set(report.free) == {"b", "c"}
    for call in (
        lambda: chain.terms(flat),
        lambda: chain.tangent(flat),
        lambda: chain.tool(flat),
        lambda: chain.inverse_dynamics(flat, [0.0], [0.0]),
        lambda: chain.forward_dynamics(flat, [0.0], [0.0]),
    ):
        with pytest.raises(SingularError, match="type-2") as caught:
            call()
        assert caught.value.kind == "type-2"
        assert caught.value.measure < caught.value.limit


@pytest.mark.parametrize("distance", [1e-2, 1e-4, 1e-6, 1e-7])
def test_near_the_end_of_a_branch(distance: float, kit: Any) -> None:
    """A crank that cannot turn round: at its dead point coupler and rocker are in line, the root of the way off."""
    chain = ClosedChain(kit.planar_fourbar((0.5, 0.3, 0.3), 0.5, (0.9, -1.8, 1.0)))
    stretched = np.arccos((0.5**2 + 0.5**2 - 0.6**2) / (2 * 0.5 * 0.5))
    at = chain.close([stretched - distance])
    assert max(at.gap) < 1e-12
    sine = np.sin(at.q_full[0] + at.q_full[1] - at.q_full[2])  # between coupler and rocker
    assert sine**2 == pytest.approx(2 * 0.5 * 0.5 * np.sin(stretched) / 0.3**2 * distance, rel=20 * distance + 1e-6)
    speed = chain.full_velocity(at, [1.0])
    assert np.abs(chain.constraint_jacobian(at) @ speed).max() < 1e-12 * np.abs(speed).max() + 1e-12
    acceleration = chain.forward_dynamics(at, [0.0], chain.inverse_dynamics(at, [0.0], [1.0]))
    assert acceleration == pytest.approx([1.0], rel=1e-13 / distance + 1e-9)
    with pytest.raises(ClosureError) as caught:
        chain.close([stretched + distance], at)
    assert caught.value.cut == "tip"
    with pytest.raises(ClosureError):
        chain.close([stretched + 0.1])


def test_reach_does_not_cross_a_stretched_limb(kit: Any) -> None:
    """Beyond the type-1 singularity nothing can be reached on any branch: the error tells how far it got."""
    chain = kit.robot("fivebar")
    start = tool_of(chain, chain.home)
    with pytest.raises(UnreachableError) as caught:
        chain.reach(start + np.array([0.0, 0.0, 2.0]))
    error = caught.value
    assert 0.0 < error.progress < 1.0
    np.testing.assert_allclose(error.target, start + np.array([0.0, 0.0, 2.0]))
    np.testing.assert_allclose(error.reached, start + error.progress * np.array([0.0, 0.0, 2.0]), atol=1e-6)
    edge = chain.reach(error.reached - [0.0, 0.0, 1e-4])
    assert chain.mobility(edge).type1 < 0.1 * chain.mobility().type1


# ---- failing ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SPATIAL)
def test_what_cannot_be_reached_says_how_far_it_got(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    start = tool_of(chain, chain.home)
    target = start + np.array([0.0, 0.0, 30.0 * chain.length])
    with pytest.raises(UnreachableError) as caught:
        chain.reach(target)
    error = caught.value
    np.testing.assert_array_equal(error.target, target)
    assert 0.0 <= error.progress < 1.0
    np.testing.assert_allclose(error.reached, start + error.progress * (target - start), atol=1e-9)
    for number in (f"{error.progress:.1%}", str(round(float(target[2]), 6))):
        assert number in str(error)


@pytest.mark.parametrize("name", ["cpm", "fivebar"])
def test_what_cannot_be_closed_names_the_cut_that_stays_open(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    step = np.array([5.0, -5.0, -5.0]) if name == "cpm" else np.array([0.9, -0.9])
    with pytest.raises(ClosureError) as caught:
        chain.close(chain.home.q + step)
    error = caught.value
    assert error.cut in {cut.name for cut in chain.description.cuts}
    assert max(error.gap) > 1e-3
    assert 0.0 <= error.progress < 1.0
    assert error.cut in str(error)
    assert f"{error.progress:.1%}" in str(error)


def test_a_way_that_is_far_too_long_is_given_up(kit: Any) -> None:
    with pytest.raises(ClosureError, match="steps were not enough") as caught:
        kit.robot("fourbar").close([1000.0])
    assert 0.0 < caught.value.progress < 1.0
    with pytest.raises(ClosureError):
        kit.robot("fourbar").close([1e12])


def test_postures_of_other_robots_are_refused(kit: Any) -> None:
    chain, same_size = kit.robot("fivebar"), kit.robot("underactuated")
    assert chain.nq == same_size.nq
    for other in (same_size.home, kit.robot("cpm").home):
        for call in (
            lambda at: chain.close(chain.home.q, at),
            lambda at: chain.reach([0.0, 0.0, 0.3], at),
            lambda at: chain.terms(at),
            lambda at: chain.tool(at),
            lambda at: chain.mobility(at),
            lambda at: chain.potential_energy(at),
            lambda at: chain.forward_dynamics(at, [0, 0], [0, 0]),
            lambda at: chain.working_modes(at),
        ):
            with pytest.raises(InputError, match="this posture"):
                call(other)
    description = chain.description
    links = replace(description.cuts[0], b=Frame("right_distal", placement((0.25001, 0.0, 0.0))))
    with pytest.raises(InputError, match="'tip'"):
        chain.terms(ClosedChain(replace(description, cuts=(links,))).home)
    with pytest.raises(InputError, match="must be a Posture, found an array"):
        chain.terms(chain.home.q_full)


def test_an_open_configuration_is_no_posture(kit: Any) -> None:
    chain = kit.robot("omega3")
    q = np.array(chain.home.q_full)
    np.testing.assert_array_equal(chain.posture(q).q_full, q)
    q[0] += 1e-6
    with pytest.raises(ClosureError) as caught:
        chain.posture(q)
    ball = chain.cut_placements(chain.home)[0][1][:3, 3]  # it turns about the y axis through (0, 0, 75 mm)
    reach = np.hypot(ball[0], ball[2] - 0.075)
    assert caught.value.gap[0] == pytest.approx(1e-6 * reach, rel=1e-3)
    assert caught.value.cut.startswith("ball1")


@pytest.mark.parametrize("name", SHIPPED)
def test_assembling_from_anywhere_gives_closed_postures_or_an_error(name: str, kit: Any) -> None:
    chain, rng = kit.robot(name), np.random.default_rng(8)
    done = 0
    for _ in range(20):
        start = chain.integrate(chain.home.q_full, 1.5 * rng.normal(size=chain.nv))
        try:
            found = chain.assemble(start, keep_actuators=False)
        except ClosureError:
            continue
        done += 1
        assert max(found.gap) < 1e-12
    assert done >= 10


def test_assembling_keeps_the_actuators_or_fails(kit: Any) -> None:
    chain, rng = kit.robot("cpm"), np.random.default_rng(9)
    for _ in range(10):
        start = chain.home.q_full + 0.3 * rng.normal(size=chain.nq)
        try:
            found = chain.assemble(start)
        except ClosureError:
            continue
        np.testing.assert_allclose(found.q, chain.actuated(start), atol=1e-12)


def test_home_that_cannot_be_closed_is_an_error(kit: Any) -> None:
    description = kit.planar_fourbar((0.2, 0.2, 0.2), 5.0, (1.0, -1.0, 1.0))
    with pytest.raises(ClosureError, match="tip"):
        ClosedChain(description)
    with pytest.raises(UnknownNameError, match="did you mean 'default'"):
        ClosedChain(description, "defualt")


def test_robots_without_tool_or_actuators_say_so(kit: Any) -> None:
    chain = kit.robot("fivebar")
    bare = ClosedChain(replace(chain.description, tool=None))
    for call in (lambda: bare.reach([0, 0, 0]), lambda: bare.tool(bare.home), lambda: bare.working_modes()):
        with pytest.raises(InputError, match=r"\[tool\]"):
            call()
    homes = tuple(replace(home, actuated={}, passive={}) for home in chain.description.homes)
    idle = ClosedChain(replace(chain.description, actuators=(), homes=homes, cuts=()))
    assert idle.close([]).q.shape == (0,)
    with pytest.raises(ActuationError):
        idle.terms(idle.home)


def test_a_tool_on_the_ground_can_reach_only_where_it_is(kit: Any) -> None:
    description = replace(kit.robot("fivebar").description, tool=Frame("base"))
    chain = ClosedChain(description)
    np.testing.assert_allclose(chain.reach([0.0, 0.0, 0.0]).q_full, chain.home.q_full, atol=1e-12)
    with pytest.raises(UnreachableError):
        chain.reach([0.1, 0.0, 0.0])


def test_a_robot_that_is_a_tree_needs_no_closing(kit: Any) -> None:
    description = kit.robot("cpm").description
    limb = replace(
        description,
        cuts=(),
        actuators=tuple(joint.name for joint in description.joints if joint.type != "fixed"),
        homes=(),
        gravity=readonly([0.0, 0.0, -9.81]),
    )
    chain = ClosedChain(limb)
    assert chain.mobility().determined
    assert chain.mobility().type2 == float("inf")
    q = np.linspace(-1.0, 1.0, chain.n)
    with pytest.raises(LimitError, match="'limb1_slide' would be at -1 m, its limits are 0 to 0"):
        chain.close(q)
    at = chain.close(q, limits="ignore")
    np.testing.assert_array_equal(at.q_full, q)
    effort = chain.inverse_dynamics(at, q, -q)
    np.testing.assert_allclose(chain.forward_dynamics(at, q, effort), -q, atol=1e-10)


def test_a_step_that_left_its_branch_is_told_by_each_sign_alone() -> None:
    """Onto the other branch the motion turns and the determinant may keep its sign; straight on, conversely."""
    here, along = Linearised.of(np.eye(2)), np.array([1.0, 0.2])
    assert same_branch(here, along, Linearised.of(np.diag([0.9, 1.2])), np.array([1.1, 0.1]))
    assert not same_branch(here, along, Linearised.of(np.eye(2)), np.array([1.0, -0.6]))
    assert not same_branch(here, along, Linearised.of(np.diag([1.0, -1.0])), along)
    assert not same_branch(here, along, Linearised.of(np.diag([1.0, 1e-9])), along)
    loose = Linearised.of(np.array([[1.0, 0.0]]), free=1)
    assert same_branch(loose, along, loose, along)
    assert not same_branch(loose, along, Linearised.of(np.array([[-1.0, 0.0]]), free=1), along)
    assert not same_branch(loose, along, loose, -along)


def test_a_straight_limb_learns_which_way_to_bend() -> None:
    """Stretched straight towards the cut, least squares stands on a saddle; a start beside it closes the loop."""
    length = np.eye(4)
    length[0, 3] = 1.0
    y = np.array([0.0, 1.0, 0.0])
    links = [Link("base"), *(Link(f"rod{i}", Inertial(1.0, np.array([0.5, 0, 0]), 0.1 * np.eye(3))) for i in range(3))]
    joints = (
        Joint("a", JointType.REVOLUTE, "base", "rod0", axis=y),
        Joint("b", JointType.REVOLUTE, "rod0", "rod1", length, axis=y),
        Joint("c", JointType.REVOLUTE, "rod1", "rod2", length, axis=y),
    )
    target = np.eye(4)
    target[0, 3] = 1.5
    cut = CutJoint("end", CutType.SPHERICAL, Frame("base", target), Frame("rod2", length))
    chain = ClosedChain(RobotDescription("straight", tuple(links), joints, (cut,), actuators=("a",)))
    assert max(chain.home.gap) < 1e-12
