"""Trajectories: velocity and acceleration are the derivatives of position, as smooth as they say, whatever the
parameters."""

import copy
import pickle
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cutjoint.errors import InputError
from cutjoint.mechanism import Pose
from cutjoint.mechanism.rotations import turned, vector_of
from cutjoint.motion import (
    Circle,
    Corners,
    Hold,
    JointChirp,
    JointMotion,
    JointSine,
    JointWaypoints,
    Lissajous,
    PickAndPlace,
    PointToPoint,
    PoseMove,
    Spiral,
    ToolMotion,
    Trajectory,
    Trapezoidal,
    Waypoints,
)
from cutjoint.motion.pick_and_place import EARLY, LIFT

coordinate = st.floats(-2.0, 2.0)
point = st.tuples(coordinate, coordinate, coordinate)
rate = st.floats(0.2, 8.0)
seconds = st.floats(0.3, 3.0)
numbers = st.integers(0, 2**32 - 1).map(np.random.default_rng)


@st.composite
def planes(draw):
    first = np.add(draw(point), (3.0, 0.0, 0.0))
    first /= np.linalg.norm(first)
    second = np.cross(first, [0.0, 0.6, 0.8])
    return first, second / np.linalg.norm(second)


@st.composite
def corners(draw, width, smooth=("quintic", "parabolic")):
    rng, count = draw(numbers), draw(st.integers(2, 6))
    legs = rng.uniform(0.2, 1.5, count - 1)
    return Corners(
        rng.uniform(-2.0, 2.0, (count, width)), legs, rng.uniform(0.1, 0.5) * legs.min(), draw(st.sampled_from(smooth))
    )


poses = st.builds(lambda p, turn: Pose(np.array(p), turned(turn)), point, point)
turns = numbers.map(lambda rng: turned(rng.uniform(-2.0, 2.0, 3)))
part = st.floats(0.0, 1.0)
pairs = st.tuples(part, st.floats(0.0, 4.0))
KINDS = {
    "hold": st.builds(Hold, point),
    "line": st.builds(PointToPoint, point, point, seconds),
    "trapezoidal": st.builds(
        lambda a, b, t, ramp: Trapezoidal(a, b, t, ramp=ramp), point, point, seconds, st.floats(0.05, 0.5)
    ),
    "circle": st.builds(lambda c, r, w, p: Circle(c, r, w, *p), point, st.floats(0.01, 2.0), rate, planes()),
    "lissajous": st.builds(
        lambda *values: Lissajous(*values[:-1], axes=values[-1]),
        *(point, point, st.tuples(rate, rate, rate), point, st.floats(0.5, 4.0), turns),
    ),
    "spiral": st.builds(
        lambda c, r, rise, turns, t, p: Spiral(c, r, rise, turns, t, *p),
        *(point, st.tuples(part, part), coordinate, st.floats(-4.0, 4.0), seconds, planes()),
    ),
    "pick and place": st.builds(PickAndPlace, point, point, point, seconds),
    "pose": st.builds(PoseMove, poses, point, point, seconds),
    "way-points": st.builds(Waypoints, corners(3)),
    "joint way-points": st.builds(JointWaypoints, corners(5)),
    "joint sine": st.builds(JointSine, point, point, st.tuples(rate, rate, rate), point, st.floats(0.5, 4.0)),
    "joint chirp": st.builds(JointChirp, point, point, pairs, seconds),
}
trajectories = st.one_of(*KINDS.values())


def breaks(trajectory):
    """Times at which a trajectory is pieced together."""
    end = trajectory.duration
    if isinstance(trajectory, Waypoints | JointWaypoints):
        times = trajectory.corners.blend + np.r_[0.0, np.cumsum(trajectory.corners.seconds)]
        return np.r_[times - trajectory.corners.blend, times + trajectory.corners.blend]
    if isinstance(trajectory, Trapezoidal):
        return end * np.array([0.0, trajectory.ramp, 1.0 - trajectory.ramp, 1.0])
    if isinstance(trajectory, PickAndPlace):
        half = 0.5 * np.array([0.0, EARLY, LIFT, 1.0 - LIFT, 1.0 - EARLY, 1.0])
        return end * np.r_[half, 0.5 + half]
    if isinstance(trajectory, JointChirp):
        return end * np.array([0.0, 0.1, 0.9, 1.0])
    return end * np.array([0.0, 1.0])


def state(trajectory, t):
    """Place, velocity and acceleration, the rotation apart."""
    at = trajectory.at(t)
    if isinstance(at, JointMotion):
        return np.array([at.q, at.v, at.a])
    return np.array([at.position, at.velocity, at.acceleration])


