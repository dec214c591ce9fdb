"""Retimed motions of whole robots: limits at instants of one's own, closed forms, another program, and laws."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from kit.led_robots import LED, somewhere
from kit.physics import with_sized_physics
from kit.small import write

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError, RetimingError, UnreachableError
from cutjoint.motion import Circle, Hold, JointMotion, JointSpline, PointToPoint, Reference, motion_from_file
from cutjoint.motion.catalogue import trajectory
from cutjoint.retiming import Retimed, limits_of, retime


class Wave:
    """Actuators from rest to rest along a line with a bend, at its own speed."""

    name = "wave"

    def __init__(self, start: np.ndarray, by: np.ndarray, bend: np.ndarray, duration: float = 1.0) -> None:
        self.start, self.by, self.bend, self.duration = start, by, bend, duration

    def at(self, t: float) -> JointMotion:
        """Along 3 p^2 - 2 p^3."""
        p = min(max(t / self.duration, 0.0), 1.0)
        s, v, a = 3 * p**2 - 2 * p**3, 6 * p * (1 - p) / self.duration, (6 - 12 * p) / self.duration**2
        w = np.pi * s
        q = self.start + s * self.by + (1.0 - np.cos(w)) * self.bend
        along = self.by + np.pi * np.sin(w) * self.bend
        return JointMotion(q, v * along, a * along + v * v * np.pi**2 * np.cos(w) * self.bend)


def used(robot: ClosedChain, found: Retimed, rng: np.random.Generator, count: int = 300) -> float:
    """The largest part of a limit at random instants."""
    reference, most = Reference(found.trajectory, robot), 0.0
    limits = found.limits
    for t in rng.uniform(0.0, found.duration, count):
        at = reference.at(float(t))
        effort = robot.inverse_dynamics(at.posture, at.v, at.a)
        parts = [effort / limits.effort, at.v / limits.speed, at.a / limits.acceleration, effort * at.v / limits.power]
        most = max(most, float(np.abs(parts).max()))
    return most


def needed(robot: ClosedChain, reference: Reference) -> tuple[np.ndarray, np.ndarray]:
    """The largest efforts at rest and in motion along a trajectory, shape (n,)."""
    at = [reference.at(float(t)) for t in np.linspace(0.0, reference.duration, 60)]
    still = np.zeros(robot.n)
    held = np.max([np.abs(robot.inverse_dynamics(one.posture, still, still)) for one in at], axis=0)
    return held, np.max([np.abs(robot.inverse_dynamics(one.posture, one.v, one.a)) for one in at], axis=0)


@pytest.mark.slow
def test_a_mass_lifted_takes_the_time_of_the_closed_form(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cutjoint.retiming.finding.CHECKS", 100)
    robot = ClosedChain(cutjoint.load_description(write("slider", tmp_path)))
    weight, mass, far = 2.0 * 9.81, 2.0, 0.4
    way = JointSpline([0.0, 1.0], np.array([[0.0], [far]]))
    found = retime(robot, way, limits_of(robot, effort=50.0, speed=np.inf))
    up, down = (50.0 - weight) / mass, (50.0 + weight) / mass
    wanted = np.sqrt(2.0 * far * (1.0 / up + 1.0 / down))
    assert found.shortest == pytest.approx(wanted, rel=1e-3)
    assert wanted <= found.duration <= 1.01 * wanted
    with pytest.raises(RetimingError, match=r"hold the robot still.*slide needs 19\.6[0-9]* N") as none:
        retime(robot, way, limits_of(robot, effort=19.0))
    assert none.value.limits == ("effort of slide",)
    with pytest.raises(InputError, match="does not move"):
        retime(robot, Hold.at_home(robot, 1.0), limits_of(robot))
    with pytest.raises(InputError, match="cannot go round"):
        retime(robot, way, limits_of(robot), goes_round=True)
    with pytest.raises(InputError, match="another robot"):
        retime(robot, way, limits_of(cutjoint.load("fivebar")))
    for ramp in (0.0, -1.0, np.nan):
        with pytest.raises(InputError, match="ramp"):
            retime(robot, way, limits_of(robot), ramp=ramp)


@pytest.mark.slow
def test_the_circle_of_the_cpm_at_60_n() -> None:
    robot = cutjoint.load("cpm")
    path = cutjoint.robots.PUBLISHED["cpm"].trajectory()
    found = retime(robot, path, limits_of(robot, effort=60.0))
    assert found.duration <= 0.90
    assert used(robot, found, np.random.default_rng(0), 2000) <= 1.001
    reference = Reference(found.trajectory, robot)
    for t in np.linspace(0.0, found.duration, 200):
        off = reference.at(float(t)).tool.position - np.array([0.425, 0.425, 0.3])
        assert np.linalg.norm(off) == pytest.approx(0.175, abs=1e-7)
        assert off[2] == pytest.approx(0.0, abs=1e-7)
    quicker = retime(robot, path, limits_of(robot, effort=60.0), goes_round=True)
    assert quicker.duration < found.duration
    assert used(robot, quicker, np.random.default_rng(1), 500) <= 1.001
    ends = quicker.trajectory.at(0.0), quicker.trajectory.at(quicker.duration * (1.0 - 1e-12))
    assert np.allclose(ends[0].v, ends[1].v, atol=1e-6)
    assert np.linalg.norm(ends[0].v) > 0.1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seed"), [("fivebar", 0), ("fivebar", 1), ("stewart", 1), ("spherical_3rrr", 0), ("delta", 1)]
)
def test_limits_are_kept_at_any_instant_by_any_robot(
    name: str, seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of any shape, size and mounting, along ways that bend, with limits of effort, speed and power, and for seed 1
    with joints that rub; and the file is the same motion."""
    assert name in LED
    monkeypatch.setattr("cutjoint.retiming.finding.CHECKS", 300)
    monkeypatch.setattr("cutjoint.retiming.finding.NODES", 120)
    monkeypatch.setattr("cutjoint.retiming.path.LEAST_NODES", 60)
    monkeypatch.setattr("cutjoint.retiming.finding.LOST", 2e-2)
    rng = np.random.default_rng([seed, *name.encode()])
    standing = somewhere(name, seed, tmp_path, rng)
    description = standing.description
    if seed:
        weight = sum(one.inertial.mass for one in description.links if one.inertial is not None) * 9.81
        description = with_sized_physics(description, rng, standing.length, weight)
    robot = ClosedChain(description)
    unit = np.array([1.0 if one.kind == "rotation" else standing.length for one in robot.actuators])
    by, bend = (0.04 * unit * rng.uniform(-1.0, 1.0, robot.n) for _ in range(2))
    way = Wave(robot.home.q, by, bend, np.sqrt(standing.length / 9.81))
    reference = Reference(way, robot, limits="ignore")
    held, moved = needed(robot, reference)
    effort = 1.5 * held + moved
    speeds = np.max([np.abs(reference.at(float(t)).v) for t in np.linspace(0.0, way.duration, 20)], axis=0)
    limits = limits_of(robot, effort=effort, speed=4.0 * speeds, power=2.0 * effort * speeds)
    found = retime(robot, way, limits)
    assert used(robot, found, rng, 120) <= 1.001
    assert found.shortest <= found.duration * (1.0 + 1e-9)
    assert max(one.part for one in found.peaks) >= 0.99
    for end in (0.0, found.duration):
        assert np.abs(found.trajectory.at(end).v / unit).max() <= 1e-9 * np.abs(speeds / unit).max()
    # it keeps to the way: nearest places of a fine walk along it
    fine = np.array([way.at(float(t)).q for t in np.linspace(0.0, way.duration, 4000)]) / unit
    for t in rng.uniform(0.0, found.duration, 20):
        off = np.linalg.norm(fine - found.trajectory.at(float(t)).q / unit, axis=1).min()
        assert off <= 1e-3 * np.linalg.norm(fine[-1] - fine[0])
    again = motion_from_file(found.save(tmp_path / "motion.csv"), robot)
    for t in rng.uniform(0.0, found.duration, 20):
        one, two = found.trajectory.at(float(t)), again.at(float(t))
        assert (one.q == two.q).all()
        assert (one.a == two.a).all()


