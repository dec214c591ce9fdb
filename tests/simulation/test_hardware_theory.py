"""Each effect of hardware against what theory says of it."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from kit.blocks import Rails
from kit.quickly import few
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

from cutjoint.simulation import Adaptive, Integrator, Result, RungeKutta4, State, run
from cutjoint.simulation.hardware import (
    Backlash,
    Clock,
    Differences,
    Drive,
    Encoder,
    Hardware,
    TorqueSpeed,
)
from cutjoint.simulation.hardware.equations import LoopEquations
from cutjoint.simulation.hardware.fitted import Fitted

EXACT = Adaptive(1e-12, 1e-15)


def at_random(seed: int, *ranges: tuple[float, float]) -> list[float]:
    """Numbers whose logarithms are spread evenly over the ranges."""
    rng = np.random.default_rng(seed)
    return [float(np.exp(rng.uniform(*np.log(one)))) for one in ranges]


@pytest.mark.parametrize("seed", few(range(20), 0))
def test_a_sampled_linear_robot_is_its_matrix_exponential(seed: int) -> None:
    """A block on a spring with a damper under a held effort: x+ = e^(A T) x + (the integral of e^(A s) B) u."""
    mass, stiffness, damping, rate = at_random(seed, (1e-2, 1e2), (1e-1, 1e3), (1e-2, 1e2), (20.0, 500.0))
    kp, kd = 3.0 * stiffness, 0.1 * mass * rate
    found = run(
        Rails([mass], stiffness, damping), lambda t, desired, q, v: -kp * q - kd * v, hardware=Hardware(Clock(rate)),
        duration=60.0 / rate, every=1.0 / rate, start=State(np.array([0.2]), np.ones(1)), integrator=EXACT,
    )  # fmt: skip
    a = np.zeros((3, 3))  # with a third state for the effort, which is held
    a[0, 1] = 1.0
    a[1] = np.array([-stiffness, -damping, 1.0]) / mass
    step = expm(a / rate)
    x = np.array([0.2, 1.0, 0.0])
    far, fast = np.abs(found.q).max(), np.abs(found.v).max()  # some of these loops diverge
    for q, v in zip(found.q[:, 0], found.v[:, 0], strict=True):
        assert abs(q - x[0]) < 1e-10 * max(1.0, far)
        assert abs(v - x[1]) < 1e-10 * max(1.0, fast)
        x[2] = -kp * x[0] - kd * x[1]
        x = step @ x


@pytest.mark.parametrize("seed", few(range(12), 0))
@pytest.mark.parametrize("late", few(["encoder", "drive", "both"], "both"))
def test_a_delay_takes_the_phase_margin_that_it_should(seed: int, late: str) -> None:
    """A double integrator under PD, 2 ms late, sampled finely: it swings for ever at the gain whose phase margin is
    used up by the delay and half a period of hold; below it calms down, above it grows."""
    mass, ratio = at_random(seed, (1e-3, 1e3), (5.0, 100.0))
    period, delay = 2e-4, 2e-3
    total = delay + 0.5 * period

    def left(w: float) -> float:
        """Phase of (kp + kd s) e^(-s total) / s^2 above -180 degrees, kp / kd = ratio."""
        return float(np.arctan(w / ratio) - w * total)

    w = brentq(left, 10.0, 0.5 * np.pi / total)
    critical = mass * w * w / np.hypot(1.0, w / ratio)  # kp
    shares = {"encoder": (delay, 0.0), "drive": (0.0, delay), "both": (0.6e-3, 1.4e-3)}[late]
    hardware = Hardware(Clock(1.0 / period), Encoder(delay=shares[0]), drive=Drive(delay=shares[1]))
    robot = Rails([mass])
    growth = []
    for factor in (0.97, 1.03):
        kp = factor * critical
        found = run(
            robot, lambda t, desired, q, v, kp=kp: -kp * q - kp / ratio * v, hardware=hardware,
            duration=40.0 * 2.0 * np.pi / w, start_velocity=[1.0], integrator=RungeKutta4(period), every=5 * period,
        )  # fmt: skip
        half = len(found) // 2
        early, last = (np.abs(found.v[part]).max() for part in (slice(half // 2, half), slice(half + half // 2, None)))
        growth.append(last / early)
    assert growth[0] < 0.9, growth
    assert growth[1] > 1.1, growth


@pytest.mark.parametrize("seed", few(range(12), 0))
def test_the_filter_of_differences_answers_a_step_of_speed_as_a_first_order(seed: int) -> None:
    """1 - e^(-2 pi f t) of the speed after t; without a filter all of it at once."""
    rate, part, speed = at_random(seed, (100.0, 1e4), (1e-3, 0.4), (1e-3, 1e3))
    for cutoff in (part * rate, None):
        hardware = Hardware(Clock(rate), speed=Differences(cutoff))
        found = run(
            Rails([1.0]), hardware=hardware, duration=50.0 / rate,
            start=State(np.zeros(1), np.array([speed])), integrator=RungeKutta4(1.0 / rate),
        )  # fmt: skip
        expected = speed * (1.0 if cutoff is None else -np.expm1(-2.0 * np.pi * cutoff * found.time))
        assert np.abs(found.measured_v[1:, 0] - np.broadcast_to(expected, 51)[1:]).max() < 1e-10 * speed
        assert found.measured_v[0, 0] == 0.0


@pytest.mark.parametrize("seed", few(range(20), 0, 1))
def test_steps_of_encoder_and_command_are_whole_and_at_most_half_a_step_off(seed: int) -> None:
    step, command_step, offset = at_random(seed, (1e-3, 1e3), (1e-3, 1e3), (1e-3, 1e3))
    hardware = Hardware(Clock(100.0), Encoder(step, offset), drive=Drive(7.3 * command_step, command_step))
    found = run(
        Rails([1.0, 5.0]), lambda t: np.array([10.0, 5.0]) * command_step * np.sin([7.0 * t, 9.0 * t]),
        hardware=hardware, duration=2.0, start=State(np.zeros(2), 11.0 * step * np.array([1.0, -0.7])),
        integrator=RungeKutta4(0.01),
    )  # fmt: skip
    counts = found.measured_q / step
    assert np.abs(counts - np.rint(counts)).max() < 1e-9
    off = (found.measured_q - found.q - offset) / step
    assert np.abs(off).max() <= 0.5 + 1e-9
    assert np.abs(off).max() > 0.4
    assert len(np.unique(np.rint(counts))) > 5
    top = np.abs(found.command) >= 7.3 * command_step
    assert top.any(axis=0)[0]
    assert not top.all()
    steps = found.command[~top] / command_step
    assert np.abs(steps - np.rint(steps)).max() < 1e-9
    assert np.abs(found.command - found.asked)[~top].max() <= 0.5 * command_step * (1 + 1e-9)
    assert np.abs(found.command).max() == 7.3 * command_step
    assert (np.abs(found.asked)[top] >= 7.0 * command_step).all()


@pytest.mark.parametrize("seed", few(range(10), 0))
def test_a_motor_at_full_voltage_tends_to_its_no_load_speed(seed: int) -> None:
    """v = v0 (1 - e^(-stall t / (m v0))); and back through rest with up to twice the stall effort."""
    mass, stall, top = at_random(seed, (1e-2, 1e2), (1e-1, 1e3), (1e-2, 1e2))
    constant = mass * top / stall
    hardware = Hardware(Clock(10.0 / constant), drive=Drive(torque_speed=TorqueSpeed(stall, top)))
    plant = Rails([mass])
    settings = {"hardware": hardware, "duration": 8.0 * constant, "every": 0.1 * constant, "integrator": EXACT}
    found = run(plant, lambda t: [100.0 * stall], **settings)
    assert np.abs(found.v[:, 0] + top * np.expm1(-found.time / constant)).max() < 1e-10 * top
    assert np.abs(found.effort[:, 0] - stall * (1.0 - found.v[:, 0] / top)).max() < 1e-9 * stall
    assert found.energy_drift() < 1e-9
    back = run(plant, lambda t: [-100.0 * stall], start=State(np.zeros(1), np.array([top])), **settings)
    assert back.effort[0, 0] == pytest.approx(-2.0 * stall)
    assert np.abs(back.v[:, 0] - top * (2.0 * np.exp(-back.time / constant) - 1.0)).max() < 1e-10 * top
    weak = run(plant, lambda t: [0.1 * stall], **settings)
    assert weak.v.max() <= 0.9 * top + 1e-9 * top
    assert weak.effort[0, 0] == 0.1 * stall


def geared(seed: int, damped: bool = True) -> tuple[float, Backlash]:
    """Mass of a block and a gear with play before it."""
    mass, rotor, stiffness, width = at_random(seed, (1.0, 1e2), (0.1, 0.9), (1e2, 1e5), (1e-3, 1e-1))
    rest = np.sqrt(stiffness * mass * rotor / (mass + rotor))
    ratio = at_random(seed + 1000, (0.01, 0.5))[0] if damped else 0.0
    return mass, Backlash(width, stiffness, 2.0 * ratio * rest, rotor * mass)


@pytest.mark.parametrize("seed", few(range(16), 0, 1))
def test_a_gear_in_contact_is_two_masses_and_a_spring(seed: int) -> None:
    """A steady push keeps contact where the rotor is the lighter of both: the matrix exponential of four states."""
    mass, play = geared(seed)
    rotor, push = float(play.rotor), 3.0 * (-1.0) ** seed
    frequency = np.sqrt(play.stiffness / rotor)
    hardware = Hardware(Clock(frequency), drive=Drive(backlash=play))
    found = run(Rails([mass]), lambda t: [push], hardware=hardware, duration=20.0 / frequency, integrator=EXACT)
    k, c = play.stiffness, play.damping
    a = np.zeros((5, 5))  # rotor (less half the play) and block, their speeds, 1
    a[0, 2] = a[1, 3] = 1.0
    a[2] = np.array([-k, k, -c, c, push]) / rotor
    a[3] = np.array([k, -k, c, -c, 0.0]) / mass
    start = np.array([push / k, 0.0, 0.0, 0.0, 1.0])
    for i in range(0, len(found), 7):
        x = expm(a * found.time[i]) @ start
        assert found.q[i, 0] == pytest.approx(x[1], abs=1e-10 * np.abs(found.q).max())
        assert found.rotor_q[i, 0] == pytest.approx(x[0] + np.copysign(0.5 * play.width, push), abs=1e-10)
        assert found.rotor_v[i, 0] == pytest.approx(x[2], abs=1e-10 * np.abs(found.rotor_v).max())
    assert found.energy_drift() < 1e-8


@pytest.mark.parametrize("seed", few(range(30), 0, 1))
def test_impacts_in_a_gear_give_back_what_a_spring_and_damper_that_never_pull_do(seed: int) -> None:
    """T. Schwager, T. Poeschel: Coefficient of restitution and linear-dashpot model revisited, Granular Matter 9 (2007)
    465-469: exp(-b/w (pi - atan2(2 b w, w^2 - b^2))), b = c / (2 mu), w^2 = k / mu - b^2, mu the reduced mass."""
    mass, play = geared(seed)
    mu = mass * play.rotor / (mass + play.rotor)
    b = play.damping / (2.0 * mu)
    w = np.sqrt(play.stiffness / mu - b * b)
    expected = np.exp(-b / w * (np.pi - np.arctan2(2.0 * b * w, w * w - b * b)))
    equations = LoopEquations(Fitted(Hardware(Clock(1.0), drive=Drive(backlash=play)), 1))
    side = np.random.default_rng(seed).choice([-1.0, 1.0])
    speed = play.width * w

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        effort = equations.transmitted(y[:1], y[1:2], y[2:3], y[3:])
        return np.array([y[1], equations.rotor_rates(np.zeros(1), effort)[0], y[3], effort[0] / mass])

    def parted(t: float, y: np.ndarray) -> float:
        return abs(y[0] - y[2]) - 0.4 * play.width

    parted.terminal, parted.direction = True, -1.0  # type: ignore[attr-defined]
    start = [side * 0.45 * play.width, side * speed, 0.0, 0.0]
    found = solve_ivp(
        rates, (0.0, 100.0 / w), start, "DOP853", rtol=1e-12, atol=1e-14, max_step=0.02 / w, events=parted
    )
    assert found.t_events[0].size == 1
    end = found.y[:, -1]
    assert (end[3] - end[1]) / (side * speed) == pytest.approx(expected, rel=1e-5)
    assert mass * end[3] + play.rotor * end[1] == pytest.approx(play.rotor * side * speed, rel=1e-9)


def swinging(
    plant: Rails, play: Backlash, at: Literal["joint", "motor"], samples: int, method: Integrator | None = None
) -> Result:
    """PD control through a gear with play, from rest away from the goal."""
    mass, width = float(plant.masses[0]), float(play.width)  # type: ignore[arg-type]
    stiffness, rotor = float(play.stiffness), float(play.rotor)  # type: ignore[arg-type]
    rate = 20.0 * np.sqrt(stiffness / rotor)
    kp, kd = 0.1 * stiffness, 0.5 * np.sqrt(0.1 * stiffness * mass)
    return run(
        plant, lambda t, desired, q, v: -kp * q - kd * v, duration=samples / rate, every=1.0 / rate,
        hardware=Hardware(Clock(rate), Encoder(at=at), drive=Drive(backlash=play)),
        start=State(np.array([3.0 * width]), np.zeros(1)),
        integrator=Adaptive(1e-11, 1e-13 * width) if method is None else method,
    )  # fmt: skip


@pytest.mark.parametrize("seed", few(range(6), 0))
@pytest.mark.parametrize("damped", few([False, True], True))
def test_play_makes_no_energy(seed: int, damped: bool) -> None:
    """Of rotor, gear and block together: the work of the motor, less what the damper takes."""
    mass, gear = geared(seed)
    found = swinging(Rails([mass]), gear if damped else replace(gear, damping=0.0), "joint", 1000)
    beyond = np.maximum(np.abs(found.rotor_q - found.q) - 0.5 * gear.width, 0.0)
    inside = 0.5 * (mass * found.v**2 + gear.rotor * found.rotor_v**2 + gear.stiffness * beyond**2)[:, 0]
    work = np.append(0.0, np.cumsum(found.command[:-1, 0] * np.diff(found.rotor_q[:, 0])))
    taken = work - (inside - inside[0])
    assert (beyond == 0.0).any()
    assert (beyond > 0.0).any()
    if damped:
        assert np.diff(taken).min() > -1e-8 * inside.max()
        assert taken[-1] > 1e-2 * inside.max()
    else:
        assert np.abs(taken).max() < 1e-8 * inside.max()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_a_swing_through_play_is_as_large_as_the_play(seed: int, scale: float) -> None:
    """All other equations are linear, so play and start of another size give the same motion of that size."""
    mass, gear = geared(seed)
    other = swinging(Rails([mass]), replace(gear, width=scale * gear.width), "joint", 1000)
    one = swinging(Rails([mass]), gear, "joint", 1000)
    assert np.abs(other.q - scale * one.q).max() < 1e-6 * scale * np.abs(one.q).max()


@pytest.mark.parametrize("seed", few(range(6), 0))
def test_an_encoder_at_the_motor_leaves_the_joint_within_the_play(seed: int) -> None:
    mass, gear = geared(seed)
    slow = 0.5 * np.sqrt(0.1 * gear.stiffness * mass)
    quick = 0.01 * np.sqrt(gear.rotor / gear.stiffness)
    found = swinging(Rails([mass], damping=slow), gear, "motor", 3000, RungeKutta4(5.0 * quick))
    rest = found.time > 0.9 * found.time[-1]
    assert np.array_equal(found.measured_q, found.rotor_q)
    assert np.abs(found.rotor_q[rest]).max() < 1e-2 * gear.width
    assert np.abs(found.q[rest]).max() < 0.51 * gear.width
    assert np.abs(found.q[rest]).max() > 0.1 * gear.width