def slope(function, t, h):
    """Derivative by a difference of fourth order."""
    far, near = function(t + 2 * h) - function(t - 2 * h), function(t + h) - function(t - h)
    return (8.0 * near - far) / (12.0 * h)


@pytest.mark.parametrize("kind", KINDS)
@given(st.data())
@settings(max_examples=25)
def test_velocity_and_acceleration_are_derivatives(kind, data):
    """At some time in each of its pieces."""
    trajectory = data.draw(KINDS[kind])
    share, h = data.draw(part), 2e-4 * trajectory.duration
    for first, last in pairwise(np.unique(breaks(trajectory)).tolist()):
        if last - first < 8.0 * h:
            continue
        t = first + 3.0 * h + share * (last - first - 6.0 * h)
        found, now = slope(lambda s: state(trajectory, s), t, h), state(trajectory, t)
        scale = 1.0 + np.abs(now).max()
        assert np.abs(found[0] - now[1]).max() < 1e-6 * scale
        assert np.abs(found[1] - now[2]).max() < 1e-6 * scale


@given(st.builds(PoseMove, poses, point, point, seconds), st.floats(0.01, 0.99))
def test_angular_velocity_and_acceleration_are_derivatives(trajectory, fraction):
    t, h = fraction * trajectory.duration, 1e-4 * trajectory.duration
    now = trajectory.at(t)

    def turn(s):
        return vector_of(trajectory.at(s).rotation @ now.rotation.T)

    assert np.abs(slope(turn, t, h) - now.angular_velocity).max() < 1e-6 * (1.0 + np.abs(now.angular_velocity).max())
    found = slope(lambda s: trajectory.at(s).angular_velocity, t, h)
    assert np.abs(found - now.angular_acceleration).max() < 1e-6 * (1.0 + np.abs(now.angular_acceleration).max())
    assert np.allclose(now.rotation @ now.rotation.T, np.eye(3), atol=1e-14)


@pytest.mark.parametrize("kind", KINDS)
@given(st.data())
@settings(max_examples=25)
def test_they_are_as_smooth_as_they_say(kind, data):
    """C2 at every place where they are pieced together, but for trapezoids and parabolic blends, which are C1."""
    trajectory = data.draw(KINDS[kind])
    parabolic = isinstance(trajectory, Waypoints | JointWaypoints) and trajectory.corners.smooth == "parabolic"
    starts_moving = isinstance(trajectory, Circle | Lissajous | JointSine)
    end = trajectory.duration
    for t in [] if starts_moving else breaks(trajectory):
        h = 1e-9 * end
        before, after = state(trajectory, t - h), state(trajectory, t + h)
        scale = 1.0 + max(np.abs(state(trajectory, s)).max() for s in np.linspace(0.0, end, 50))
        smooth = 2 if parabolic or isinstance(trajectory, Trapezoidal) else 3
        # Over 2e-9 of the duration what is continuous changes by no more than that times its rate.
        assert np.abs(after - before)[:smooth].max() < 1e-5 * scale
    if starts_moving:
        assert not isinstance(trajectory, Circle) or np.allclose(state(trajectory, 0.0), state(trajectory, end))


@given(point, point, seconds, st.floats(0.05, 0.45))
def test_only_the_acceleration_of_a_trapezoid_jumps(start, goal, duration, ramp):
    way = Trapezoidal(start, goal, duration, ramp=ramp)
    h, length = 1e-9 * duration, np.abs(np.subtract(goal, start)).max()
    for t in ramp * duration, (1.0 - ramp) * duration:
        jump = np.abs(state(way, t + h) - state(way, t - h))[2].max()
        assert np.isclose(jump, length / (ramp * (1.0 - ramp) * duration**2), rtol=1e-5, atol=1e-9)
    assert np.isclose(np.abs(way.at(0.5 * duration).velocity).max(), length / (duration * (1.0 - ramp)))


@pytest.mark.parametrize("kind", KINDS)
@given(st.data())
@settings(max_examples=10)
def test_all_are_trajectories(kind, data):
    trajectory = data.draw(KINDS[kind])
    assert isinstance(trajectory, Trajectory)
    assert trajectory.duration > 0.0
    assert trajectory.name
    for other in (pickle.loads(pickle.dumps(trajectory)), copy.deepcopy(trajectory)):
        assert np.array_equal(state(other, 0.4), state(trajectory, 0.4))


RESTING = ("line", "trapezoidal", "spiral", "pose", "way-points", "joint way-points", "joint chirp")


