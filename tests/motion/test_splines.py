"""Splines through way-points: derivatives, continuity, ends, and that rotations are treated as rotations."""

import copy
import pickle

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation
from scipy.spatial.transform import RotationSpline as PeerSpline

from cutjoint.errors import InputError, WaypointError
from cutjoint.mechanism import Pose
from cutjoint.mechanism.rotations import turned, vector_of
from cutjoint.motion import JointMotion, JointSpline, PointSpline, PoseSpline, Trajectory
from cutjoint.motion import rotation_spline as rotations

SEEDS = range(12)
AXES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.6, 0.0, -0.8]])


def random_times(rng, n):
    return np.cumsum(10.0 ** rng.uniform(-1.5, 0.0, n)) + rng.normal()


def random_poses(rng, n, largest=2.9, closed=False):
    """Rows x y z qx qy qz qw whose steps turn by up to `largest`, the signs of the quaternions as it happens."""
    turn, rows = Rotation.random(random_state=int(rng.integers(1000))), []
    for _ in range(n):
        rows.append([*rng.normal(size=3), *(turn.as_quat() * rng.choice([-1.0, 1.0]))])
        axis = rng.normal(size=3)
        turn = turn * Rotation.from_rotvec(rng.uniform(0.0, largest) * axis / np.linalg.norm(axis))
    if closed:
        rows[-1] = [*rows[0][:3], *np.negative(rows[0][3:])]
    return np.array(rows)


def pose_spline(seed, closed=False):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3 if closed else 2, 15))
    while True:  # closing may need half a turn
        try:
            return PoseSpline(random_times(rng, n), random_poses(rng, n, closed=closed), closed)
        except WaypointError:
            assert closed


