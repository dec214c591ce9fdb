"""Energies balance for any robot: work of the actuators is energy gained, friction and loads; and its rate is power."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kit.led_robots import LED, somewhere
from kit.lively import lively, without_stops

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.errors import ActuationError
from cutjoint.mechanism import Load, kinetic_energy
from cutjoint.motion import JointSpline, Reference
from cutjoint.motion.catalogue import trajectory
from cutjoint.sizing import size
from cutjoint.sizing.chebyshev import CLOSE_UP, POINTS, TO_CLOSE_UP, WEIGHTS, between

EXACT = 1e-9


def test_polynomials_are_integrated_and_interpolated_exactly() -> None:
    rng = np.random.default_rng(1)
    for degree in range(17):
        own = np.polynomial.Polynomial(rng.normal(size=degree + 1))
        assert WEIGHTS @ own(POINTS) == pytest.approx(own.integ()(1.0) - own.integ()(0.0), abs=1e-13)
        assert np.allclose(TO_CLOSE_UP @ own(POINTS), own(CLOSE_UP), atol=1e-12)
        other = rng.uniform(size=5)
        assert np.allclose(between(other) @ own(POINTS), own(other), atol=1e-12)


def slope(values: np.ndarray) -> np.ndarray:
    """Derivatives at the points of the polynomial through values at them, on a piece of length 1."""
    own = np.polynomial.Chebyshev.fit(POINTS, values, 16, domain=[0.0, 1.0])
    return own.deriv()(POINTS)


def balanced(robot: ClosedChain, rng: np.random.Generator) -> None:
    """All that must hold of one robot in a motion about home."""
    unit = robot.length
    weight = max(float(np.abs(robot.terms(robot.home).mass).max()) * 9.81 / unit, 1e-30)
    push = Load(force=0.1 * weight * rng.normal(size=3), moment=0.1 * weight * unit * rng.normal(size=3), axes="link")
    reference = Reference(trajectory("about-home", robot), robot)
    one = size(robot, reference, loads=push).cycles[0]
    assert one.balance < EXACT, one
    work = sum(duty.work for duty in one.duties)
    scale = sum(duty.given + duty.back for duty in one.duties)
    assert abs(work - one.gained - one.lost + one.received) < EXACT * max(scale, 1e-30)
    assert one.lost >= -1e-12 * scale
    course = one.course
    for k in rng.integers(len(course.t), size=3).tolist():
        desired = reference.at(float(course.t[k]))
        effort = robot.inverse_dynamics(desired.posture, course.v[k], course.a[k], [push])
        assert np.allclose(course.effort[k], effort, rtol=0.0, atol=1e-9 * np.abs(course.effort).max())
    for duty, i in zip(one.duties, range(robot.n), strict=True):
        assert abs(duty.effort.value) >= np.abs(course.effort[:, i]).max() * (1.0 - 1e-12)
        assert duty.rms_effort <= abs(duty.effort.value) * (1.0 + 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", LED)
@pytest.mark.parametrize("seed", [0, 1])
def test_drawn_robots_balance(name: str, seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng([seed, *name.encode()])
    robot = somewhere(name, seed, tmp_path, rng).chain
    if robot.idle_is_cyclic:
        balanced(robot, rng)
    else:
        with pytest.raises(ActuationError, match="idle motions"):
            balanced(robot, rng)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fivebar", "omega3", "cpm", "cpm_rotary", "fourbar", "stewart"])
def test_robots_with_friction_springs_and_rotors_balance(name: str) -> None:
    rng = np.random.default_rng([7, *name.encode()])
    plain = cutjoint.load(name)
    robot = plain.rebuilt(without_stops(lively(plain.description, rng, bushings=0)))
    balanced(robot, rng)


@pytest.mark.slow
def test_power_is_the_rate_of_the_energies() -> None:
    """On a piece of the way, with the derivative of the polynomial through the energies."""
    rng = np.random.default_rng(3)
    plain = cutjoint.load("fivebar")
    robot = plain.rebuilt(without_stops(lively(plain.description, rng, bushings=0)))
    reference = Reference(trajectory("about-home", robot), robot)
    from cutjoint.sizing.moving import Mover

    mover, low, width = Mover(robot, 0.0, ()), 0.3, 0.1
    times = low + width * POINTS
    course = mover.course(reference, times)
    states = [reference.at(float(t)) for t in times]
    energy = np.array(
        [robot.potential_energy(one.posture) + kinetic_energy(robot, one.posture, one.v) for one in states]
    )
    rate = slope(energy) / width
    power = course.power.sum(axis=1)
    size_of = np.abs(course.power).sum(axis=1).max()
    assert np.abs(power - rate - course.lost).max() < EXACT * size_of


@pytest.mark.slow
@pytest.mark.parametrize("name", ["omega3", "cpm"])
def test_the_published_model_says_the_same(name: str) -> None:
    """Where paper and chain are the same robot, so are the duties along the beginning of the paper's trajectory."""
    paper = cutjoint.published(name)
    chain = cutjoint.load(name, "lumped")
    way = cutjoint.robots.PUBLISHED[name].trajectory()
    one, other = (size(robot, Reference(way, robot, 0.2)) for robot in (paper, chain))
    for a, b in zip(one.worst, other.worst, strict=True):
        assert a.rms_effort == pytest.approx(b.rms_effort, rel=1e-6)
        assert a.effort.value == pytest.approx(b.effort.value, rel=1e-6)
    assert max(one.balance, other.balance) < EXACT


@pytest.mark.slow
def test_a_spline_of_many_knots_is_the_motion_through_which_it_goes() -> None:
    robot = cutjoint.load("fivebar")
    swing = Reference(trajectory("about-home", robot), robot)
    times = np.linspace(0.0, swing.duration, 801)
    knots = Reference(JointSpline(times, np.array([swing.at(float(t)).q for t in times])), robot)
    smooth, fine = (size(robot, one).worst for one in (swing, knots))
    for one, other in zip(smooth, fine, strict=True):
        assert np.isclose(one.rms_effort, other.rms_effort, rtol=1e-3)
        assert np.isclose(abs(one.effort.value), abs(other.effort.value), rtol=2e-2)
        assert np.isclose(one.given, other.given, rtol=1e-3)