@pytest.mark.parametrize("kind", RESTING)
@given(st.data(), st.floats(1e-6, 2.0))
@settings(max_examples=25)
def test_moves_rest_outside(kind, data, beyond):
    trajectory = data.draw(KINDS[kind])
    for t, end in ((-beyond, 0.0), (trajectory.duration + beyond, trajectory.duration)):
        at, there = state(trajectory, t), state(trajectory, end)
        assert np.allclose(at[0], there[0], atol=1e-12)
        assert np.abs(at[1:]).max() == 0.0
        assert np.abs(there[1]).max() < 1e-12


@given(point, point, seconds)
def test_lines_start_and_end_where_they_say(start, goal, duration):
    for way in (PointToPoint(start, goal, duration), Trapezoidal(start, goal, duration)):
        assert np.allclose(way.at(0.0).position, start, atol=1e-12)
        assert np.allclose(way.at(duration).position, goal, atol=1e-12)


@given(corners(3), st.floats(0.0, 1.0))
def test_legs_between_blends_are_straight_and_even(legs, part):
    """Between two blends the way is on the line of its two points, at the constant speed of the leg."""
    times = legs.blend + np.r_[0.0, np.cumsum(legs.seconds)]
    for k, (first, last) in enumerate(pairwise(times)):
        t = first + legs.blend + part * (last - first - 2.0 * legs.blend)
        place, velocity, acceleration = legs.at(t)
        along = (t - first) / legs.seconds[k]
        step = legs.points[k + 1] - legs.points[k]
        assert np.allclose(place, legs.points[k] + along * step, atol=1e-12)
        if 0.01 < part < 0.99:
            assert np.allclose(velocity, step / legs.seconds[k], atol=1e-9)
            assert np.abs(acceleration).max() < 1e-9


@given(corners(2, smooth=("quintic",)))
def test_blends_are_the_quintics_that_meet_both_legs(legs):
    """Position, velocity and acceleration at both ends of a blend fix a polynomial of fifth degree."""
    times, b = legs.blend + np.r_[0.0, np.cumsum(legs.seconds)], legs.blend
    for t in times:
        ends = np.concatenate([legs.at(t - b + 1e-15), legs.at(t + b - 1e-15)])
        powers = np.arange(6)
        rows = [
            [np.prod(powers[k] - np.arange(order)) * u ** max(powers[k] - order, 0) for k in range(6)]
            for u in (-1.0, 1.0)
            for order in range(3)
        ]
        scaled = ends * (b ** np.tile(np.arange(3), 2))[:, None]
        weights = np.linalg.solve(np.array(rows), scaled)
        for u in (-0.7, 0.1, 0.6):
            assert np.allclose(legs.at(t + u * b)[0], u**powers @ weights, atol=1e-9)


@given(point, st.floats(0.01, 2.0), rate, planes(), st.floats(0.0, 5.0))
def test_circle_keeps_radius_speed_and_period(centre, radius, omega, plane, t):
    circle = Circle(centre, radius, -omega, *plane)
    at, later = circle.at(t), circle.at(t + circle.duration)
    assert np.isclose(np.linalg.norm(at.position - circle.centre), radius)
    assert np.isclose(np.linalg.norm(at.velocity), radius * omega)
    assert np.allclose(at.position, later.position, atol=1e-9)


@given(point, point, point, seconds, st.floats(0.0, 1.0))
def test_pick_and_place_goes_there_and_back(start, up, across, duration, part):
    cycle = PickAndPlace(start, up, across, duration)
    half = 0.5 * duration
    start, up, across = map(np.asarray, (start, up, across))
    assert np.allclose(cycle.at(0.0).position, start)
    assert np.allclose(cycle.at(half).position, start + across)
    assert np.allclose(cycle.at(0.5 * half).position, start + up + 0.5 * across)
    there, back = cycle.at(part * half), cycle.at(duration - part * half)
    assert np.allclose(there.position, back.position, atol=1e-9)
    assert np.allclose(cycle.at(part * half + 3.0 * duration).position, there.position, atol=1e-9)
    assert np.isclose(cycle.cycles_per_minute, 60.0 / duration)


@given(st.floats(0.1, 1.0), st.floats(-0.5, 0.5), st.floats(0.5, 5.0), seconds)
def test_a_helix_stays_on_its_cylinder(radius, rise, turns, duration):
    way = Spiral([1.0, 2.0, 3.0], [radius, radius], rise, turns, duration)
    at = np.array([way.at(t).position for t in np.linspace(0.0, duration, 20)]) - [1.0, 2.0, 3.0]
    assert np.allclose(np.hypot(at[:, 0], at[:, 1]), radius)
    assert np.isclose(at[-1, 2], rise)


