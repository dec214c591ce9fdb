"""Numbers of hardware by name, such as `encoder.noise`: those that may differ from run to run of one loop.

What decides when something happens (rate, tick, jitter, delays) is not among them: it belongs to the loop itself.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.simulation.hardware.values import Differences, Each, Hardware, Tachometer

PLACES: Mapping[str, tuple[str, ...]] = {
    "encoder.resolution": ("encoder", "resolution"),
    "encoder.offset": ("encoder", "offset"),
    "encoder.noise": ("encoder", "noise"),
    "differences.cutoff": ("speed", "cutoff"),
    "tachometer.noise": ("speed", "noise"),
    "drive.limits": ("drive", "limits"),
    "drive.resolution": ("drive", "resolution"),
    "drive.torque_speed.stall": ("drive", "torque_speed", "stall"),
    "drive.torque_speed.no_load_speed": ("drive", "torque_speed", "no_load_speed"),
    "drive.backlash.width": ("drive", "backlash", "width"),
    "drive.backlash.stiffness": ("drive", "backlash", "stiffness"),
    "drive.backlash.damping": ("drive", "backlash", "damping"),
    "drive.backlash.rotor": ("drive", "backlash", "rotor"),
}
"""Name -> fields of `Hardware` that lead to the number."""
SPEEDS = {"differences": Differences, "tachometer": Tachometer}
OF_TIME = ("clock.rate", "clock.jitter", "clock.tick", "encoder.delay", "drive.delay")
"""Numbers that decide when something happens."""


def hardware_number(hardware: Hardware, name: str) -> Each | None:
    """A number of hardware; None where it has none, such as limits of a drive without.

    Raises:
        UnknownNameError: there is no such number.
        InputError: it decides when something happens, or the hardware has no such part.
    """
    if name in OF_TIME:
        raise InputError(
            f"{name} decides when something happens, which is one for all runs of a loop; take a loop for every value"
        )
    if name not in PLACES:
        raise UnknownNameError("number of the hardware", name, list(PLACES))
    part: object = hardware
    for field in PLACES[name][:-1]:
        part = getattr(part, field)
    wanted = SPEEDS.get(name.partition(".")[0])
    if part is None or (wanted is not None and not isinstance(part, wanted)):
        raise InputError(f"{name}: the hardware has no [{name.rpartition('.')[0]}]; give it one")
    found: Each | None = getattr(part, PLACES[name][-1])
    return found


def with_numbers(hardware: Hardware, numbers: Mapping[str, float | Sequence[float] | Array]) -> Hardware:
    """The same hardware with other numbers, each one for all actuators or one an actuator.

    Raises:
        UnknownNameError, InputError: as of `hardware_number`, or a number cannot be.
    """
    for name, value in numbers.items():
        hardware_number(hardware, name)
        array = np.asarray(value, dtype=np.float64)
        one = float(array.flat[0]) if array.size and np.all(array == array.flat[0]) else tuple(array.tolist())
        hardware = _replaced(hardware, PLACES[name], one)
    return hardware


def filter_part(cutoff: float, period: float) -> float:
    """What of a new difference a low pass of first order takes in a period."""
    return -math.expm1(-2.0 * math.pi * cutoff * period)


def _replaced(hardware: Hardware, place: tuple[str, ...], value: Each) -> Hardware:
    parts: list[object] = [hardware]
    for field in place[:-1]:
        parts.append(getattr(parts[-1], field))
    made: object = value
    for part, field in zip(reversed(parts), reversed(place), strict=True):
        made = replace(part, **{field: made})  # type: ignore[type-var]
    assert isinstance(made, Hardware)
    return made
