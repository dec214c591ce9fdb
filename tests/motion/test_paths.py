"""Trajectories: velocity and acceleration are the derivatives of position, whatever the parameters."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cutjoint.errors import InputError
from cutjoint.motion import Circle, Hold, Lissajous, PointToPoint, Trajectory

coordinate = st.floats(-2.0, 2.0)
point = st.tuples(coordinate, coordinate, coordinate)
rate = st.floats(0.2, 8.0)


@st.composite
def planes(draw):
    first = np.add(draw(point), (3.0, 0.0, 0.0))
    first /= np.linalg.norm(first)
    second = np.cross(first, [0.0, 0.6, 0.8])
    return first, second / np.linalg.norm(second)


trajectories = st.one_of(
    st.builds(Hold, point),
    st.builds(PointToPoint, point, point, st.floats(0.3, 3.0)),
    st.builds(lambda c, r, w, p: Circle(c, r, w, *p), point, st.floats(0.01, 2.0), rate, planes()),
    st.builds(Lissajous, point, point, st.tuples(rate, rate, rate), point, st.floats(0.5, 4.0)),
)


@given(trajectories, st.floats(0.0, 1.0))
def test_velocity_and_acceleration_are_derivatives(trajectory, fraction):
    t = fraction * trajectory.duration
    h = 1e-5
    before, now, after = (trajectory.at(t + s) for s in (-h, 0.0, h))
    # The quintic's jerk jumps at its ends, which costs the second difference one order.
    assert np.allclose((after.position - before.position) / (2 * h), now.velocity, atol=1e-5, rtol=0)
    assert np.allclose((after.velocity - before.velocity) / (2 * h), now.acceleration, atol=2e-2, rtol=1e-4)


@given(trajectories)
def test_all_are_trajectories(trajectory):
    assert isinstance(trajectory, Trajectory)
    assert trajectory.duration > 0.0
    assert trajectory.name


@given(point, point, st.floats(0.3, 3.0), st.floats(0.0, 2.0))
def test_point_to_point_rests_at_both_ends(start, goal, duration, beyond):
    way = PointToPoint(start, goal, duration)
    for t, end in ((-beyond, start), (0.0, start), (duration, goal), (duration + beyond, goal)):
        at = way.at(t)
        assert np.allclose(at.position, end, atol=1e-12)
        assert np.abs(at.velocity).max() == 0.0
        assert np.abs(at.acceleration).max() == 0.0


@given(point, st.floats(0.01, 2.0), rate, planes(), st.floats(0.0, 5.0))
def test_circle_keeps_radius_speed_and_period(centre, radius, omega, plane, t):
    circle = Circle(centre, radius, -omega, *plane)
    at, later = circle.at(t), circle.at(t + circle.duration)
    assert np.isclose(np.linalg.norm(at.position - circle.centre), radius)
    assert np.isclose(np.linalg.norm(at.velocity), radius * omega)
    assert np.allclose(at.position, later.position, atol=1e-9)


@pytest.mark.parametrize(
    ("make", "about"),
    [
        (lambda: Hold([0.0, 1.0]), "position"),
        (lambda: Hold([0.0, 1.0, np.nan]), "position"),
        (lambda: Hold([0.0, 0.0, 0.0], duration=0.0), "duration"),
        (lambda: PointToPoint([0.0] * 3, [1.0] * 3, -1.0), "duration"),
        (lambda: PointToPoint([0.0] * 3, "far", 1.0), "goal"),
        (lambda: Circle([0.0] * 3, 0.0, 1.0), "radius"),
        (lambda: Circle([0.0] * 3, 1.0, 0.0), "rate"),
        (lambda: Circle([0.0] * 3, 1.0, 1.0, [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]), "orthogonal"),
        (lambda: Lissajous([0.0] * 3, [0.0] * 3, [0.0] * 3, [0.0] * 3, np.inf), "duration"),
    ],
)
def test_bad_parameters_name_themselves(make, about):
    with pytest.raises(InputError, match=about):
        make()


def test_motion_is_read_only():
    at = Hold([0.0, 1.0, 2.0]).at(0.0)
    with pytest.raises(ValueError, match="read-only"):
        at.position[0] = 5.0
