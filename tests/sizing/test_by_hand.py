"""Sizing against mechanics by hand: pendulum, slider, slider-crank, and the five-bar linkage by its own equations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from kit.quickly import few
from kit.small import write
from oracles.fivebar import FiveBar

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.motion import JointMotion, JointSine, PointToPoint, Reference, Trapezoidal
from cutjoint.sizing import Sizing, size
from cutjoint.sizing.breaks import breaks_of

G = 9.81
EXACT = 1e-9
PARTS = 8
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Turning:
    """One joint that turns evenly."""

    start: float
    rate: float
    duration: float
    name: str = "turning"

    def at(self, t: float) -> JointMotion:
        return JointMotion(np.array([self.start + self.rate * t]), np.array([self.rate]), np.zeros(1))


def small(name: str, folder: Path, **physics: float) -> ClosedChain:
    robot = cutjoint.load(write(name, folder / name))
    if not physics:
        return robot
    joints = tuple(
        replace(one, physics=cutjoint.description.JointPhysics(**physics)) for one in robot.description.joints
    )
    return robot.rebuilt(replace(robot.description, joints=joints))


def root_mean_square(function: Callable[[float], float], duration: float) -> float:
    """By a rule of its own: Gauss on even parts."""
    x, w = np.polynomial.legendre.leggauss(20)
    total = 0.0
    for k in range(PARTS):
        times = (k + 0.5 * (x + 1.0)) * duration / PARTS
        total += 0.5 * duration / PARTS * float(w @ np.array([function(float(t)) ** 2 for t in times]))
    return float(np.sqrt(total / duration))


@pytest.mark.slow
def test_a_pendulum_that_swings(tmp_path: Path) -> None:
    robot = small("pendulum", tmp_path, rotor=0.002, gear=5.0)
    wide, rate = 1.2, 2.0 * np.pi
    one = size(robot, Reference(JointSine([0.0], [wide], [rate], [0.0], 1.0), robot))
    duty = one.worst[0]
    inertia, lever = 0.1 + 2.0 * 0.25 + 0.05, 2.0 * G * 0.5

    def effort(t: float) -> float:
        q = wide * np.sin(rate * t)
        return float(-inertia * rate**2 * q + lever * np.sin(q))

    assert duty.rms_effort == pytest.approx(root_mean_square(effort, 1.0), rel=EXACT)
    times = np.linspace(0.0, 1.0, 2001)
    assert abs(duty.effort.value) == pytest.approx(max(abs(effort(t)) for t in times), rel=1e-5)
    assert abs(duty.effort.value) >= max(abs(effort(t)) for t in times) * (1.0 - EXACT)
    assert abs(duty.holding.value) == pytest.approx(lever * np.sin(wide), rel=EXACT)
    assert abs(duty.speed.value) == pytest.approx(wide * rate, rel=EXACT)
    assert duty.rms_speed == pytest.approx(wide * rate / np.sqrt(2.0), rel=EXACT)
    assert duty.work == pytest.approx(0.0, abs=EXACT * duty.given)
    bare = one.cycles[0].course
    assert np.allclose(bare.effort - bare.bare, 0.05 * bare.a, atol=1e-12)


@pytest.mark.parametrize("ramp", few([1.0 / 3.0, 0.21, 0.5], 1.0 / 3.0))
def test_a_weight_lifted_with_constant_acceleration(ramp: float, tmp_path: Path) -> None:
    """Jumps of the acceleration are met exactly: the mean square of m (g + a) in the parts of the time."""
    robot = small("slider", tmp_path)
    start, span = np.array(robot.tool(robot.home).position), 2.1 * ramp
    move = Trapezoidal(start, start + UP * 0.4, span, ramp=ramp)
    duty = size(robot, Reference(move, robot)).worst[0]
    a = 0.4 / (span * span * ramp * (1.0 - ramp))
    assert duty.effort.value == pytest.approx(2.0 * (G + a), rel=EXACT)
    assert duty.rms_effort == pytest.approx(2.0 * np.sqrt(G**2 + 2.0 * ramp * a**2), rel=EXACT)
    assert duty.work == pytest.approx(2.0 * G * 0.4, rel=EXACT)
    top = 0.4 / (span * (1.0 - ramp))
    assert duty.power.value == pytest.approx(2.0 * (G + a) * top, rel=EXACT)


@pytest.mark.slow
def test_friction_takes_what_it_must(tmp_path: Path) -> None:
    robot = small("slider", tmp_path, damping=3.0, friction=4.0, friction_speed=0.0)
    start = np.array(robot.tool(robot.home).position)
    down = Trapezoidal(start, start - UP * 0.5, 0.8, ramp=0.25)
    cycle = size(robot, Reference(down, robot)).cycles[0]
    top = 0.5 / (0.75 * 0.8)
    lost = 4.0 * 0.5 + 3.0 * top**2 * 0.8 * (1.0 - 4.0 / 3.0 * 0.25)
    assert cycle.lost == pytest.approx(lost, rel=EXACT)
    assert cycle.gained == pytest.approx(-2.0 * G * 0.5, rel=EXACT)
    assert cycle.duties[0].work == pytest.approx(lost - 2.0 * G * 0.5, rel=EXACT)
    assert cycle.balance < EXACT
    pushed = size(robot, Reference(down, robot), loads=cutjoint.Load(force=[0.0, 0.0, -5.0])).cycles[0]
    assert pushed.received == pytest.approx(2.5, rel=EXACT)
    assert pushed.duties[0].work == pytest.approx(cycle.duties[0].work - 2.5, rel=EXACT)
    carrying = size(robot, Reference(down, robot), payload=1.5).cycles[0]
    assert carrying.gained == pytest.approx(-3.5 * G * 0.5, rel=EXACT)


@dataclass(frozen=True)
class Slurred:
    """A joint whose velocity is not the derivative of its position."""

    duration: float = 1.0
    name: str = "slurred"

    def at(self, t: float) -> JointMotion:
        return JointMotion(np.array([0.3 * np.sin(t)]), np.array([0.31 * np.cos(t)]), np.array([-0.3 * np.sin(t)]))


@pytest.mark.slow
def test_a_motion_whose_velocity_is_wrong_is_told(tmp_path: Path) -> None:
    robot = small("pendulum", tmp_path)
    with pytest.warns(UserWarning, match="'slurred': the work of the actuators misses the energies by"):
        size(robot, Reference(Slurred(), robot))


@dataclass(frozen=True)
class Jerky:
    """One joint whose acceleration jumps at times that nobody tells."""

    jumps: tuple[float, ...]
    sizes: tuple[float, ...]
    duration: float = 1.0
    name: str = "jerky"

    def at(self, t: float) -> JointMotion:
        since = [max(t - one, 0.0) for one in self.jumps]
        q = sum(0.5 * size * one * one for size, one in zip(self.sizes, since, strict=True))
        v = sum(size * one for size, one in zip(self.sizes, since, strict=True))
        a = sum(size * (t >= one) for size, one in zip(self.sizes, self.jumps, strict=True))
        return JointMotion(np.array([0.01 * q]), np.array([0.01 * v]), np.array([0.01 * a]))


@pytest.mark.parametrize("seed", range(4))
def test_jumps_are_found_where_they_are(seed: int) -> None:
    rng = np.random.default_rng(seed)
    times = np.sort(rng.uniform(0.05, 0.95, 5))
    way = Jerky(tuple(times.tolist()), tuple(rng.normal(size=5).tolist()))
    found = breaks_of(way, 1.0)
    assert all(np.abs(found - one).min() < 1e-12 for one in times)
    assert len(found) <= 8
    assert len(breaks_of(JointSine([0.0], [1.0], [6.0], [0.3], 1.0), 1.0)) == 0


@pytest.mark.slow
def test_a_quick_oscillation_is_resolved(tmp_path: Path) -> None:
    robot, rate = small("slider", tmp_path), 2.0 * np.pi * 23.0
    shake = JointSine([0.0], [0.01], [rate], [0.0], 1.0)
    duty = size(robot, Reference(shake, robot)).worst[0]
    assert duty.rms_effort == pytest.approx(2.0 * np.sqrt(G**2 + 0.5 * (0.01 * rate**2) ** 2), rel=EXACT)
    assert abs(duty.effort.value) == pytest.approx(2.0 * (G + 0.01 * rate**2), rel=EXACT)
    assert duty.rms_speed == pytest.approx(0.01 * rate / np.sqrt(2.0), rel=EXACT)
    assert duty.work == pytest.approx(0.0, abs=EXACT * duty.given)


# ---- slider-crank --------------------------------------------------------------------------------------------------

R, L, X1 = 0.12, 0.4, 0.05
M1, M2, M3, J1, J2 = 0.9, 0.6, 1.3, 0.004, 0.011
OUT = R * np.cos(0.7) + np.sqrt(L**2 - (R * np.sin(0.7)) ** 2)
CRANK = f"""<robot name="crank"><link name="base"/>
<link name="crank"><inertial><origin xyz="{X1} 0 0"/><mass value="{M1}"/>
<inertia ixx="{J1}" iyy="{J1}" izz="{J1}" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="rod"><inertial><origin xyz="{L / 2} 0 0"/><mass value="{M2}"/>
<inertia ixx="{J2}" iyy="{J2}" izz="{J2}" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="block"><inertial><mass value="{M3}"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="drive" type="continuous"><parent link="base"/><child link="crank"/><axis xyz="0 -1 0"/></joint>
<joint name="pin" type="continuous"><parent link="crank"/><child link="rod"/><origin xyz="{R} 0 0"/>
<axis xyz="0 -1 0"/></joint>
<joint name="slide" type="prismatic"><parent link="base"/><child link="block"/><axis xyz="1 0 0"/>
<limit lower="-2" upper="2" effort="10" velocity="1"/></joint></robot>"""
LOOPS = f"""schema = 1
name = "crank"
urdf = "robot.urdf"
actuators = ["drive"]
[tool]
frame = {{ link = "block" }}
[[cut]]
name = "gudgeon"
type = "revolute"
frames = [{{ link = "rod", xyz = [{L}, 0.0, 0.0], rpy = [-1.5707963267948966, 0.0, 0.0] }},
  {{ link = "block", rpy = [-1.5707963267948966, 0.0, 0.0] }}]
