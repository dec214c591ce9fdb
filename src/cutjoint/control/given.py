"""Efforts that are given over time, whatever the robot does: by a function of time, or by a table of samples.

Between the samples of a table efforts are linear; a table has an end, and nobody knows what comes after it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Frozen
from cutjoint.control.pd import NOTHING
from cutjoint.doors import described, door
from cutjoint.errors import InputError
from cutjoint.motion import Desired
from cutjoint.reprs import line


@door
@dataclass(frozen=True, eq=False)
class EffortTable(Frozen):
    """Samples of efforts; called with a time it gives the efforts then, shape (n,).

    Attributes:
        time: from 0 or before, strictly increasing, shape (m,) [s].
        efforts: shape (m, n), [N] or [N m].

    Raises:
        InputError: shapes do not agree, numbers are not finite, or times do not increase or begin after 0.
    """

    time: Array
    efforts: Array

    __repr__ = line(time="s", efforts="N or N m")

    def __post_init__(self) -> None:
        super().__post_init__()
        time, efforts = self.time, self.efforts
        if time.ndim != 1 or time.size < 2 or efforts.ndim != 2 or len(efforts) != time.size:
            raise InputError(
                f"a table of efforts has at least two times (m,) and efforts (m, n); found shapes {time.shape} and "
                f"{efforts.shape}"
            )
        if not (np.isfinite(time).all() and np.isfinite(efforts).all()):
            raise InputError("times and efforts of a table must be finite")
        if (np.diff(time) <= 0.0).any():
            row = int(np.argmax(np.diff(time) <= 0.0)) + 1
            raise InputError(
                f"times of a table must increase: sample {row + 1} is at {time[row]:g} s after "
                f"{time[row - 1]:g} s; for a step give two samples that are very near"
            )
        if time[0] > 0.0 or time[-1] <= 0.0:
            raise InputError(
                f"a table of efforts begins at 0 s and ends later; this one is from {time[0]:g} s to {time[-1]:g} s"
            )

    def __call__(self, t: float) -> Array:
        """Efforts at `t` [s], linear between the samples, shape (n,).

        Raises:
            InputError: after the last sample.
        """
        time = self.time
        if t > time[-1] * (1.0 + 1e-12):
            raise InputError(f"efforts are given until {time[-1]:g} s; asked for {t:g} s")
        after = min(max(int(np.searchsorted(time, t, side="right")), 1), time.size - 1)
        share = min((t - time[after - 1]) / (time[after] - time[after - 1]), 1.0)
        return np.asarray((1.0 - share) * self.efforts[after - 1] + share * self.efforts[after])


@door
@dataclass(frozen=True)
class GivenEfforts:
    """The efforts that `efforts`, a function of the time [s] or an `EffortTable`, says; shape (n,), [N] or [N m]."""

    efforts: Callable[[float], npt.ArrayLike]

    name = "given efforts"

    __repr__ = line()

    @property
    def duration(self) -> float:
        """How long efforts are given [s]; infinite for a function."""
        return float(self.efforts.time[-1]) if isinstance(self.efforts, EffortTable) else math.inf

    @property
    def gains(self) -> dict[str, list[list[float]]]:
        """None."""
        return {}

    def memory(self, n: int) -> int:
        """No memory; a table must be for n actuators."""
        if isinstance(self.efforts, EffortTable) and self.efforts.efforts.shape[1] != n:
            raise InputError(f"the efforts are for {self.efforts.efforts.shape[1]} actuators, the robot has {n}")
        return 0

    def effort(self, desired: Desired, q: Array, v: Array, memory: Array) -> Array:
        """As given, shape (n,)."""
        return efforts_of(self.name, self.efforts(desired.t))

    def memory_rate(self, desired: Desired, q: Array, v: Array, asked: Array, given: Array) -> Array:
        """Nothing to remember."""
        return NOTHING


def efforts_of(name: str, answer: object) -> Array:
    """An answer of a law called `name` as an array.

    Raises:
        InputError: it is none.
    """
    try:
        efforts = np.asarray(answer)
        if answer is not None and efforts.dtype.kind in "biufO":  # texts and complex numbers are no efforts
            return efforts.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        pass
    raise InputError(f"controller '{name}' must return efforts, one an actuator; it returned {described(answer)}")
