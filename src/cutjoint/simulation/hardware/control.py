"""What is between a law and the joints of a run: hardware, the limits of continuous control, or nothing."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import LARGEST, Array, positive
from cutjoint.errors import InputError
from cutjoint.simulation.hardware.values import Clock, Drive, Hardware

Control: TypeAlias = Hardware | Array | None
"""The hardware of sampled control, or the limits of efforts under continuous control, or nothing."""


def control_of(hardware: Hardware | None, rate: float | None, limits: Array | None) -> Control:
    """What is between a law and the joints.

    Args:
        hardware: in place of the other two.
        rate: of the controller [Hz], whose hardware is ideal but for its limits.
        limits: of `limits_of`.

    Raises:
        InputError: hardware is given twice, or the rate is not positive.
    """
    if hardware is not None:
        if not isinstance(hardware, Hardware):
            raise InputError(f"hardware must be Hardware(Clock(rate), ...), found {hardware!r}")
        if rate is not None or limits is not None:
            raise InputError("rate and limits are in the hardware (clock and drive); leave them out beside it")
        return hardware
    if rate is None:
        return limits
    return Hardware(Clock(positive("rate", rate, "Hz")), drive=Drive(None if limits is None else limits.tolist()))


def limits_of(limits: npt.ArrayLike | None, n: int) -> Array | None:
    """The largest efforts that are given for `n` actuators, of shape () or (n,), [N] or [N m].

    Raises:
        InputError: they are something else.
    """
    if limits is None:
        return None
    wanted = f"limits must be one number > 0 or {n} of them, found {limits!r}"
    try:
        array = np.asarray(limits, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(wanted) from error
    if array.shape not in ((), (n,)) or not ((array > 0.0) & ((array <= LARGEST) | np.isinf(array))).all():
        raise InputError(wanted)
    return array
