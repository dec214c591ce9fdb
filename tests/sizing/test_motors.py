"""Motors and gears: mean squares at any ratio, the best ratio, what fits; laws, not examples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from kit.quickly import few

from cutjoint.errors import InputError
from cutjoint.mechanism import Actuator
from cutjoint.sizing import Gearing, ServoMotor
from cutjoint.sizing.cycle import Integrals, LoadCycle
from cutjoint.sizing.matching import MotorFit, choices, matched

HINGE, SLIDE = Actuator("hinge", "rotation"), Actuator("slide", "translation")
MOTOR = ServoMotor("m", "rotation", 1.0, 3.0, 500.0, 2e-5)


def cycle(seed: int, inertia: float | None = None, count: int = 4000) -> LoadCycle:
    """A periodic motion of one actuator with a load; its integrals by the sum over a whole period, which is exact."""
    rng = np.random.default_rng(seed)
    t = np.arange(count) / count
    waves = [(k, rng.normal(), rng.normal()) for k in range(1, 4)]
    v = sum(a * np.sin(2 * np.pi * k * t + b) for k, a, b in waves)
    a = sum(2 * np.pi * k * a * np.cos(2 * np.pi * k * t + b) for k, a, b in waves)
    b = rng.normal() + sum(rng.normal() * np.cos(2 * np.pi * k * t + rng.normal()) for k in range(4)) + 0.3 * a
    if inertia is not None:
        b = inertia * a
    back = b * v < 0.0
    parts = (b * b, v * v, b * v, np.maximum(b * v, 0.0), b * b, back * b * b, b * a, back * b * a, a * a, 0 * v, 0 * v)
    found = Integrals(*(np.array([one.mean()]) for one in parts))
    return LoadCycle(f"way {seed}", 1.0, found, v[:, None], a[:, None], b[:, None], np.array([0.3]), np.array([2.0]))


def fitted(cycles: list[LoadCycle], motor: ServoMotor, gearing: Gearing, actuator: Actuator = HINGE) -> MotorFit:
    return matched(cycles, [actuator], [motor], gearing)[0]


@pytest.mark.parametrize("seed", few(range(12), 0, 1))
def test_mean_squares_are_those_of_the_motor_itself(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cycles = [cycle(2 * seed), cycle(2 * seed + 1)]
    ratio = float(10.0 ** rng.uniform(0.0, 2.0))
    gearing = Gearing((ratio,), efficiency=rng.uniform(0.5, 1.0), inertia=1e-5)
    fit = fitted(cycles, MOTOR, gearing)
    courses = [choices(fit, [one], gearing, 0) for one in cycles]
    assert fit.ratio == pytest.approx(ratio, rel=1e-12)
    assert fit.rms_effort == pytest.approx(max(np.sqrt(np.mean(tau**2)) for _, tau in courses), rel=1e-9)
    assert fit.effort == pytest.approx(max(np.abs(tau).max() for _, tau in courses), rel=1e-12)
    assert fit.speed == pytest.approx(max(np.abs(w).max() for w, _ in courses), rel=1e-12)
    for w, tau in courses:  # power at the motor is that at the actuator, what is stored and what the gear takes
        stored = (MOTOR.rotor + 1e-5) * ratio**2
        one = next(own for own in cycles if np.allclose(own.v[:, 0] * ratio, w))
        given = one.bare[:, 0] * one.v[:, 0]
        taken = tau * w - stored * one.a[:, 0] * one.v[:, 0] - given
        assert taken.min() >= -1e-9 * np.abs(given).max()


@pytest.mark.parametrize("seed", few(range(8), 0))
def test_the_best_ratio_beats_all_others(seed: int) -> None:
    cycles = [cycle(100 + seed)]
    best = fitted(cycles, MOTOR, Gearing(efficiency=0.9))
    others = [fitted(cycles, MOTOR, Gearing((float(g),), efficiency=0.9)) for g in np.geomspace(0.5, 400.0, 13)]
    assert all(best.use <= one.use * (1.0 + 1e-9) for one in others)
    for part in (0.8, 0.99, 0.9999, 1.0001, 1.01, 1.25):  # near it, where a search that stopped early would lose
        near = fitted(cycles, MOTOR, Gearing((part * float(best.ratio),), efficiency=0.9))
        assert best.use <= near.use * (1.0 + 1e-9)
    assert all(one.best_ratio == pytest.approx(best.ratio, rel=1e-9) for one in others)
    chosen = fitted(cycles, MOTOR, Gearing(tuple(float(one.ratio) for one in others), efficiency=0.9))
    assert chosen.use == pytest.approx(min(one.use for one in others), rel=1e-12)
    assert chosen.is_chosen
    assert not best.is_chosen


@pytest.mark.parametrize("inertia", [1e-4, 0.02, 3.0])
def test_an_inertia_alone_wants_equal_inertias(inertia: float) -> None:
    one = cycle(5, inertia)
    fit = fitted([one], replace(MOTOR, peak=1e9, rated=1e9, max_speed=1e9), Gearing())
    assert fit.least_heat == pytest.approx(np.sqrt(inertia / MOTOR.rotor), rel=1e-9)
    at_best = fitted([one], MOTOR, Gearing((fit.least_heat,)))
    for part in (0.5, 0.9, 1.1, 2.0):
        assert fitted([one], MOTOR, Gearing((part * fit.least_heat,))).rms_effort > at_best.rms_effort
    aa = float(one.integrals.aa[0])
    assert at_best.rms_effort == pytest.approx(2.0 * np.sqrt(inertia * MOTOR.rotor * aa), rel=1e-9)


def test_a_screw_is_a_gear_with_a_unit() -> None:
    one, pitch = cycle(9), 0.01
    turning = fitted([one], MOTOR, Gearing((3.0 * 2.0 * np.pi / pitch,)))
    screw = fitted([one], MOTOR, Gearing((3.0,), pitch=pitch), SLIDE)
    assert screw.ratio == pytest.approx(3.0)
    for name in ("effort", "rms_effort", "speed", "use", "reflected"):
        assert getattr(screw, name) == pytest.approx(getattr(turning, name), rel=1e-12)


def test_order_verdict_and_brake() -> None:
    one = cycle(11)
    motors = [replace(MOTOR, name=f"m{k}", rated=0.02 * 3.0**k, peak=0.06 * 3.0**k) for k in range(6)]
    fits = matched([one], [HINGE], motors, Gearing((20.0,)))
    verdicts = [fit.fits for fit in fits]
    assert verdicts == sorted(verdicts, reverse=True)
    assert any(verdicts)
    assert not all(verdicts)
    good = [fit.motor.rated_power for fit in fits if fit.fits]
    assert good == sorted(good)
    assert all(fit.why_not for fit in fits if not fit.fits)
    assert all((fit.margin >= 0.0) == (fit.use <= 1.0) for fit in fits)
    braked = fitted([one], replace(MOTOR, brake=0.5), Gearing((10.0,), brake_factor=2.0))
    assert braked.brake_use == pytest.approx(2.0 * 2.0 / 10.0 / 0.5)


def test_a_winding_in_the_long_run() -> None:
    motor = replace(MOTOR, resistance=2.0, constant=0.1, thermal_resistance=1.5, max_temperature=120.0)
    found = motor.temperature(0.2, 40.0)
    assert found is not None
    assert found == pytest.approx(40.0 + 1.5 * 2.0 * (1.0 + 0.00393 * (found - 25.0)) * (0.2 / 0.1) ** 2)
    assert motor.temperature(10.0, 40.0) == float("inf")
    assert MOTOR.temperature(0.2, 40.0) is None
    hot = fitted([cycle(3)], motor, Gearing((20.0,)))
    assert hot.temperature == motor.temperature(hot.rms_effort, 40.0)
    assert hot.is_too_hot == (hot.temperature > 120.0)


def test_curves_fall_where_they_must() -> None:
    motor = ServoMotor("m", "rotation", 1.0, 3.0, 100.0, 0.0, rated_speed=50.0, knee_speed=60.0)
    speed = np.array([-100.0, -60.0, 0.0, 50.0, 80.0, 100.0])
    assert np.allclose(motor.largest(speed), [1.0, 3.0, 3.0, 3.0, 2.0, 1.0])
    assert np.allclose(motor.lasting(speed), [0.5, 50.0 / 60.0, 1.0, 1.0, 0.625, 0.5])


def test_numbers_that_are_none_are_refused() -> None:
    for wrong in ({"rated": 0.0}, {"peak": 0.5}, {"max_speed": float("nan")}, {"rotor": -1.0}, {"rated_speed": 600.0}):
        with pytest.raises(InputError, match="motor 'm'"):
            replace(MOTOR, **wrong)
    for bad in ({"efficiency": 1.1}, {"efficiency": 0.0}, {"inertia": -1.0}, {"pitch": 0.0}, {"ratios": (0.0,)},
                {"brake_factor": -1.0}, {"ambient": float("nan")}):  # fmt: skip
        with pytest.raises(InputError):
            Gearing(**bad)
    with pytest.raises(InputError, match="'slide' slides, and every motor of the table turns; give the pitch"):
        Gearing().check([SLIDE], [MOTOR])
    with pytest.raises(InputError, match="two motors are called 'm'"):
        Gearing().check([HINGE], [MOTOR, MOTOR])
