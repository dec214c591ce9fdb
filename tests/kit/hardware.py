"""Random hardware between a control law and the joints, of the size of a robot and its efforts."""

from __future__ import annotations

from typing import Any

import numpy as np

from cutjoint.simulation.hardware import (
    Backlash,
    Clock,
    Differences,
    Drive,
    Encoder,
    Hardware,
    Tachometer,
    TorqueSpeed,
)

PERIOD, FINE = 2e-3, 4
"""Of the controller [s], and ticks in it."""


def some_hardware(rng: np.random.Generator, place: np.ndarray, effort: np.ndarray, mass: np.ndarray) -> Hardware:
    """Each part is there or not, at random.

    Args:
        rng: chance.
        place: of each actuator, a length or angle that is small for it.
        effort: that is large for it.
        mass: that it moves.
    """

    def maybe(make: Any, ideal: Any = None) -> Any:
        return make() if rng.uniform() < 0.6 else ideal

    tick = PERIOD / FINE
    jitter = maybe(lambda: tick, 0.0)
    late = (0, 1) if jitter else (0, 1, 2, 3)
    seen, acts = (tick * (rng.choice(late) + FINE * rng.integers(0, 3)) for _ in range(2))
    clock = Clock(1.0 / PERIOD, jitter, tick)
    resolution = maybe(lambda: tuple(1e-4 * place * rng.uniform(0.5, 1.5, place.size)))
    noise = maybe(lambda: tuple(1e-4 * place), 0.0)
    encoder = Encoder(resolution, tuple(1e-3 * place * rng.normal(size=place.size)), noise, float(seen))
    tachometer = Tachometer(maybe(lambda: tuple(1e-2 * place), 0.0))
    speed = tachometer if rng.uniform() < 0.5 else Differences(maybe(lambda: rng.uniform(20.0, 100.0)))
    motor = maybe(lambda: TorqueSpeed(tuple(2.0 * effort), tuple(50.0 * place)))
    stiffness = mass * (0.2 / PERIOD) ** 2
    play = Backlash(tuple(1e-2 * place), tuple(stiffness), tuple(0.1 * mass / PERIOD), tuple(0.5 * mass))
    drive = Drive(
        maybe(lambda: tuple(effort)), maybe(lambda: tuple(1e-3 * effort)), float(acts), motor, maybe(lambda: play)
    )
    return Hardware(clock, encoder, speed, drive, int(rng.integers(0, 2**40)))
