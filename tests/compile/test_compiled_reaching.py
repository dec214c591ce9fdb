"""Compiled chains lead their tasks: short ways by compiled steps, on one branch; the rest is the chain's own."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.blueprint import random_rotation
from kit.led import Standing, stand, with_limits
from kit.led_robots import LED, drawn, somewhere
from kit.quickly import few
from kit.sized import Size

from cutjoint import tolerances
from cutjoint.chain import ClosedChain
from cutjoint.compile import CompiledChain, compiled, reaching
from cutjoint.compile.functions.sample import goal_of
from cutjoint.errors import CutjointError, InputError, LimitError, UnreachableError
from cutjoint.mechanism import Pose, Posture
from cutjoint.mechanism.rotations import turned

ACCURACY = 1e-12
"""Of the robot's size, and radians."""


def quick(robot: CompiledChain, near: Posture, target: Any, free: bool = False) -> Posture | None:
    """What compiled steps alone reach."""
    assert robot._reaching is not None
    return robot._reaching.to(near.q_full, target, free)


def check_short_ways(robot: Standing, machine: CompiledChain, rng: np.random.Generator, ways: int) -> None:
    chain, scale = robot.chain, machine.source.position_scale
    units, refused = robot.length if robot.led.slides else 1.0, 0
    for _ in range(ways):
        x = robot.led.freedoms(rng, 0.9)
        there = x + 0.02 * robot.led.spread * rng.uniform(-1.0, 1.0, len(x))
        near, pose = chain.reach(robot.pose(x)), robot.pose(there)
        found, wanted = quick(machine, near, pose), chain.reach(pose, near)
        if found is None:
            refused, found = refused + 1, machine.reach(pose, near)
        assert np.abs(found.q - wanted.q).max() < ACCURACY * units
        assert robot.missed(found.q, there) < ACCURACY
        assert robot.off(chain.tool(found).pose, there) < ACCURACY
        assert max(found.gap[0] / robot.length, found.gap[1], *chain.gap(found.q_full)) < ACCURACY * max(
            1.0, robot.length
        )
        if not machine.source.idle:
            assert np.abs((found.q_full - wanted.q_full) / scale).max() < ACCURACY
        named = robot.named(there, chain.task.names, chain.task.axes)
        for target in [pose, named, *([pose[:3, 3]] if chain.task.is_of_point else [])]:
            np.testing.assert_allclose(machine.reach(target, near).q, found.q, rtol=0, atol=ACCURACY * units)
    # a rod between balls may have spun to where its rates are a bad choice of coordinates
    assert refused <= (ways // 20 if machine.source.idle else 0)


@pytest.mark.parametrize("name", few(LED, "stewart", "planar_3rrr", "pan_tilt"))
def test_short_ways_are_those_of_the_chain(name: str, tmp_path: Path) -> None:
    rng = np.random.default_rng([3, *name.encode()])
    robot = somewhere(name, 3, tmp_path, rng)
    check_short_ways(robot, compiled(robot.chain, cached=False), rng, 12)


@pytest.mark.slow
@pytest.mark.parametrize("name", LED)
def test_short_ways_of_many_shapes(name: str, tmp_path: Path) -> None:
    rng = np.random.default_rng([4, *name.encode()])
    for seed in range(4, 10):
        robot = somewhere(name, seed, tmp_path, rng)
        check_short_ways(robot, compiled(robot.chain, cached=False), rng, 30)


@pytest.mark.parametrize("name", ["planar_3rrr", "tripod", "serial_wrist", "spherical_3rrr"])
def test_long_ways_are_left_to_the_chain(name: str, tmp_path: Path) -> None:
    """To targets near and far, reachable or not: the chain's posture, or none, but never another branch."""
    rng = np.random.default_rng([5, *name.encode()])
    robot = somewhere(name, 2, tmp_path, rng)
    chain, machine = robot.chain, compiled(robot.chain, cached=False)
    home, units = chain.home, robot.length if robot.led.slides else 1.0
    near = far = 0
    for part in np.linspace(0.02, 3.0, 60):
        x = part * robot.led.spread * rng.uniform(-1.0, 1.0, len(robot.led.spread))
        found = quick(machine, home, robot.pose(x))
        try:
            wanted = chain.reach(robot.pose(x))
        except CutjointError:
            assert found is None
            continue
        if found is not None:
            near += 1
            assert np.abs(found.q - wanted.q).max() < 1e-10 * units
        change = np.abs((wanted.q_full - home.q_full) / machine.source.position_scale).max()
        if change > 3.0 * tolerances.STRIDE.value:
            far += 1
            assert found is None
    assert near > 5
    assert far > 5


def same_error(machine: CompiledChain, target: Any, kind: type[CutjointError], **given: Any) -> CutjointError:
    """Both refuse a target in the same words."""
    with pytest.raises(kind) as own:
        machine.reach(target, **given)
    with pytest.raises(kind) as wanted:
        machine.chain.reach(target, **given)
    assert type(own.value) is type(wanted.value)
    assert str(own.value) == str(wanted.value)
    return own.value


def test_what_is_no_target_is_refused_as_by_the_chain(kit: Any) -> None:
    stewart, flat, delta = kit.machine("stewart"), kit.machine("fivebar"), kit.machine("omega3")
    pose = stewart.tool(stewart.home).pose
    same_error(stewart, pose.position, InputError)
    same_error(stewart, {"x": 0.0}, InputError)
    same_error(stewart, {"x": np.nan, "y": 0.0, "z": 0.0, "rx": 0.0, "ry": 0.0, "rz": 0.0}, InputError)
    same_error(stewart, np.zeros(5), InputError)
    same_error(stewart, pose.moved((9.0, 0.0, 0.0)), UnreachableError)
    tip = flat.tool(flat.home).position
    same_error(flat, tip + np.array([0.0, 1e-6, 0.0]), UnreachableError)
    same_error(delta, delta.tool(delta.home).pose.moved(turn=(1e-3, 0.0, 0.0)), UnreachableError)
    same_error(kit.machine("underactuated"), {"x": 0.1, "w": 0.0}, InputError)


def test_what_is_free_may_be_anything(kit: Any) -> None:
    delta, stewart = kit.machine("omega3"), kit.machine("stewart")
    pose = delta.tool(delta.home).pose.moved((1e-3, 0.0, 0.0), (0.1, 0.0, 0.0))
    np.testing.assert_allclose(delta.reach(pose, free=True).q, delta.chain.reach(pose, free=True).q, atol=1e-13)
    point = stewart.tool(stewart.home).position + np.array([1e-3, 0.0, -1e-3])
    found, wanted = stewart.reach(point, free=True), stewart.chain.reach(point, free=True)
    np.testing.assert_array_equal(found.q_full, wanted.q_full)
    assert quick(stewart, stewart.home, point, free=True) is None


@pytest.mark.parametrize("name", ["tripod", "planar_3rrr"])
def test_limits_of_joints_are_respected(name: str, tmp_path: Path) -> None:
    """Of actuated and passive joints, by reach and close; and a joint that is beyond them may come back."""
    rng = np.random.default_rng([6, *name.encode()])
    robot = stand(drawn(name, 6), tmp_path / "plain")
    x = 0.1 * robot.led.freedoms(rng)
    pose, chain = robot.pose(x), robot.chain
    home, there = chain.home, chain.reach(robot.pose(x))
    for joint in ("leg1", "hinge1") if name == "tripod" else ("crank1", "elbow1"):
        index = chain.model.joints[chain.model.getJointId(joint)].idx_q
        start, end = float(home.q_full[index]), float(there.q_full[index])
        middle, side = 0.5 * (start + end), np.sign(end - start)
        bounds = (middle, start + 9.0) if side < 0.0 else (start - 9.0, middle)
        machine = compiled(ClosedChain(with_limits(robot.description, {joint: bounds})), cached=False)
        assert quick(machine, machine.home, pose) is not None
        error = same_error(machine, pose, LimitError)
        assert isinstance(error, LimitError)
        assert error.joint == joint
        beyond = machine.reach(pose, limits="ignore")
        np.testing.assert_allclose(beyond.q, there.q, rtol=0, atol=1e-12)
        with pytest.raises(LimitError):
            machine.close(there.q)
        np.testing.assert_allclose(machine.close(there.q, limits="ignore").q_full, beyond.q_full, rtol=0, atol=1e-12)
        machine.reach(robot.pose(0.9 * x), beyond)
        with pytest.raises(LimitError):
            machine.reach(robot.pose(1.1 * x), beyond)
        np.testing.assert_allclose(machine.close(home.q, beyond).q, home.q, rtol=0, atol=1e-12)


def test_half_a_turn_is_left_to_the_chain(tmp_path: Path) -> None:
    """Where the rotation that is missed has no direction."""
    robot = stand(drawn("serial_wrist", 1), tmp_path)
    machine = compiled(robot.chain, cached=False)
    pose = machine.tool(machine.home).pose
    for angle in (3.0, np.pi - 1e-9, np.pi):
        assert quick(machine, machine.home, pose.moved(turn=(angle, 0.0, 0.0))) is None


def test_a_base_far_away_costs_no_digits(tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    size = Size(rotation=random_rotation(rng), offset=np.array([8e3, -5e3, 3e3]))
    robot = stand(drawn("tripod", 2), tmp_path, size)
    machine = compiled(robot.chain, cached=False)
    assert any(machine.source.origin)
    x = np.array([0.004, 0.02, -0.01])
    found = quick(machine, machine.home, robot.pose(x))
    assert found is not None
    assert max(found.gap) < 1e-15
    np.testing.assert_allclose(found.q, robot.chain.reach(robot.pose(x)).q, rtol=0, atol=1e-15)
    assert np.abs(machine.tool(found).position - robot.pose(x)[:3, 3]).max() < 2e-12, (
        "the rounding of the target itself"
    )


@pytest.mark.parametrize(
    "name", few(["stewart", "fivebar", "tripod", "spherical_3rrr", "pan_tilt"], "fivebar", "tripod")
)
def test_many_targets_at_once(name: str, tmp_path: Path) -> None:
    """All over the workspace, in every form, and no row of it by the chain."""
    rng = np.random.default_rng([8, *name.encode()])
    robot = somewhere(name, 5, tmp_path, rng)
    machine = compiled(robot.chain, cached=False)
    several = [robot.led.freedoms(rng) for _ in range(40)]
    poses = np.array([robot.pose(x) for x in several])
    seven = [np.concatenate([pose[:3, 3], Pose.of(pose).quaternion]) for pose in poses]
    assert machine.batch._reaching is not None
    _, done = machine.batch._reaching.many(machine.home.q_full, [machine.task.target(pose) for pose in poses], 1)
    assert done.all()
    for targets in [poses, seven, *([poses[:, :3, 3]] if machine.task.is_of_point else [])]:
        for x, found in zip(several, machine.batch.reach(targets), strict=True):
            assert robot.missed(machine.chain.actuated(found), x) < ACCURACY
    assert machine.batch.reach(poses[:0]).shape == (0, machine.chain.nq)
    again = pickle.loads(pickle.dumps(machine.batch))
    np.testing.assert_array_equal(again.reach(poses[:3]), machine.batch.reach(poses[:3]))


def test_a_target_among_many_that_cannot_be(tmp_path: Path) -> None:
    robot = stand(drawn("tripod", 6), tmp_path)
    x = 0.1 * robot.led.freedoms(np.random.default_rng(9))
    there, home = robot.chain.reach(robot.pose(x)), robot.chain.home
    bounds = sorted([float(home.q[1]), float(0.5 * (home.q[1] + there.q[1]))])
    machine = compiled(ClosedChain(with_limits(robot.description, {"leg1": tuple(bounds)})), cached=False)
    here, far = robot.pose(0.1 * x), robot.pose(0.1 * x)
    far[2, 3] += 9.0
    machine.batch.reach([here, here])
    for bad, kind in ((robot.pose(x), LimitError), (far, UnreachableError)):
        with pytest.raises(kind) as caught:
            machine.batch.reach([here, bad, here])
        assert caught.value.__notes__ == ["row 1 of the batch"]
    with pytest.raises(LimitError, match="leg1") as beyond:
        machine.batch.close([home.q, there.q])
    assert beyond.value.__notes__ == ["row 1 of the batch"]
    with pytest.raises(InputError, match="does not fix"):
        machine.batch.reach(np.zeros((2, 3)))
    with pytest.raises(InputError, match="shape"):
        machine.batch.reach(np.zeros((2, 5)))


def test_near_a_singular_posture_the_chain_leads(tmp_path: Path) -> None:
    """A wrist nearly in line with itself: a short way changes the determinant too much to tell the branch by."""
    robot = stand(drawn("serial_wrist", 1), tmp_path)
    machine = compiled(robot.chain, cached=False)
    at, there = machine.close([0.1, 1.54, 0.2]), machine.close([0.1, 1.44, 0.2])
    target = machine.tool(there).pose
    assert quick(machine, at, target) is None
    np.testing.assert_allclose(machine.reach(target, at).q, there.q, rtol=0, atol=1e-10)
    nearer = machine.tool(machine.close([0.1, 1.53, 0.2])).pose
    assert quick(machine, at, nearer) is not None


@pytest.mark.parametrize(
    "name", few(["stewart", "planar_3rrr", "schoenflies", "tripod", "spherical_3rrr", "delta"], "planar_3rrr", "tripod")
)
def test_a_step_is_one_of_newton_in_numbers(name: str, tmp_path: Path) -> None:
    """Also to a goal that is far turned away, where a matrix that is nearly right would only be slow."""
    rng = np.random.default_rng([10, *name.encode()])
    robot = somewhere(name, 7, tmp_path, rng)
    chain, machine = robot.chain, compiled(robot.chain, cached=False)
    task, step = chain.task, machine.library()["reach_step"]
    for _ in range(5):
        at = chain.reach(robot.pose(robot.led.freedoms(rng)))
        tool = chain.tool(at)
        goal = tool.pose.moved(0.1 * robot.length * rng.uniform(-1, 1, 3), 0.5 * rng.uniform(-1, 1, 3))
        parts = step(at.q_full, goal_of(goal, chain.origin), np.zeros(0))
        assert parts is not None
        condition = task.towards(goal, task.rows)
        error = condition.error(tool.position, tool.rotation)
        rate = condition.matrix(tool.rotation) @ tool.frame_jacobian
        change = chain.actuated(parts["q_next"]) - at.q
        wanted = np.linalg.solve(rate, -error)
        assert np.abs(change - wanted).max() < 1e-11 * np.abs(wanted).max()


def test_rotations_of_many_vectors() -> None:
    vectors = np.random.default_rng(11).normal(size=(20, 3)) * np.geomspace(1e-9, 3.0, 20)[:, None]
    vectors[0] = 0.0
    wanted = [turned(vector) for vector in vectors]
    np.testing.assert_allclose(reaching._turned(vectors), wanted, rtol=0, atol=1e-14)