@pytest.mark.slow
def test_only_the_way_counts_and_time_scales_with_the_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = cutjoint.load("fivebar")
    by, bend = np.array([0.3, -0.2]), np.array([0.1, 0.2])
    times = {}
    monkeypatch.setattr("cutjoint.retiming.finding.CHECKS", 200)
    for duration, factor in ((1.0, 1.0), (7.0, 4.0)):
        limits = limits_of(robot, acceleration=10.0 * factor, effort=np.inf, speed=np.inf)
        times[duration, factor] = retime(robot, Wave(robot.home.q, by, bend, duration), limits).duration
    assert times[7.0, 4.0] == pytest.approx(0.5 * times[1.0, 1.0], rel=1e-3)
    back = Wave(robot.home.q + by + 2.0 * bend, -by - 2.0 * bend, 0.0 * bend)
    there = Wave(robot.home.q, by + 2.0 * bend, 0.0 * bend)
    limits = limits_of(robot, acceleration=[10.0, 3.0], effort=np.inf)
    one, two = (retime(robot, way, limits).duration for way in (there, back))
    assert one == pytest.approx(two, rel=1e-3)


@pytest.mark.slow
def test_jerk_and_the_tool_are_limited() -> None:
    robot = cutjoint.load("omega3")
    path = Circle.through_home(robot, 0.04, 1.0)
    found = retime(robot, path, limits_of(robot, acceleration=30.0, jerk=2000.0, tool_speed=0.6, tool_acceleration=5.0))
    rng, step = np.random.default_rng(2), 1e-6
    reference = Reference(found.trajectory, robot)
    for t in rng.uniform(step, found.duration - step, 200).tolist():
        one, two = reference.at(t), reference.at(t + step)
        assert np.abs(two.a - one.a).max() / step <= 2000.0 * 1.002
        assert np.linalg.norm(one.tool.velocity) <= 0.6 * 1.001
        assert np.linalg.norm(one.tool.acceleration) <= 5.0 * 1.001
    assert found.gap < 0.1


