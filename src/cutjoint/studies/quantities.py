"""What can be kept of a run: a number, or one an actuator."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile import Many
from cutjoint.mechanism import Actuator
from cutjoint.reprs import line

Places = Callable[[], Array]
"""Distances of the tool from where it shall be, at all samples of all runs, shape (N, m) [m]."""


@dataclass(frozen=True)
class Quantity:
    """What can be kept of a run.

    Attributes:
        about: in words.
        unit: of an actuator that slides, and of one that turns; of a number for the whole robot twice the same.
        of: the numbers, shape (N, n) or (N,).
        each: whether it is a number an actuator.
        sampled: whether it is made of samples, and not of every step.
        tool: whether the robot must have a tool.
    """

    about: str
    unit: tuple[str, str]
    of: Callable[[Many, Places], Array]
    each: bool = True
    sampled: bool = False
    tool: bool = False

    __repr__ = line("about")

    def columns(self, name: str, actuators: Sequence[Actuator]) -> dict[str, str]:
        """The columns of a table that hold it, and their units."""
        if not self.each:
            return {name: self.unit[0]}
        return {f"{name}_{one.name}": self.unit[one.kind == "rotation"] for one in actuators}


def _over_time(many: Many, values: Array) -> Array:
    """The integral over time by the trapezoidal rule; values (N, m, ...)."""
    return np.asarray(np.trapezoid(values, many.time, axis=1))


def _root_mean(many: Many, squares: Array) -> Array:
    return np.asarray(np.sqrt(_over_time(many, squares) / (many.time[-1] - many.time[0])))


def _power(many: Many) -> Array:
    return many.effort * many.v


QUANTITIES: Mapping[str, Quantity] = {
    "error_rms": Quantity("root mean square of desired minus actual", ("m", "rad"), lambda many, _: many.error_rms),
    "error_max": Quantity("largest |desired minus actual|", ("m", "rad"), lambda many, _: many.error_max),
    "effort_max": Quantity("largest |effort|", ("N", "N m"), lambda many, _: many.effort_max),
    "effort_rms": Quantity(
        "root mean square effort", ("N", "N m"), lambda many, _: _root_mean(many, many.effort**2), sampled=True
    ),
    "speed_max": Quantity(
        "largest |speed|", ("m/s", "rad/s"), lambda many, _: np.abs(many.v).max(axis=1), sampled=True
    ),
    "power_max": Quantity(
        "largest |power|", ("W", "W"), lambda many, _: np.abs(_power(many)).max(axis=1), sampled=True
    ),
    "energy": Quantity(
        "that all actuators give and take, the integral of |power|",
        ("J", "J"),
        lambda many, _: _over_time(many, np.abs(_power(many))).sum(axis=1),
        each=False,
        sampled=True,
    ),
    "tool_error_rms": Quantity(
        "root mean square distance of the tool from its way",
        ("m", "m"),
        lambda many, places: _root_mean(many, places() ** 2),
        each=False,
        sampled=True,
        tool=True,
    ),
    "tool_error_max": Quantity(
        "largest distance of the tool from its way",
        ("m", "m"),
        lambda many, places: places().max(axis=1),
        each=False,
        sampled=True,
        tool=True,
    ),
}
"""Name -> what it is.  A new quantity is a row."""
USUAL = ("error_rms", "error_max", "effort_max")
"""Those that are kept where nothing is said: they are taken over all steps, and cost nothing."""
