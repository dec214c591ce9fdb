"""Numbers of hardware that differ from run to run: expressions in the loop's equations, arguments of its code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.expressions.graph import Expression
from cutjoint.compile.many.registers import entries
from cutjoint.simulation.hardware import Hardware
from cutjoint.simulation.hardware.fitted import Fitted
from cutjoint.simulation.hardware.numbers import filter_part, with_numbers

FITTED: Mapping[str, str] = {
    "encoder.resolution": "step",
    "encoder.offset": "offset",
    "encoder.noise": "noise",
    "differences.cutoff": "filter_part",
    "tachometer.noise": "speed_noise",
    "drive.limits": "limits",
    "drive.resolution": "command_step",
    "drive.torque_speed.stall": "stall",
    "drive.torque_speed.no_load_speed": "no_load_speed",
}
"""Name -> attribute of `Fitted`; those of backlash are in its `gear`."""
BACKLASH = "drive.backlash."
CUTOFF = "differences.cutoff"


def fitted_with(hardware: Hardware, symbols: Mapping[str, Sequence[Expression]], n: int) -> Fitted:
    """Hardware for n actuators with symbols for some of its numbers.

    Raises:
        UnknownNameError, InputError: see `cutjoint.simulation.hardware.numbers.hardware_number`.
    """
    fitted = Fitted(with_numbers(hardware, dict.fromkeys(symbols, 1.0)), n)  # so that none is left out for being 0
    for name, own in symbols.items():
        values = entries(own)
        if not name.startswith(BACKLASH):
            setattr(fitted, FITTED[name], values)
            continue
        assert fitted.gear is not None
        field = name.removeprefix(BACKLASH)
        fitted.gear = fitted.gear._replace(**{"half": 0.5 * values} if field == "width" else {field: values})
    return fitted


def arguments_of(hardware: Hardware | None, numbers: Mapping[str, Array]) -> list[Array]:
    """What the code takes for numbers of hardware, shape (N, n) each."""
    if hardware is None:
        return []
    period = hardware.clock.period
    part = np.vectorize(lambda cutoff: filter_part(cutoff, period), otypes=[np.float64])
    return [part(rows) if name == CUTOFF else rows for name, rows in numbers.items()]
