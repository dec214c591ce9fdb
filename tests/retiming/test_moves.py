"""Moves from point to point: closed forms of their times, limits at instants of one's own, and refusals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kit.led_robots import somewhere
from kit.physics import with_sized_physics
from kit.small import write

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError, LimitError, RetimingError
from cutjoint.motion import Reference, motion_from_file
from cutjoint.retiming import limits_of, quickest_moves
from cutjoint.retiming.jerk_limited import quickest_move


def shortest(d: float, v: float, a: float, j: float) -> float:
    """The time from rest to rest over a distance: seven segments, or fewer."""
    ramp = 2.0 * np.sqrt(v / j) if v * j < a * a else a / j + v / a
    if d >= v * ramp:
        return ramp + d / v
    if d >= 2.0 * a**3 / j**2:
        top = 0.5 * (np.sqrt(a**4 / j**2 + 4.0 * a * d) - a * a / j)
        return 2.0 * (a / j + top / a)
    return 4.0 * np.cbrt(d / (2.0 * j))


@pytest.mark.parametrize("seed", range(4))
def test_a_move_takes_the_time_of_its_slowest_actuator(seed: int) -> None:
    """And the spline through its switches is the motion itself, whatever the sizes of the limits."""
    ruckig = pytest.importorskip("ruckig")
    rng, robot = np.random.default_rng(seed), cutjoint.load("omega3")
    for _ in range(6):
        v, a, j = 10.0 ** rng.uniform([-1.0, 0.0, 1.0], [1.0, 2.0, 4.0], (3, 3)).T
        start, end = rng.uniform(-1.0, 1.0, (2, 3))
        limits = limits_of(robot, speed=v, acceleration=a, jerk=j)
        times, rows = quickest_move(ruckig, start, end, limits)
        each = [shortest(*one) for one in zip(np.abs(end - start), v, a, j, strict=True)]
        assert times[-1] == pytest.approx(max(each), rel=1e-9)
        assert (rows[0] == start).all()
        assert (rows[-1] == end).all()
        motion = cutjoint.motion.JointSpline(times, rows)
        t = np.linspace(0.0, times[-1], 400)
        at = [motion.at(float(one)) for one in t]
        assert (np.abs([one.v for one in at]) <= v * (1.0 + 1e-4)).all()
        assert (np.abs([one.a for one in at]) <= a * (1.0 + 1e-4)).all()
        steps = np.abs(np.diff([one.a for one in at], axis=0)) / t[1]
        assert (steps <= j * (1.0 + 1e-3)).all()


def test_a_lifted_mass_goes_slower_where_its_effort_is_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """effort = m (g + a): the largest acceleration of a slower move is what the effort leaves."""
    pytest.importorskip("ruckig")
    monkeypatch.setattr("cutjoint.retiming.moves.LOOKS", 12)
    robot = ClosedChain(cutjoint.load_description(write("slider", tmp_path)))
    mass, weight = 2.0, 2.0 * 9.81
    given = {"speed": np.inf, "acceleration": 8.0, "jerk": 100.0}
    free = quickest_moves(robot, [[0.4], robot.home.q], limits_of(robot, effort=1e3, **given))
    assert free.slowed.tolist() == [1.0, 1.0]
    assert free.closed
    assert np.diff(free.stops) == pytest.approx([shortest(0.4, 1e9, 8.0, 100.0)] * 2, rel=1e-9)
    for effort in (25.0,):
        found = quickest_moves(robot, [[0.4]], limits_of(robot, effort=effort, **given))
        by = np.sqrt(mass * 8.0 / (effort - weight))
        assert found.slowed[0] == pytest.approx(max(by, 1.0), rel=2e-3)
        assert found.duration == pytest.approx(found.slowed[0] * free.stops[1], rel=1e-9)
    with pytest.raises(RetimingError, match=r"slide is 19\.6[0-9]* N nearly at rest") as none:
        quickest_moves(robot, [[0.4]], limits_of(robot, effort=19.0, **given))
    assert none.value.limits == ("effort of slide",)
    with pytest.raises(LimitError):
        quickest_moves(robot, [[1.2]], limits_of(robot, effort=1e3, **given))


def test_what_is_no_move_is_refused() -> None:
    pytest.importorskip("ruckig")
    robot = cutjoint.load("fourbar")
    limits = limits_of(robot, acceleration=9.0, jerk=90.0)
    for points in ([], [robot.home.q], [[0.1, 0.2]], [[np.nan]], ["here"], 3.0, [[0.4], [0.4]]):
        with pytest.raises(InputError):
            quickest_moves(robot, points, limits)  # type: ignore[arg-type]
    for given, named in (({"acceleration": 9.0}, "jerk"), ({"jerk": 9.0, "effort": 9.0}, "acceleration")):
        with pytest.raises(InputError, match=f"limit of {named} of every actuator; crank has none"):
            quickest_moves(robot, [[0.4]], limits_of(robot, **given))  # type: ignore[arg-type]
    with pytest.raises(InputError, match="another robot"):
        quickest_moves(robot, [[0.4]], limits_of(cutjoint.load("fivebar")))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("name", ["fivebar", "stewart", "delta"])
def test_limits_are_kept_at_any_instant_by_any_robot(
    name: str, seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of any shape, size and mounting, with joints that rub; it stands in the points, and the file is the motion."""
    pytest.importorskip("ruckig")
    monkeypatch.setattr("cutjoint.retiming.moves.LOOKS", 50)
    rng = np.random.default_rng([seed, *name.encode()])
    standing = somewhere(name, seed, tmp_path, rng)
    description = standing.description
    if seed:
        weight = sum(one.inertial.mass for one in description.links if one.inertial is not None) * 9.81
        description = with_sized_physics(description, rng, standing.length, weight)
    robot = ClosedChain(description)
    unit = np.array([1.0 if one.kind == "rotation" else standing.length for one in robot.actuators])
    pace = np.sqrt(standing.length / 9.81)
    points = []
    for _ in range(2):
        points.append(robot.close(robot.home.q + 0.05 * unit * rng.uniform(-1.0, 1.0, robot.n), limits="ignore"))
    quick = {"speed": unit / pace, "acceleration": 4.0 * unit / pace**2, "jerk": 80.0 * unit / pace**3}
    try:
        free = quickest_moves(robot, points, limits_of(robot, effort=np.inf, **quick))
    except LimitError:
        pytest.skip("a joint of this shape has no room for these points")
    reference = Reference(free.trajectory, robot)
    at = [reference.at(float(t)) for t in np.linspace(0.0, free.duration, 41)]
    still = np.zeros(robot.n)
    held = np.max([np.abs(robot.inverse_dynamics(one.posture, still, still)) for one in at], axis=0)
    efforts = np.array([robot.inverse_dynamics(one.posture, one.v, one.a) for one in at])
    spent = np.abs(efforts * [one.v for one in at]).max(axis=0)
    effort = np.maximum(1.2 * held, 0.7 * np.abs(efforts).max(axis=0))
    try:
        found = quickest_moves(robot, points, limits_of(robot, effort=effort, power=0.6 * spent, **quick))
    except RetimingError:  # dry friction alone may need more than that
        if not seed:
            raise
        return
    assert found.slowed.max() > 1.001
    assert max(one.part for one in found.peaks) > 0.999
    reference = Reference(found.trajectory, robot)
    for t in rng.uniform(0.0, found.duration, 80).tolist():
        one = reference.at(t)
        asked = robot.inverse_dynamics(one.posture, one.v, one.a)
        parts = [asked / effort, asked * one.v / (0.6 * spent), one.v / quick["speed"], one.a / quick["acceleration"]]
        assert np.abs(parts).max() <= 1.001
        assert np.max(np.array(robot.gap(one.posture)) / (standing.length, 1.0)) < 1e-9
    for k, point in enumerate(points, start=1):
        there = found.trajectory.at(float(found.stops[k]))
        assert np.allclose(there.q, point.q, atol=1e-12 * standing.length)
        assert np.abs(there.v / unit).max() * pace < 1e-8
        assert np.abs(there.a / unit).max() * pace**2 < 1e-4
    again = motion_from_file(found.save(tmp_path / "moves.csv"), robot)
    for t in rng.uniform(0.0, found.duration, 20).tolist():
        assert (again.at(t).a == found.trajectory.at(t).a).all()


@pytest.mark.slow
def test_another_branch_is_not_taken_for_the_wanted_one() -> None:
    pytest.importorskip("ruckig")
    robot = cutjoint.load("fivebar")
    limits = limits_of(robot, acceleration=9.0, jerk=90.0)
    _, other = robot.assembly_modes(robot.close(robot.home.q + 0.05))
    with pytest.raises(RetimingError, match="closed in another way"):
        quickest_moves(robot, [other], limits)
