"""SciPy's adaptive explicit Runge-Kutta methods, one step at a time.

Every step starts a fresh solver at the state that the loop hands in, with the step length that the last one proposed;
so the state may be put back onto the loops in between.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from cutjoint.arrays import Array, positive
from cutjoint.errors import UnknownNameError
from cutjoint.reprs import line
from cutjoint.simulation.integrators.method import Field, Step, StepError

if TYPE_CHECKING:
    from scipy.integrate import OdeSolver

METHODS = ("DOP853", "RK45", "RK23")


@dataclass(frozen=True)
class Adaptive:
    """`method` of `scipy.integrate` (DOP853 of order 8, RK45, RK23), with relative and absolute tolerance."""

    relative: float = 1e-9
    absolute: float = 1e-12
    method: str = "DOP853"

    __repr__ = line()

    def __post_init__(self) -> None:
        positive("relative tolerance", self.relative)
        positive("absolute tolerance", self.absolute)
        if self.method not in METHODS:
            raise UnknownNameError("integration method", self.method, METHODS)

    interpolates: ClassVar[bool] = True

    @property
    def name(self) -> str:
        """Method and tolerances."""
        return f"{self.method}, tolerances {self.relative:g} and {self.absolute:g}"

    def _solver(self, field: Field, t: float, y: Array, end: float, h: float | None) -> OdeSolver:
        from scipy import integrate

        allowed = np.full(y.size, self.absolute)
        allowed[-1] = np.inf
        return getattr(integrate, self.method)(
            field, t, y, end, rtol=self.relative, atol=allowed, first_step=None if h is None else min(h, end - t)
        )

    def first(self, field: Field, t: float, y: Array, slope: Array, span: float) -> float:
        """SciPy's own choice."""
        return float(self._solver(field, t, y, t + span, None).h_abs)

    def step(self, field: Field, t: float, y: Array, slope: Array, h: float, end: float, span: float) -> Step:
        """One accepted step; see `Integrator.step`."""
        known: list[Array] = [slope]
        # The solver asks for the slope at its start first, which is known.
        solver = self._solver(lambda s, x: known.pop() if known else field(s, x), t, y, end, h)
        message = solver.step()
        if solver.status == "failed":
            raise StepError(str(message))
        return Step(float(solver.t), solver.y, solver.f, float(solver.h_abs), solver.dense_output())