@pytest.mark.parametrize(
    ("make", "about"),
    [
        (lambda: Hold([0.0, 1.0]), "position"),
        (lambda: Hold([0.0, 1.0, np.nan]), "position"),
        (lambda: Hold([0.0, 0.0, 0.0], duration=0.0), "duration"),
        (lambda: PointToPoint([0.0] * 3, [1.0] * 3, -1.0), "duration"),
        (lambda: PointToPoint([0.0] * 3, "far", 1.0), "goal"),
        (lambda: Trapezoidal([0.0] * 3, [1.0] * 3, 1.0, ramp=0.0), "ramp"),
        (lambda: Trapezoidal([0.0] * 3, [1.0] * 3, 1.0, ramp=0.6), "half"),
        (lambda: Circle([0.0] * 3, 0.0, 1.0), "radius"),
        (lambda: Circle([0.0] * 3, 1.0, 0.0), "rate"),
        (lambda: Circle([0.0] * 3, 1.0, 1.0, [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]), "orthogonal"),
        (lambda: Lissajous([0.0] * 3, [0.0] * 3, [0.0] * 3, [0.0] * 3, np.inf), "duration"),
        (lambda: Lissajous([0.0] * 3, [0.0] * 3, [0.0] * 3, [0.0] * 3, 1.0, axes=np.ones((3, 3))), "axes"),
        (lambda: Spiral([0.0] * 3, [-1.0, 0.0], 0.0, 1.0, 1.0), "radii"),
        (lambda: Spiral([0.0] * 3, [1.0, 0.0], np.nan, 1.0, 1.0), "rise"),
        (lambda: PickAndPlace([0.0] * 3, [0.0] * 3, [0.0] * 2, 1.0), "across"),
        (lambda: PickAndPlace([0.0] * 3, [0.0] * 3, [0.0] * 3, 0.0), "duration"),
        (lambda: PoseMove(np.ones((4, 4))), "last row"),
        (lambda: PoseMove(np.eye(4), turn=[0.0, np.inf, 0.0]), "turn"),
        (lambda: PoseMove(np.eye(4), given=("x", "roll")), "'roll'"),
        (lambda: Waypoints(Corners([[0.0] * 3, [1.0] * 3], [1.0], 0.6)), "overlap"),
        (lambda: Waypoints(Corners([[0.0] * 3, [1.0] * 3], [1.0, 1.0], 0.1)), "seconds"),
        (lambda: Waypoints(Corners([[0.0] * 3, [1.0] * 3], [0.0], 0.1)), "seconds"),
        (lambda: Waypoints(Corners([[0.0] * 3, [1.0] * 3], [1.0], 0.0)), "blend"),
        (lambda: Waypoints(Corners([[0.0] * 3], [], 0.1)), "two points"),
        (lambda: Waypoints(Corners([[0.0] * 2, [1.0] * 2], [1.0], 0.1)), "3 numbers"),
        (lambda: Waypoints(Corners([[0.0] * 3, [np.nan] * 3], [1.0], 0.1)), "finite"),
        (lambda: Waypoints(Corners([[0.0] * 3, [1.0] * 3], [1.0], 0.1, "cubic")), "smooth"),
        (lambda: JointSine([0.0] * 2, [1.0] * 3, [1.0] * 2, [0.0] * 2, 1.0), "amplitude"),
        (lambda: JointChirp([0.0] * 2, [1.0] * 2, [-1.0, 2.0], 1.0), "hertz"),
        (lambda: JointChirp([0.0] * 2, [1.0] * 2, [1.0, 2.0], "long"), "duration"),
        (lambda: ToolMotion([0.0] * 3, [0.0] * 3, [0.0] * 3, np.eye(3)), "angular_velocity"),
        (lambda: ToolMotion([0.0] * 3, [0.0] * 3, [0.0] * 3, given=("rx",)), "without a rotation"),
        (lambda: ToolMotion([0.0] * 3, [0.0] * 3, [0.0] * 3, given=("q1",)), "'q1'"),
    ],
)
def test_bad_parameters_name_themselves(make, about):
    with pytest.raises(InputError, match=about):
        make()


@given(trajectories)
def test_motion_is_read_only(trajectory):
    at = trajectory.at(0.3)
    for array in vars(at).values():
        if isinstance(array, np.ndarray):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 5.0


def test_what_is_prescribed_is_said():
    still = [0.0] * 3
    assert ToolMotion(still, still, still).prescribed == ("x", "y", "z")
    turning = (np.eye(3), still, still)
    assert ToolMotion(still, still, still, *turning).prescribed == ("x", "y", "z", "rx", "ry", "rz")
    assert ToolMotion(still, still, still, *turning, given=("rz",)).prescribed == ("rz",)
