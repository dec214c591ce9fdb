"""How robots are led along trajectories of the tool and of the actuators: families of robots, any size, anywhere."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from kit.led import with_limits
from kit.led_robots import LED, drawn, somewhere, stand
from kit.quickly import few
from kit.shipped import DETERMINED

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.description import load_description
from cutjoint.errors import InputError, LimitError, SingularError, UnreachableError
from cutjoint.mechanism import Pose
from cutjoint.mechanism.task import NAMES
from cutjoint.motion import (
    Circle,
    Hold,
    JointMotion,
    JointSine,
    Lissajous,
    PointToPoint,
    PoseMove,
    Reference,
    ToolMotion,
    Trajectory,
)
from cutjoint.motion.catalogue import trajectory
from cutjoint.motion.following import ToolFollower

SAMPLES = (0.0, 0.213, 0.5, 0.871)
SEEDS = [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 2, 3, 5, 7))]
"""Robots with an odd number stand anywhere, and are of any size."""


@dataclass(frozen=True)
class Replayed:
    """The motion of the tool that a reference in joint space gives, as a trajectory of the tool."""

    whole: Reference
    given: tuple[str, ...] | None = None
    name: str = "replayed"

    @property
    def duration(self) -> float:
        return self.whole.duration

    def at(self, t: float) -> ToolMotion:
        return replace(self.whole.at(t).tool, given=self.given)


def sines(chain: ClosedChain, length: float, rng: np.random.Generator) -> JointSine:
    """Small motions of all actuators, each at its own rate."""
    unit = np.array([1.0 if one.kind == "rotation" else length for one in chain.actuators])
    rate = 2.0 * np.pi * rng.uniform(0.5, 1.5, chain.n)
    return JointSine(chain.home.q, 0.015 * unit * rng.uniform(-1.0, 1.0, chain.n), rate, np.zeros(chain.n), 1.0)


def compare_with_differences(reference: Reference, length: float) -> None:
    """Actuator rates are derivatives of the postures; the tool's motion is that of the postures too."""
    model, h = reference.mechanism, 1e-4 * reference.duration
    unit = np.array([1.0 if one.kind == "rotation" else length for one in model.actuators])
    for part in SAMPLES[1:]:
        t = part * reference.duration
        far, near, now, later, beyond = (reference.at(t + k * h) for k in (-2, -1, 0, 1, 2))
        for rate, told in (("q", now.v), ("v", now.a)):
            one, two, three, four = (getattr(at, rate) for at in (far, near, later, beyond))
            found = (8.0 * (three - two) - (four - one)) / (12.0 * h)
            assert np.abs((found - told) / unit).max() < 1e-6 * (1.0 + np.abs(told / unit).max())
        tool = model.tool(now.posture, now.v)
        rates = tool.frame_jacobian @ now.a + tool.frame_drift
        scale = np.r_[length, length, length, 1.0, 1.0, 1.0]
        desired = np.r_[now.tool.velocity, now.tool.angular_velocity]
        assert np.abs(tool.position - now.tool.position).max() < 1e-11 * length
        assert np.abs(tool.rotation - now.tool.rotation).max() < 1e-11
        assert np.abs((tool.twist - desired) / scale).max() < 1e-9
        changes = np.r_[now.tool.acceleration, now.tool.angular_acceleration]
        assert np.abs((rates - changes) / scale).max() < 1e-8


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", few(LED, "stewart", "planar_3rrr", "tripod", "spherical_3rrr"))
def test_the_tools_motion_leads_back_to_the_actuators(name, seed, tmp_path):
    """Joint space forwards, then the pose of the tool backwards: the same actuators, velocities and accelerations."""
    rng = np.random.default_rng([seed, *name.encode()])
    robot = somewhere(name, seed, tmp_path, rng)
    joint = Reference(sines(robot.chain, robot.length, rng), robot.chain)
    led = Reference(Replayed(joint), robot.chain)
    unit = robot.length if robot.led.slides else 1.0
    for part in SAMPLES:
        one, two = joint.at(part), led.at(part)
        assert np.abs(one.q - two.q).max() < 1e-10 * unit
        assert np.abs(one.v - two.v).max() < 1e-8 * unit
        assert np.abs(one.a - two.a).max() < 1e-7 * unit
    compare_with_differences(joint, robot.length)
    compare_with_differences(led, robot.length)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", [name for name in LED if name != "pan_tilt"])
