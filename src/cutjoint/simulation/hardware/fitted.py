"""Hardware for a robot of n actuators: every number as an array, what is ideal as None."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.errors import InputError
from cutjoint.simulation.hardware.numbers import filter_part
from cutjoint.simulation.hardware.values import Backlash, Differences, Each, Hardware, Tachometer


class Gear(NamedTuple):
    """Gears with play, arrays of shape (n,): half the width of the play, and the rest as in `Backlash`."""

    half: Array
    stiffness: Array
    damping: Array
    rotor: Array


class Fitted:
    """The numbers of a sampled loop; arrays of shape (n,), None for what is ideal.

    Attributes:
        n: number of actuators.
        rate, period: of the clock, [Hz] and [s].
        ticks: its times in ticks.
        offset, noise, step: of the encoder.
        at_motor: whether the sensors sit before the play of the gear.
        differences: whether speeds are differences of positions.
        cutoff: of their filter [Hz].
        filter_part: what of a new difference it takes in a period; a number, or one an actuator.
        speed_noise: of the tachometer.
        limits, command_step: of the drive.
        stall, no_load_speed: of the motor.
        gear: with play.
        channels: standard normal numbers that a sample needs: n for the encoder if it is noisy, then n for the
            tachometer if it is.

    Raises:
        InputError: a number of numbers that is neither one nor n.
    """

    def __init__(self, hardware: Hardware, n: int) -> None:
        encoder, speed, drive = hardware.encoder, hardware.speed, hardware.drive
        self.n, self.rate, self.period, self.ticks = n, hardware.clock.rate, hardware.clock.period, hardware.ticks
        self.offset = _or_none(_fit("offset of the encoder", encoder.offset, n))
        self.noise = _or_none(_fit("noise of the encoder", encoder.noise, n))
        self.step = _fit("resolution of the encoder", encoder.resolution, n)
        self.differences = isinstance(speed, Differences)
        self.cutoff = speed.cutoff if isinstance(speed, Differences) else None
        self.filter_part: float | Array = 1.0 if self.cutoff is None else filter_part(self.cutoff, self.period)
        tachometer = speed.noise if isinstance(speed, Tachometer) else 0.0
        self.speed_noise = _or_none(_fit("noise of the tachometer", tachometer, n))
        self.limits = _fit("limits", drive.limits, n)
        self.command_step = _fit("resolution of the drive", drive.resolution, n)
        motor = drive.torque_speed
        self.stall = None if motor is None else _fit("stall effort of the motor", motor.stall, n)
        self.no_load_speed = None if motor is None else _fit("no-load speed of the motor", motor.no_load_speed, n)
        self.gear = None if drive.backlash is None else _gear(drive.backlash, n)
        self.at_motor = encoder.at == "motor" and self.gear is not None
        self.channels = n * ((self.noise is not None) + (self.speed_noise is not None))


def _gear(play: Backlash, n: int) -> Gear:
    width, *rest = (
        _fitting(f"{name} of the backlash", getattr(play, name), n)
        for name in ("width", "stiffness", "damping", "rotor")
    )
    return Gear(readonly(0.5 * width), *rest)


def _fit(name: str, value: Each | None, n: int) -> Array | None:
    return None if value is None else _fitting(name, value, n)


def _fitting(name: str, value: Each, n: int) -> Array:
    array = np.asarray(value, dtype=np.float64)
    if array.shape not in ((), (n,)):
        raise InputError(f"{name} must be one number or {n} of them, one an actuator; found {array.size}")
    return readonly(np.broadcast_to(array, (n,)))


def _or_none(array: Array | None) -> Array | None:
    """None for zeros, which change nothing."""
    return array if array is not None and array.any() else None
