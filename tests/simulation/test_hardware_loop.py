"""The sampled loop against a second derivation: blocks whose motion between two instants is a parabola."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from kit.blocks import blocks
from kit.quickly import few
from oracles.sampled import SampledBlock

from cutjoint.control import PID, PDGravity
from cutjoint.motion import PointToPoint, Reference
from cutjoint.papers.cpm import CpmModel
from cutjoint.simulation import Adaptive, ConstrainedPlant, DormandPrince, ReducedPlant, RungeKutta4, State, run
from cutjoint.simulation.hardware import Clock, Differences, Drive, Encoder, Hardware, Tachometer
from cutjoint.simulation.hardware.noise import Jitter, Noise

MASSES = (0.4, 2.0, 30.0)
ROBOT = blocks(MASSES)


@dataclass(frozen=True)
class Spring:
    """Gains [1/s2] and [1/s] and a push that depends on the time, so that it matters when the law is asked."""

    kp: float
    kd: float
    push: float

    def one(self, mass: float, t: float, q: float, v: float) -> float:
        return mass * (-self.kp * q - self.kd * v + self.push * t)

    def __call__(self, t, desired, q, v):
        return np.array([self.one(mass, t, x, y) for mass, x, y in zip(MASSES, q, v, strict=True)])


def some(seed: int) -> tuple[Hardware, Spring, int]:
    """Hardware and a law at random, and the number of a run."""
    rng = np.random.default_rng(seed)
    scale = 10.0 ** rng.uniform(-3, 3)
    parts = int(rng.choice([1, 1, 4, 20]))
    period = 10.0 ** rng.uniform(-4, -2)
    tick = period / parts
    most = int(rng.integers(0, (parts - 1) // 4 + 1))

    def delay() -> float:
        return float(rng.integers(0, 3) * parts + rng.integers(0, parts - 2 * most)) * tick

    speed = [Tachometer(), Differences(), Differences(float(0.05 / period))][int(rng.integers(0, 3))]
    encoder = Encoder(
        resolution=rng.choice([None, 1e-3 * scale]),
        offset=rng.choice([0.0, 0.1 * scale]),
        noise=tuple(rng.choice([0.0, 1e-3 * scale]) * rng.uniform(size=3)),
        delay=delay(),
    )
    limits = (
        None if rng.random() < 0.5 else tuple(np.array(MASSES) * scale * rng.uniform(0.2, 0.8) * (0.1 / period) ** 2)
    )
    drive = Drive(limits, rng.choice([None, 1e-3 * scale * (0.1 / period) ** 2]), delay())
    law = Spring((0.1 / period) ** 2, 0.2 / period, scale * (0.1 / period) ** 3 * rng.uniform(-1, 1))
    clock = Clock(1.0 / period, most * tick, tick if parts > 1 or rng.random() < 0.5 else None)
    return Hardware(clock, encoder, speed, drive, seed=int(rng.integers(0, 1000))), law, int(rng.integers(0, 9))


@pytest.mark.parametrize("seed", few(range(60), 0, 1, 4, 5))
def test_a_block_moves_as_the_second_derivation_says(seed: int) -> None:
    hardware, law, number = some(seed)
    samples, period = 40, hardware.clock.period
    scale = abs(law.push) / law.kp**1.5 + 1e-30
    start = scale * np.random.default_rng(seed).uniform(-1.0, 1.0, 3)
    times = np.arange(0.0, samples, 1.7) * period
    v = 0.3 * start / period
    found = run(
        ConstrainedPlant(ROBOT), law, hardware=hardware, run_number=number, duration=float(times[-1]),
        start=State(start, v), integrator=RungeKutta4(period), every=1.7 * period,
    )  # fmt: skip
    ticks = hardware.ticks
    late = Jitter(hardware.seed, number, ticks.jitter).ticks(samples + 5)
    fitted = np.broadcast_to(hardware.encoder.noise, 3)
    noisy = bool(fitted.any())
    normals = Noise(hardware.seed, number, 3 * noisy).rows(samples + 5)
    for i, mass in enumerate(MASSES):
        other = SampledBlock(
            mass, period, [(k * ticks.period + late[k]) * ticks.length for k in range(samples + 5)],
            lambda t, q, v, mass=mass: law.one(mass, t, q, v),
            ticks.seen_after, ticks.seen_late * ticks.length, ticks.acts_after, ticks.acts_late * ticks.length,
            step=hardware.encoder.resolution or 0.0, offset=hardware.encoder.offset,
            differences=isinstance(hardware.speed, Differences), cutoff=getattr(hardware.speed, "cutoff", None),
            top=np.inf if hardware.drive.limits is None else hardware.drive.limits[i],
            command_step=hardware.drive.resolution or 0.0,
            noise=(fitted[i] * normals[:, i]).tolist() if noisy else (),
        )  # fmt: skip
        place, speed, effort = np.array(other.run(start[i], v[i], times.tolist())).T
        assert np.abs(found.q[:, i] - place).max() < 1e-10 * np.abs(place).max()
        assert np.abs(found.v[:, i] - speed).max() < 1e-10 * np.abs(speed).max()
        assert np.abs(found.effort[:, i] - effort).max() < 1e-9 * np.abs(effort).max()


MODEL = CpmModel()
WAY = Reference(PointToPoint([0.6, 0.425, 0.3], [0.5, 0.45, 0.35], 0.4), MODEL)


METHODS = [RungeKutta4(2e-3), Adaptive(1e-7, 1e-9), DormandPrince(1e-6, 1e-8)]


@pytest.mark.parametrize("method", few(METHODS, METHODS[0]))
@pytest.mark.parametrize("law", [PDGravity(MODEL, 8507, 436), PID(2000, 6000, 200)])
@pytest.mark.parametrize("limits", [None, 30.0])
def test_ideal_hardware_is_the_sample_rate_bit_for_bit(method, law, limits):
    settings = {"integrator": method, "every": 3.1e-3, "duration": 0.06}
    plain = run(ReducedPlant(MODEL), law, WAY, rate=330.0, limits=limits, **settings)
    built = run(ReducedPlant(MODEL), law, WAY, hardware=Hardware(Clock(330.0), drive=Drive(limits)), **settings)
    for name, column in plain.columns.items():
        assert np.array_equal(column, built.columns[name]), name
    assert np.array_equal(built.command, built.effort)
    assert built.about["steps"] == plain.about["steps"]
    assert (built.about["rate"], built.about["limits"]) == (plain.about["rate"], plain.about["limits"])


def test_both_plants_have_the_same_hardware():
    chain = blocks((2.0, 5.0))
    hardware = Hardware(Clock(500.0), Encoder(1e-4, noise=1e-4, delay=2e-3), Differences(80.0), Drive(delay=2e-3), 4)
    runs = [
        run(
            plant(chain),
            lambda t, desired, q, v: -200.0 * q - 20.0 * v,
            hardware=hardware,
            duration=0.2,
            start=chain.close([0.1, -0.2]),
            integrator=RungeKutta4(2e-3),
        )
        for plant in (ReducedPlant, ConstrainedPlant)
    ]
    for name, column in runs[0].columns.items():
        assert np.allclose(column, runs[1].columns[name], rtol=1e-9, atol=1e-9), name