def test_what_is_prescribed_is_reached_and_the_rest_stays(name, seed, tmp_path):
    """A move along all that the robot leads, with nothing else prescribed."""
    rng = np.random.default_rng([seed, *name.encode()])
    robot = somewhere(name, seed, tmp_path, rng)
    task = robot.chain.task
    away = dict(zip(task.names, 0.03 * rng.uniform(-1.0, 1.0, len(task.names)), strict=True))
    by = task.basis @ [robot.length * away.get(name, 0.0) for name in NAMES[:3]]
    turn = task.basis @ [away.get(name, 0.0) for name in NAMES[3:]]
    reference = Reference(PoseMove(task.home, by, turn, 1.0, given=task.names), robot.chain)
    compare_with_differences(reference, robot.length)
    unit = np.array([robot.length if one == "m" else 1.0 for one in task.units])
    found = task.coordinates(robot.chain.tool(reference.at(1.0).posture).pose) - task.coordinates(task.home)
    assert np.allclose(found, unit * list(away.values()), atol=1e-11 * robot.length, rtol=1e-11)
    half = task.names[: len(task.names) // 2]
    if half:
        # What is not prescribed stays as at home, whatever the motion says of it.
        part = Reference(
            PoseMove(task.home, by, turn if set(half) & set(NAMES[3:]) else 0.0 * turn, 1.0, given=half), robot.chain
        )
        found = task.coordinates(robot.chain.tool(part.at(1.0).posture).pose) - task.coordinates(task.home)
        led = [name in half or (name in NAMES[3:] and bool(set(half) & set(NAMES[3:]))) for name in task.names]
        assert np.allclose(found, led * unit * list(away.values()), atol=1e-11 * robot.length, rtol=1e-11)


def test_a_tripod_tilts_far_and_twists_as_it_must(tmp_path):
    """What is not led, here the torsion, goes its own way; the rates of what is led take that in."""
    robot = stand(drawn("tripod", 2), tmp_path)
    task = robot.chain.task
    move = PoseMove(task.home, [0.0, 0.0, 0.02], [0.3, 0.25, 0.0], 1.0, given=task.names)
    reference = Reference(move, robot.chain)
    compare_with_differences(reference, robot.length)
    found = task.coordinates(robot.chain.tool(reference.at(1.0).posture).pose)
    assert np.allclose(found, np.add(task.coordinates(task.home), [0.02, 0.3, 0.25]), atol=1e-11)


@pytest.mark.parametrize("name", DETERMINED)
def test_shipped_robots_follow_and_hold(name):
    chain = cutjoint.load(name)
    still = Reference(Hold.at_home(chain, 1.0), chain).at(0.7)
    assert not still.v.any()
    assert not still.a.any()
    compare_with_differences(Reference(trajectory("joint-sine:0.01,1", chain), chain), 1.0)
    if chain.n > 1:
        compare_with_differences(Reference(trajectory("circle:0.01", chain), chain), 1.0)


@pytest.mark.parametrize("name", LED)
def test_a_point_trajectory_keeps_the_orientation(name, tmp_path):
    """Where the robot leads rotations they stay as at home; where it turns by itself, that is its own affair."""
    rng = np.random.default_rng(7)
    robot = somewhere(name, 1, tmp_path, rng)
    chain, task = robot.chain, robot.chain.task
    held = Reference(Hold(task.home.position), chain).at(0.3)
    assert np.abs(held.posture.q - chain.home.q).max() < 1e-11 * max(robot.length, 1.0)
    if set("xyz") <= set(task.names) and name != "pan_tilt":
        way = PointToPoint(task.home.position, task.home.position + 0.03 * robot.length * rng.normal(size=3))
        end = chain.tool(Reference(way, chain).at(1.0).posture)
        assert np.abs(end.position - way.goal).max() < 1e-11 * robot.length
        if len(task.names) == 6:
            assert np.abs(end.rotation - task.home.rotation).max() < 1e-11


def test_closed_ways_come_back(tmp_path):
    """Ten turns of a circle with the orientation held: the start again, and the same bits turn by turn."""
    robot = somewhere("stewart", 4, tmp_path, np.random.default_rng(4))
    reference = Reference(Circle.through_home(robot.chain, 0.05 * robot.length, 1.0), robot.chain)
    for turn in range(1, 11):
        assert np.abs(reference.at(float(turn)).q - reference.at(0.0).q).max() < 1e-12 * robot.length


# ---- more and fewer actuators than what is led -----------------------------------------------------------------------


def with_task(name, tmp_path, *names):
    robot = stand(drawn(name, 0), tmp_path)
    return ClosedChain(replace(robot.description, task=names)), robot


def test_more_actuators_than_rows_go_the_least_way_and_come_back(tmp_path):
    chain, robot = with_task("stewart", tmp_path, "x", "y", "z")
    way = Circle.through_home(chain, 0.05 * robot.length, 1.0)
    reference = Reference(way, chain)
    compare_with_differences(reference, robot.length)
    start = reference.at(0.0)
    jacobian = chain.tool(start.posture).jacobian
    least = np.linalg.pinv(jacobian) @ way.at(0.0).velocity
    assert np.allclose(start.v, least, atol=1e-9 * robot.length)
    assert np.abs(reference.at(1.0).q - start.q).max() < 1e-11 * robot.length
    for t in (0.3, 0.8):
        assert np.abs(chain.tool(reference.at(t).posture).position - way.at(t).position).max() < 1e-11 * robot.length


def test_a_plane_of_three_sliders_leaves_the_third_alone():
    """The third slider of this robot moves its tool along z alone, which is not led here."""
    chain = ClosedChain(replace(load_description("cpm"), task=("x", "y")))
    reference = Reference(Circle(chain.task.home.position - [0.02, 0.0, 0.0], 0.02, np.pi), chain)
    compare_with_differences(reference, 1.0)
    assert abs(reference.at(1.3).q[2] - chain.home.q[2]) < 1e-12


def test_a_surface_is_followed_and_what_leaves_it_is_refused(tmp_path):
    rng = np.random.default_rng(3)
    robot = somewhere("pan_tilt", 2, tmp_path, rng)
    chain = robot.chain
    home = chain.task.home.position
    normal = np.linalg.svd(chain.tool(chain.home).jacobian)[0][:, 2]
    with pytest.raises(UnreachableError, match="leaves the workspace"):
        Reference(PointToPoint(home, home + 0.1 * robot.length * normal), chain)

    class Skimming:
        """On the surface at all times; but its velocity is not along it."""

        name, duration = "skimming", 1.0

        def at(self, t):
            return ToolMotion(home, 0.1 * robot.length * normal, np.zeros(3))

    with pytest.raises(UnreachableError, match="cannot move so"):
        Reference(Skimming(), chain)


# ---- what cannot be done ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", few(LED, "delta", "planar_3rrr", "tripod"))
def test_what_is_not_led_is_named(name, tmp_path):
    """A motion along something that the robot does not lead, prescribed: refused, told what, by how much and when."""
    rng = np.random.default_rng([5, *name.encode()])
    robot = somewhere(name, 0, tmp_path, rng)
    chain, task = robot.chain, robot.chain.task
    for row, other in enumerate(NAMES):
        if other in task.names:
            continue
        along = np.eye(6)[row] * (0.05 * robot.length if row < 3 else 0.1)
        free = PoseMove(task.home, task.basis @ along[:3], task.basis @ along[3:], given=task.names)
        moved = robot.chain.tool(Reference(free, chain).at(1.0).posture).pose
        wanted = Pose(free.at(1.0).position, free.at(1.0).rotation)
        missed = abs(float(task.towards(wanted, [row]).error(moved.position, moved.rotation)[0]))
        with pytest.raises(
            UnreachableError, match=rf"leads {task}: it would miss (.*, )?{other} by [\d.e-]+ "
        ) as caught:
            Reference(replace(free, given=(*task.names, other)), chain)
        word = f"{other} by {missed:.4g} m" if row < 3 else f"{other} by {np.degrees(missed):.4g} deg"
        assert f"{word} at t = 1 s" in str(caught.value)


def test_limits_on_the_way_are_told(tmp_path):
    robot = stand(drawn("stewart", 1), tmp_path)
    chain, joint = robot.chain, robot.chain.actuators[2].name
    way = PointToPoint(chain.task.home.position, chain.task.home.moved([0.0, 0.0, 0.1 * robot.length]).position, 2.0)
    free = Reference(way, chain)
    at = free.at(1.0)
    low, high = sorted((chain.home.q[2] - 0.5 * (at.q[2] - chain.home.q[2]), at.q[2]))
    bounded = ClosedChain(with_limits(robot.description, {joint: (low, high)}))
    with pytest.raises(
        LimitError, match=rf"'point to point' goes beyond the joint limits .* at t = 1\.0\d* s.*'{joint}'"
    ) as caught:
        Reference(way, bounded)
    assert caught.value.joint == joint
    assert caught.value.bounds == (low, high)
    assert 0.5 <= caught.value.progress < 0.55
    Reference(way, bounded, 0.99)
    ignoring = Reference(way, bounded, limits="ignore")
    assert np.allclose(ignoring.at(1.7).q, free.at(1.7).q, atol=1e-12)
    assert np.allclose(ignoring.at(1.7).posture_of(chain).q_full, free.at(1.7).posture.q_full, atol=1e-9)
    joint_way = JointSine(chain.home.q, 2.0 * (at.q - chain.home.q), np.full(6, np.pi), np.zeros(6), 2.0)
    with pytest.raises(LimitError, match=rf"'joint sine' goes beyond .* at t = .*'{joint}'"):
        Reference(joint_way, bounded)


@dataclass(frozen=True)
class Given:
    """A trajectory that gives what it is told."""

    early: object
    late: object
    name: str = "given"
    duration: float = 1.0

    def at(self, t: float) -> object:
        return self.early if t < 0.5 else self.late


STILL = (np.zeros(3), np.zeros(3), np.zeros(3))


@pytest.mark.parametrize(
    ("late", "about"),
    [
        (lambda p: ToolMotion(p * np.nan, *STILL[1:]), r"gives position \[nan.* at t = 0\.5 s"),
        (lambda p: ToolMotion(p, STILL[0] + np.inf, STILL[0]), r"gives velocity \[inf"),
        (lambda p: ToolMotion(p, np.zeros(2), STILL[0]), r"velocity of shape \(2,\).*shape \(3,\)"),
        (lambda p: ToolMotion(p, *STILL[1:], np.ones((3, 3)), *STILL[1:]), "rotation at t = 0.5 s that is none"),
        (lambda p: ToolMotion(p, *STILL[1:], -np.eye(3), *STILL[1:]), "that is none"),
        (lambda p: ToolMotion(p, *STILL[1:], np.eye(3), STILL[0] + np.nan, STILL[0]), "angular_velocity"),
        (lambda p: JointMotion(*STILL), "must give a ToolMotion .* found JointMotion"),
        (lambda p: p, "found ndarray"),
        (lambda p: None, "found NoneType"),
    ],
)
def test_what_a_trajectory_gives_is_looked_at(late, about):
    chain = cutjoint.load("omega3")
    home = chain.task.home.position
    with pytest.raises(InputError, match=about):
        Reference(Given(ToolMotion(home, *STILL[1:]), late(home)), chain)


def test_a_joint_motion_of_another_robot_is_refused():
    chain = cutjoint.load("stewart")
    with pytest.raises(InputError, match=r"gives q of shape \(3,\).*must have shape \(6,\)"):
        Reference(JointSine(*STILL, np.zeros(3), 1.0), chain)
    first = JointMotion(chain.home.q, np.zeros(6), np.zeros(6))
    with pytest.raises(InputError, match="must give a JointMotion, as at the start"):
        Reference(Given(first, ToolMotion(*STILL)), chain)


def test_a_direction_that_the_tool_cannot_take_is_told():
    """A tool on a curve may rest there, but not leave it; and one whose leg is stretched cannot go on outwards."""
    chain = cutjoint.load("fourbar")
    home = chain.task.home.position
    Reference(Hold(home), chain)
    with pytest.raises(UnreachableError, match="cannot move so"):
        Reference(Given(*2 * [ToolMotion(home, np.array([0.3, 0.0, 0.1]), np.zeros(3))]), chain)

    chain = cutjoint.load("fivebar")

    def side(shift):
        """The posture after one arm has turned back, and on which side of the singular one it is."""
        at = chain.home
        for part in np.linspace(0.0, shift, 30)[1:]:
            at = chain.close(chain.home.q - [part, 0.0], at, limits="ignore")
        return at, np.linalg.det(chain.tool(at).jacobian[[0, 2]])

    low, high, at = 0.9, 1.2, chain.home
    for _ in range(50):
        middle = 0.5 * (low + high)
        at, sign = side(middle)
        low, high = (middle, high) if sign * side(0.0)[1] > 0.0 else (low, middle)
    place = chain.tool(at).position
    for velocity in np.eye(3)[[0, 2]]:
        motion = ToolMotion(place, velocity, np.zeros(3))
        demand = ToolFollower(Given(motion, motion), chain, "respect").at(0.0)
        with pytest.raises(SingularError, match="cannot move in some direction of its task x z") as caught:
            demand.rates(at)
        assert caught.value.kind == "type-1"


def test_references_are_trajectories_of_any_length():
    """Anchors are as dense in a long motion as in a short one."""
    chain = cutjoint.load("fivebar")
    home = chain.task.home.position
    slow = Lissajous(home, [0.02, 0.0, 0.02], [0.3, 0.0, 0.4], [-0.5 * np.pi] * 3, 12.0)
    assert isinstance(slow, Trajectory)
    compare_with_differences(Reference(slow, chain), 1.0)


@pytest.mark.parametrize(
    ("name", "spec"),
    [
        pytest.param("stewart", "pose:0.02,0,0.01,2,0,4", marks=pytest.mark.slow),
        ("fivebar", "lissajous:0.03,0.02"),
        pytest.param("omega3", "joint-chirp:0.05,0.5,2,2", marks=pytest.mark.slow),
    ],
)
def test_compiled_robots_follow_alike(name, spec):
    chain = cutjoint.load(name)
    quick = chain.compile()
    made = trajectory(spec, chain)
    one, two = Reference(made, chain), Reference(trajectory(spec, quick), quick)
    for part in SAMPLES:
        t = part * made.duration
        for rate in ("q", "v", "a"):
            assert np.abs(getattr(one.at(t), rate) - getattr(two.at(t), rate)).max() < 1e-9
    compare_with_differences(two, 1.0)


@pytest.mark.parametrize("name", ["cpm", "omega3", "cpm_rotary"])
def test_published_models_follow_like_their_chains(name):
    paper, chain = cutjoint.published(name), cutjoint.load(name, "lumped")
    for spec in ("helix:0.01,0.01", "joint-sine:0.02", "pick-and-place:0.7,0.03"):
        one, two = Reference(trajectory(spec, paper), paper), Reference(trajectory(spec, chain), chain)
        for t in SAMPLES:
            for rate in ("q", "v", "a"):
                assert np.abs(getattr(one.at(t), rate) - getattr(two.at(t), rate)).max() < 1e-8
        if not spec.startswith("pick"):  # whose third derivative jumps in the middle
            compare_with_differences(one, 1.0)