[home.start]
actuated = {{ drive = 0.7 }}
passive = {{ pin = {-0.7 - np.arcsin(R * np.sin(0.7) / L)}, slide = {OUT} }}
"""


def slider_crank(folder: Path) -> ClosedChain:
    (folder / "robot.urdf").write_text(CRANK, encoding="utf-8")
    (folder / "loops.toml").write_text(LOOPS, encoding="utf-8")
    return cutjoint.load(folder)


def inertia_of(angle: complex) -> complex:
    """Generalised inertia of the slider-crank: twice its kinetic energy at a speed of the crank of 1 rad/s."""
    s, c = np.sin(angle), np.cos(angle)
    root = np.sqrt(L * L - R * R * s * s)
    swing = -R * c / root  # rate of the rod's angle, whose sine is -R s / L
    slide = -R * s - R * R * s * c / root
    # the middle of the rod is between pin and gudgeon
    middle = ((-R * s + slide) / 2.0) ** 2 + (R * c / 2.0) ** 2
    return J1 + M1 * X1**2 + M2 * middle + J2 * swing**2 + M3 * slide**2


def crank_effort(angle: float, v: float, a: float) -> float:
    """Lagrange: M a + M' v^2 / 2 + V', derivatives by complex steps."""
    slope = inertia_of(angle + 1e-40j).imag / 1e-40
    weight = G * (M1 * X1 + M2 * R / 2.0) * np.cos(angle)
    return float(inertia_of(angle).real * a + 0.5 * slope * v * v + weight)


def test_a_slider_crank_at_even_speed(tmp_path: Path) -> None:
    robot, rate = slider_crank(tmp_path), 15.0
    span = 2.0 * np.pi / rate
    found = size(robot, Reference(Turning(0.7, rate, span), robot))
    course, duty = found.cycles[0].course, found.worst[0]
    by_hand = np.array([crank_effort(0.7 + rate * t, rate, 0.0) for t in course.t])
    assert np.allclose(course.effort[:, 0], by_hand, rtol=0.0, atol=EXACT * np.abs(by_hand).max())
    assert duty.rms_effort == pytest.approx(
        root_mean_square(lambda t: crank_effort(0.7 + rate * t, rate, 0.0), span), rel=EXACT
    )
    times = np.linspace(0.0, span, 1001)
    sizes = [abs(crank_effort(0.7 + rate * t, rate, 0.0)) for t in times]
    assert max(sizes) * (1.0 - EXACT) <= abs(duty.effort.value) <= max(sizes) * (1.0 + 1e-4)
    assert duty.work == pytest.approx(0.0, abs=EXACT * duty.given)
    assert found.balance < EXACT


@pytest.mark.slow
def test_a_five_bar_linkage() -> None:
    robot, oracle = cutjoint.load("fivebar"), FiveBar()
    start = np.array(robot.tool(robot.home).position)
    move = PointToPoint(start, start + np.array([0.05, 0.0, -0.04]), 0.3)
    reference = Reference(move, robot)
    found: Sizing = size(robot, reference)
    course = found.cycles[0].course
    by_hand = np.array([oracle.inverse_dynamics(*one) for one in zip(course.q, course.v, course.a, strict=True)])
    assert np.allclose(course.effort, by_hand, rtol=0.0, atol=EXACT * np.abs(by_hand).max())

    def effort(t: float, i: int) -> float:
        one = reference.at(t)
        return float(oracle.inverse_dynamics(one.q, one.v, one.a)[i])

    for i, duty in enumerate(found.worst):
        assert duty.rms_effort == pytest.approx(root_mean_square(lambda t, i=i: effort(t, i), 0.3), rel=EXACT)
        times = np.linspace(0.0, 0.3, 61)
        assert abs(duty.effort.value) >= max(abs(effort(float(t), i)) for t in times) * (1.0 - EXACT)
        assert abs(effort(duty.effort.time, i)) == pytest.approx(abs(duty.effort.value), rel=EXACT)
    assert found.balance < EXACT
