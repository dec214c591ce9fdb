"""What the paths of a study name: numbers of the robot, gains, starting coordinates, and numbers of hardware."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled
from cutjoint.compile.sources.interface import PAYLOAD
from cutjoint.compile.sources.parameters import Parameters
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Mechanism
from cutjoint.simulation.hardware import Hardware
from cutjoint.simulation.hardware.numbers import OF_TIME, PLACES, hardware_number, with_numbers
from cutjoint.studies.spreads import Spread

GAINS, START, HARDWARE = "gains.", "start.", "hardware."
LOADS = ("load.", "loads.", "wrench.")
SHORT: Mapping[str, str] = {
    "noise": "encoder.noise",
    "resolution": "encoder.resolution",
    "offset": "encoder.offset",
    "filter": "differences.cutoff",
    "limits": "drive.limits",
    "rate": "clock.rate",
    "tick": "clock.tick",
    "jitter": "clock.jitter",
    "delay": "encoder.delay",
    "command_delay": "drive.delay",
}
"""The short keys of a study's [hardware] -> the numbers that they stand for."""


def is_of_robot(path: str) -> bool:
    """Whether a path is a number of the robot."""
    return not path.startswith((GAINS, START, HARDWARE))


def number_name(path: str) -> str:
    """`hardware.noise` -> `encoder.noise`, as `cutjoint.simulation.hardware.numbers` has it."""
    name = path.removeprefix(HARDWARE)
    return SHORT.get(name, name)


def nominal_of(model: Mechanism, gains: Mapping[str, npt.ArrayLike], hardware: Hardware | None, path: str) -> float:
    """The value of a path as it is; of numbers that differ from actuator to actuator 1, which scales them.

    Raises:
        UnknownNameError: no such path.
        InputError: it names several numbers, or something that cannot vary.
    """
    if not is_of_robot(path):
        own = own_value(model, gains, hardware, path)
        return float(own) if own.ndim == 0 else 1.0
    if path.startswith(LOADS):
        raise InputError(f"'{path}': runs of a study have no loads from outside; a mass at the tool is '{PAYLOAD}'")
    if isinstance(model, ClosedChain):
        parameters = Parameters(model.description, [path])
        if len(parameters.names) != 1:
            raise InputError(f"'{path}' is {len(parameters.names)} numbers; vary one: {', '.join(parameters.names)}")
        return float(parameters.nominal[0])
    return compiled(model, parameters=[path]).nominal[path]


def own_value(
    model: Mechanism, gains: Mapping[str, npt.ArrayLike], hardware: Hardware | None, path: str
) -> npt.NDArray[np.float64]:
    """The value of a gain, start, or number of hardware, shape () or (n,); errors as of `nominal_of`."""
    if path.startswith(START):
        names = [one.name for one in model.actuators]
        if path.removeprefix(START) not in names:
            raise UnknownNameError("actuator that starts elsewhere", path.removeprefix(START), names)
        return np.zeros(())
    if path.startswith(HARDWARE):
        return np.asarray(_hardware_value(hardware, path), dtype=np.float64)
    gain = np.asarray(gains[path.removeprefix(GAINS)], dtype=np.float64)
    if gain.ndim > 1:
        raise InputError(f"{path} is a matrix, and cannot vary; give a number, or one an actuator")
    return gain


def _hardware_value(hardware: Hardware | None, path: str) -> npt.ArrayLike:
    name = number_name(path)
    if hardware is None:
        raise InputError(f"{path} varies, and a case has no [hardware]; give it one, with its rate")
    if name in OF_TIME:
        raise InputError(
            f"{path} decides when something happens, which is one for all runs of a case; give several [[hardware]] "
            "with another one each: all are cases, with the same samples"
        )
    if name not in PLACES:
        known = [*(short for short, one in SHORT.items() if one in PLACES), *PLACES]
        raise UnknownNameError("number of the hardware", name, [HARDWARE + one for one in known])
    found = hardware_number(hardware, name)
    return 0.0 if found is None else found


def check_bound(model: Mechanism, hardware: Hardware | None, path: str, bound: float, spread: Spread) -> None:
    """Whether a path may have the value at an end of its range.

    Raises:
        InputError: it may not.
    """
    try:
        if path.startswith(GAINS):
            if bound < 0.0:
                raise InputError(f"{path} must be >= 0, found {bound:.6g}")
        elif path.startswith(HARDWARE):
            assert hardware is not None
            with_numbers(hardware, {number_name(path): bound})
        elif path.startswith(START):
            return
        elif isinstance(model, ClosedChain):
            Parameters(model.description, [path]).columns({path: bound})
        elif path == PAYLOAD and bound < 0.0:
            raise InputError(f"payload must be a mass >= 0, found {bound:.6g}")
        else:
            _ = compiled(model, parameters=[path]).with_parameters({path: bound}).plain
    except InputError as error:
        cut = ", four standard deviations from the mean" if spread.kind == "normal" else ""
        raise InputError(f"{error} [{path} at the end of its range{cut}]") from error