def derivative(of, t, h):
    return (8.0 * (of(t + h) - of(t - h)) - (of(t + 2 * h) - of(t - 2 * h))) / (12.0 * h)


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("seed", SEEDS)
def test_rates_are_derivatives(seed, closed):
    """Between way-points, by differences of fourth order."""
    spline = pose_spline(seed, closed)
    rng = np.random.default_rng(seed)
    assert isinstance(spline, Trajectory)
    for step in range(len(spline.times) - 1):
        start, end = spline.times[step : step + 2]
        t, h = start + rng.uniform(0.1, 0.9) * (end - start), 1e-3 * (end - start)
        now = spline.at(t)

        def turn(s, now=now):
            return vector_of(spline.at(s).rotation @ now.rotation.T)

        def close(found, wanted):
            return np.abs(found - wanted).max() <= 1e-6 * max(1.0, np.abs(wanted).max())

        assert close(derivative(lambda s: spline.at(s).position, t, h), now.velocity)
        assert close(derivative(lambda s: spline.at(s).velocity, t, h), now.acceleration)
        assert close(derivative(turn, t, h), now.angular_velocity)
        assert close(derivative(lambda s: spline.at(s).angular_velocity, t, h), now.angular_acceleration)


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("seed", SEEDS)
def test_all_is_continuous_at_the_way_points(seed, closed):
    spline = pose_spline(seed, closed)
    inner = spline.times[1:] if closed else spline.times[1:-1]
    for row, t in enumerate(inner, start=1):
        before, after = spline.at(np.nextafter(t, -1.0)), spline.at(t)
        for name in ("position", "velocity", "acceleration", "rotation", "angular_velocity", "angular_acceleration"):
            found, wanted = getattr(before, name), getattr(after, name)
            assert np.allclose(found, wanted, rtol=0.0, atol=1e-11 * max(1.0, np.abs(wanted).max())), name
        assert np.allclose(after.position, spline.poses[row, :3], rtol=0.0, atol=1e-14)
        wanted = Rotation.from_quat(spline.poses[row, 3:]).as_matrix()
        assert np.allclose(after.rotation, wanted, rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("seed", SEEDS)
def test_it_rests_at_both_ends_and_beyond(seed):
    spline = pose_spline(seed)
    for t, row in ((-1.0, 0), (0.0, 0), (spline.duration, -1), (spline.duration + 3.0, -1)):
        at = spline.at(t)
        scale = np.abs(spline.at(0.5 * spline.times[1]).angular_velocity).max() + 1.0
        assert np.allclose(at.position, spline.poses[row, :3], rtol=0.0, atol=1e-13)
        assert np.abs(at.velocity).max() < 1e-12 * scale
        assert np.abs(at.angular_velocity).max() < 1e-12 * scale
        if not 0.0 <= t <= spline.duration:
            assert not at.acceleration.any()
            assert not at.angular_acceleration.any()


@pytest.mark.parametrize("seed", SEEDS)
def test_a_closed_way_goes_round(seed):
    spline = pose_spline(seed, closed=True)
    for t in np.linspace(0.0, spline.duration, 7):
        now, later = spline.at(t), spline.at(t + 3.0 * spline.duration)
        assert np.allclose(now.rotation, later.rotation, rtol=0.0, atol=1e-9)
        assert np.allclose(now.velocity, later.velocity, rtol=0.0, atol=1e-9)
    assert np.abs(spline.at(0.0).angular_velocity).max() > 1e-3


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("closed", [False, True])
def test_about_one_axis_it_is_the_spline_of_the_angle(axis, closed):
    """Over several turns too."""
    rng = np.random.default_rng(3)
    times = random_times(rng, 14)
    steps = rng.uniform(-1.0, 2.8, 13)
    if closed:
        steps += (2.0 * np.pi * round(steps.sum() / (2.0 * np.pi)) - steps.sum()) / 13  # whole turns in all
    angles = np.concatenate([[0.0], np.cumsum(steps)])
    assert abs(angles[-1]) > 2.0 * np.pi
    assert np.abs(np.diff(angles)).max() < np.pi
    # A turn in all is no rotation; the angle less its mean rate is what closes.
    drift = angles[-1] / (times[-1] - times[0]) if closed else 0.0
    linear = drift * (times - times[0])
    other = angles - linear
    if closed:
        other[-1] = other[0]
    angle = CubicSpline(times - times[0], other, bc_type="periodic" if closed else "clamped")
    poses = np.column_stack([np.zeros((14, 3)), Rotation.from_rotvec(angles[:, None] * axis).as_quat()])
    spline = PoseSpline(times, poses, closed)
    for t in np.linspace(0.0, spline.duration, 50)[:-1]:
        at = spline.at(t)
        assert np.allclose(at.rotation, turned((angle(t) + drift * t) * axis), rtol=0.0, atol=1e-12)
        assert np.allclose(at.angular_velocity, (angle(t, 1) + drift) * axis, rtol=0.0, atol=1e-11)
        assert np.allclose(at.angular_acceleration, angle(t, 2) * axis, rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("seed", SEEDS)
def test_with_its_ends_it_is_scipys_spline(seed):
    """scipy iterates to 1e-9; its ends have the mean rate of the first and the last step."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 12))
    times, turns = random_times(rng, n), Rotation.from_quat(random_poses(rng, n, largest=1.0)[:, 3:])
    steps, spans = rotations.steps_between(turns.as_quat()), np.diff(times)
    ends = np.array([steps[:, 0] / spans[0], steps[:, -1] / spans[-1]]).T
    assert np.allclose(
        rotations.rates_at(steps, spans, ends).T, PeerSpline(times, turns)(times, 1), rtol=0.0, atol=1e-7
    )


@pytest.mark.parametrize("seed", SEEDS)
def test_no_axes_are_special(seed):
    """The world turned, and the tool's frame turned, turn the way with them."""
    rng = np.random.default_rng(seed)
    times, poses = random_times(rng, 8), random_poses(rng, 8)
    world, tool = Rotation.random(2, random_state=seed)
    moved = poses.copy()
    moved[:, 3:] = (world * Rotation.from_quat(poses[:, 3:]) * tool).as_quat()
    spline, other = PoseSpline(times, poses), PoseSpline(times, moved)
    turn = world.as_matrix()
    for t in np.linspace(0.0, spline.duration, 11):
        one, two = spline.at(t), other.at(t)
        assert np.allclose(turn @ one.rotation @ tool.as_matrix(), two.rotation, rtol=0.0, atol=1e-12)
        assert np.allclose(turn @ one.angular_velocity, two.angular_velocity, rtol=0.0, atol=1e-9)
        scale = max(1.0, np.abs(one.angular_acceleration).max())
        assert np.allclose(turn @ one.angular_acceleration, two.angular_acceleration, rtol=0.0, atol=1e-10 * scale)


@pytest.mark.parametrize("closed", [False, True])
def test_a_long_way_in_pieces_is_the_way_in_one(monkeypatch, closed):
    rng = np.random.default_rng(1)
    poses = random_poses(rng, 700, largest=1.5, closed=False)
    if closed:
        poses = np.concatenate([poses, poses[::-1]])
    times = random_times(rng, len(poses))
    whole = PoseSpline(times, poses, closed)
    monkeypatch.setattr(rotations, "PIECE", 150)
    pieces = PoseSpline(times, poses, closed)
    for t in np.linspace(0.0, whole.duration, 300):
        one, two = whole.at(t), pieces.at(t)
        assert np.allclose(one.angular_velocity, two.angular_velocity, rtol=0.0, atol=1e-11)
        assert np.allclose(one.angular_acceleration, two.angular_acceleration, rtol=0.0, atol=1e-9)


def test_points_and_joints_are_the_splines_of_their_coordinates():
    rng = np.random.default_rng(0)
    times, values = random_times(rng, 9), rng.normal(size=(9, 6))
    wanted = CubicSpline(times - times[0], values, bc_type="clamped")
    points, joints = PointSpline(times, values[:, :3], given=("x", "z")), JointSpline(times, values)
    for t in np.linspace(0.0, points.duration, 20):
        at, q = points.at(t), joints.at(t)
        assert isinstance(q, JointMotion)
        assert at.given == ("x", "z")
        assert at.rotation is None
        for order, (one, two) in enumerate(((at.position, q.q), (at.velocity, q.v), (at.acceleration, q.a))):
            assert np.allclose(one, wanted(t, order)[:3], rtol=0.0, atol=1e-12)
            assert np.allclose(two, wanted(t, order), rtol=0.0, atol=1e-12)
    for t in (-1.0, points.duration + 1.0):
        assert not np.any([points.at(t).velocity, points.at(t).acceleration])
    assert not np.any([joints.at(-1.0).v, joints.at(-1.0).a, joints.at(99.0).v, joints.at(99.0).a])


def test_poses_in_any_form_and_the_sign_of_quaternions_do_not_matter():
    start = Pose.of([0.1, 0.2, 0.3, 0.0, 0.0, 0.0, 1.0])
    poses = [start, start.moved((0.0, 0.1, 0.0), (0.3, 0.0, 0.0)).matrix, start.moved(turn=(0.0, 0.5, 0.1))]
    spline = PoseSpline([0.0, 1.0, 3.0], poses)
    flipped = np.array(spline.poses)
    flipped[1, 3:] *= -1.0
    other = PoseSpline([0.0, 1.0, 3.0], flipped)
    assert np.array_equal(spline.at(1.7).rotation, other.at(1.7).rotation)
    assert np.array_equal(spline.at(1.7).angular_acceleration, other.at(1.7).angular_acceleration)


def test_a_copy_is_the_same_and_read_only():
    spline = pose_spline(1)
    for other in (pickle.loads(pickle.dumps(spline)), copy.deepcopy(spline)):
        assert np.array_equal(other.at(0.3).rotation, spline.at(0.3).rotation)
        with pytest.raises(ValueError, match="read-only"):
            other.poses[0, 0] = 1.0


UNTURNED = [0.0, 0.0, 0.0, 1.0]


@pytest.mark.parametrize(
    ("make", "about", "waypoint"),
    [
        (lambda: PointSpline([0.0, 1.0, 1.0], np.zeros((3, 3))), "the same as", 2),
        (lambda: PointSpline([0.0, 2.0, 1.0], np.zeros((3, 3))), "before", 2),
        (lambda: PointSpline([0.0, 1.0, 2e9], np.zeros((3, 3))), "the most", 2),
        (lambda: PointSpline([0.0, np.nan, 1.0], np.zeros((3, 3))), "times must be finite", 1),
        (lambda: PointSpline([0.0, 1.0], [[0.0] * 3, [0.0, np.inf, 0.0]]), "points must be finite", 1),
        (lambda: PointSpline([0.0, 1.0], np.eye(3)[:2], closed=True), "comes back", 1),
        (lambda: JointSpline([0.0, 1e-13], [[0.0], [1.0]]), "the same as", 1),
        (lambda: JointSpline([0.0, 1.0], [[0.0], [1e101]]), "finite", 1),
        (lambda: PoseSpline([0.0, 1.0], [[0.0] * 3 + UNTURNED, [0.0] * 6 + [2.0]]), "length 1", 1),
        (lambda: PoseSpline([0.0, 1.0], [[0.0] * 3 + UNTURNED, "there"]), "a pose is", 1),
        (lambda: PoseSpline([0, 1], np.array([[0] * 3 + UNTURNED, [0] * 3 + [1, 0, 0, 0]])), "half a turn", 1),
    ],
)
def test_a_way_point_that_does_not_fit_is_named(make, about, waypoint):
    with pytest.raises(WaypointError, match=about) as caught:
        make()
    assert caught.value.waypoint == waypoint


@pytest.mark.parametrize("count", [2, 3, 5])
def test_a_closed_way_of_one_way_point_stays_there(count):
    spline = PoseSpline(np.arange(count), np.tile([0.1, 0.2, 0.3, 0.6, 0.0, 0.8, 0.0], (count, 1)), closed=True)
    for t in (0.0, 0.4, 7.9):
        at = spline.at(t)
        assert np.allclose(at.position, [0.1, 0.2, 0.3], rtol=0.0, atol=1e-15)
        assert not np.any([at.velocity, at.acceleration, at.angular_velocity, at.angular_acceleration])


@pytest.mark.parametrize(
    ("make", "about"),
    [
        (lambda: PointSpline([0.0], [[0.0] * 3]), "two or more"),
        (lambda: PointSpline([0.0, 1.0], np.zeros((2, 2))), "of 3 numbers"),
        (lambda: PointSpline([0.0, 1.0, 2.0], np.zeros((2, 3))), "as many"),
        (lambda: PoseSpline([0.0, 1.0], [Pose.of([0.0] * 3 + UNTURNED)]), "two or more"),
        (lambda: JointSpline([0.0, 1.0], np.zeros((2, 0))), "numbers"),
    ],
)
def test_wrong_shapes_are_told(make, about):
    with pytest.raises(InputError, match=about):
        make()