@pytest.mark.slow
def test_power_is_limited_and_takes_time() -> None:
    robot = cutjoint.load("cpm")
    path = PointToPoint.from_home(robot, 0.1, 0.05, 0.1, 1.0)
    free, bounded = (
        retime(robot, path, limits_of(robot, effort=80.0, power=power))
        for power in (np.inf, np.array([30.0, 30.0, 40.0]))
    )
    assert bounded.duration > 1.01 * free.duration
    assert used(robot, bounded, np.random.default_rng(0)) <= 1.001
    assert max(one.part for one in bounded.peaks if one.quantity.startswith("power")) > 0.99


@pytest.mark.slow
def test_corners_are_stops_and_the_workspace_is_kept() -> None:
    robot = cutjoint.load("omega3")
    found = retime(robot, trajectory("about-home", robot), limits_of(robot, effort=3.0))
    assert any("1 corner," in one for one in found.told)
    speeds = np.abs([found.trajectory.at(float(t)).v for t in found.trajectory.times]).max(axis=1)
    middle = speeds[len(speeds) // 4 : -len(speeds) // 4]
    assert middle.min() <= 1e-6 * speeds.max()
    with pytest.raises(UnreachableError, match="leaves the workspace"):
        retime(robot, PointToPoint.from_home(robot, 5.0, 0.0, 0.0, 1.0), limits_of(robot, effort=3.0))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "limit"), [("cpm", 60.0), ("omega3", 1.0)])
def test_toppra_finds_the_same_shortest_time(name: str, limit: float) -> None:
    """Another program, another parameter of the way (the old time, in tens of seconds: the tolerances of its solver are
    absolute, and in seconds it finds no motion of the Omega-3), derivatives of the trajectory itself."""
    ta = pytest.importorskip("toppra")
    ta.setup_logging("ERROR")
    robot = cutjoint.load(name)
    path = cutjoint.robots.PUBLISHED[name].trajectory()
    reference, steps, unit = Reference(path, robot), 300, 10.0
    near = [reference.at(0.0).posture]

    class Path(ta.interpolator.AbstractGeometricPath):  # type: ignore[misc, name-defined]
        dof, path_interval, waypoints = robot.n, np.array([0.0, reference.duration / unit]), None

        def __call__(self, s: np.ndarray, order: int = 0) -> np.ndarray:
            looks = [reference.at(float(np.clip(unit * one, 0.0, reference.duration))) for one in np.atleast_1d(s)]
            return np.array([(one.q, unit * one.v, unit**2 * one.a)[order] for one in looks])

    def inverse(q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        near[0] = robot.close(q, near[0])
        return robot.inverse_dynamics(near[0], v, a)

    scheme = ta.constraint.DiscretizationType.Interpolation
    bounds = np.tile([-limit, limit], (robot.n, 1))
    effort = ta.constraint.JointTorqueConstraint(inverse, bounds, np.zeros(robot.n), discretization_scheme=scheme)
    grid = np.linspace(0.0, reference.duration / unit, steps + 1)
    _, speeds, _ = ta.algorithm.TOPPRA(
        [effort], Path(), gridpoints=grid, solver_wrapper="seidel"
    ).compute_parameterization(0, 0)
    theirs = float(np.sum(2.0 * np.diff(grid) / (speeds[1:] + speeds[:-1])))
    found = retime(robot, path, limits_of(robot, effort=limit, speed=np.inf))
    assert found.shortest == pytest.approx(theirs, rel=5e-3)
    assert found.duration <= 1.01 * theirs
