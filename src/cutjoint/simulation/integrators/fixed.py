"""Methods of fixed step: classical Runge-Kutta of order four, and the midpoint rule of order two."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from cutjoint.arrays import Array, positive
from cutjoint.errors import UnknownNameError
from cutjoint.reprs import line
from cutjoint.simulation.integrators.method import Field, Step


@dataclass(frozen=True)
class FixedStep:
    """Steps of `h` [s]; what `h` does not divide is cut into equal, slightly shorter steps."""

    h: float = 1e-3

    __repr__ = line(h="s")

    def __post_init__(self) -> None:
        positive("step", self.h, "s")

    interpolates: ClassVar[bool] = False
    title: ClassVar[str]

    @property
    def name(self) -> str:
        """Method and step."""
        return f"{self.title}, step {self.h:g} s"

    def first(self, field: Field, t: float, y: Array, slope: Array, span: float) -> float:
        """Always h."""
        return self.h

    def step(self, field: Field, t: float, y: Array, slope: Array, h: float, end: float, span: float) -> Step:
        """One step; see `Integrator.step`."""
        parts = steps_within(end - t, self.h)
        h = (end - t) / parts
        return Step(end if parts == 1 else t + h, self.advanced(field, t, y, slope, h), None, self.h)

    def advanced(self, field: Field, t: float, y: Array, slope: Array, h: float) -> Array:
        """The state after a step of `h` [s]."""
        raise NotImplementedError


@dataclass(frozen=True)
class RungeKutta4(FixedStep):
    """The classical method of order 4."""

    title: ClassVar[str] = "RK4"

    __repr__ = line(h="s")

    def advanced(self, field: Field, t: float, y: Array, slope: Array, h: float) -> Array:
        """Four slopes."""
        second = field(t + 0.5 * h, y + 0.5 * h * slope)
        third = field(t + 0.5 * h, y + 0.5 * h * second)
        fourth = field(t + h, y + h * third)
        return y + h / 6.0 * (slope + 2.0 * (second + third) + fourth)


@dataclass(frozen=True)
class Midpoint(FixedStep):
    """The explicit midpoint rule of order 2: half the work of `RungeKutta4` a step."""

    title: ClassVar[str] = "midpoint"

    __repr__ = line(h="s")

    def advanced(self, field: Field, t: float, y: Array, slope: Array, h: float) -> Array:
        """Two slopes."""
        return y + h * field(t + 0.5 * h, y + 0.5 * h * slope)


FIXED_STEP: Mapping[str, type[FixedStep]] = {"rk4": RungeKutta4, "midpoint": Midpoint}
"""Methods of fixed step by name."""


def fixed_step(name: str) -> type[FixedStep]:
    """The method of that name.

    Raises:
        UnknownNameError: there is none.
    """
    if name not in FIXED_STEP:
        raise UnknownNameError("method of fixed step", name, list(FIXED_STEP))
    return FIXED_STEP[name]


def steps_within(span: float, step: float) -> int:
    """How many steps of at most `step` [s] a span of time [s] is cut into."""
    return max(1, math.ceil(span / step * (1.0 - 1e-9)))
