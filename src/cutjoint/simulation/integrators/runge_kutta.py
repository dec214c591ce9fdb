"""The classical Runge-Kutta method of order 4 with a fixed step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from cutjoint.arrays import Array, positive
from cutjoint.simulation.integrators.method import Field, Step


@dataclass(frozen=True)
class RungeKutta4:
    """Steps of `h` [s]; a stretch that h does not divide is cut into equal, slightly shorter steps."""

    h: float = 1e-3

    def __post_init__(self) -> None:
        positive("step", self.h, "s")

    interpolates: ClassVar[bool] = False

    @property
    def name(self) -> str:
        """Method and step."""
        return f"RK4, step {self.h:g} s"

    def first(self, field: Field, t: float, y: Array, slope: Array, span: float) -> float:
        """Always h."""
        return self.h

    def step(self, field: Field, t: float, y: Array, slope: Array, h: float, end: float, span: float) -> Step:
        """One step; see `Integrator.step`."""
        parts = max(1, math.ceil((end - t) / self.h * (1.0 - 1e-9)))
        h = (end - t) / parts
        second = field(t + 0.5 * h, y + 0.5 * h * slope)
        third = field(t + 0.5 * h, y + 0.5 * h * second)
        fourth = field(t + h, y + h * third)
        y_new = y + h / 6.0 * (slope + 2.0 * (second + third) + fourth)
        return Step(end if parts == 1 else t + h, y_new, None, self.h)
