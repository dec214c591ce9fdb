"""The Dormand-Prince 5(4) pair with the step rules of a widely used adaptive solver, to the letter.

J. R. Dormand, P. J. Prince: A family of embedded Runge-Kutta formulae. J. Comput. Appl. Math. 6 (1980) 19-26.

Where a mean is taken over the steps of a solver, as Table 3 of Elkady et al. 2008 seems to do, the steps matter as much
as the model.  The rules here are: error = step times the largest component of |error estimate| / max(|y|, |y_new|,
absolute / relative); accepted when it is at most `relative`; first step 0.8 relative^(1/5) over the largest scaled
slope; no step longer than a tenth of the run; after a failure the step shrinks by 0.8 (relative / error)^(1/5), not
below a tenth, and then by half; after a success it grows by (relative / error)^(1/5) / 1.25, at most fivefold, and not
right after a failure; a step that would come within 10 % of the end is stretched to it.  For plain accuracy take
`Adaptive`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from cutjoint.arrays import Array, positive
from cutjoint.reprs import line
from cutjoint.simulation.integrators.method import Field, Step, StepError

NODES = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
WEIGHTS = np.array(
    [
        [0, 0, 0, 0, 0, 0],
        [1 / 5, 0, 0, 0, 0, 0],
        [3 / 40, 9 / 40, 0, 0, 0, 0],
        [44 / 45, -56 / 15, 32 / 9, 0, 0, 0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0, 0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
ESTIMATE = np.array([71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
POWER = 1 / 5
# Smallest step that still moves t, in units of its spacing.
SMALLEST = 16.0


@dataclass(frozen=True)
class DormandPrince:
    """Adaptive steps of order 5, with relative and absolute tolerance."""

    relative: float = 1e-9
    absolute: float = 1e-10

    __repr__ = line()

    def __post_init__(self) -> None:
        positive("relative tolerance", self.relative)
        positive("absolute tolerance", self.absolute)

    interpolates: ClassVar[bool] = False

    @property
    def name(self) -> str:
        """Method and tolerances."""
        return f"Dormand-Prince 5(4), tolerances {self.relative:g} and {self.absolute:g}"

    def first(self, field: Field, t: float, y: Array, slope: Array, span: float) -> float:
        """0.8 relative^(1/5) over the largest scaled slope, at most a tenth of the run."""
        scaled = np.max(np.abs(slope[:-1]) / np.maximum(np.abs(y[:-1]), self.absolute / self.relative))
        rate = float(scaled) / (0.8 * self.relative**POWER)
        longest = 0.1 * span
        return 1.0 / rate if longest * rate > 1.0 else longest

    def step(self, field: Field, t: float, y: Array, slope: Array, h: float, end: float, span: float) -> Step:
        """One accepted step; see `Integrator.step`."""
        h = min(h, 0.1 * span)
        last = 1.1 * h >= end - t
        if last:
            h = end - t
        slopes = np.empty((7, y.size))
        slopes[0] = slope
        floor = self.absolute / self.relative
        failed = False
        while True:
            for stage in range(1, 7):
                y_new = y + h * (WEIGHTS[stage, :stage] @ slopes[:stage])
                slopes[stage] = field(t + NODES[stage] * h, y_new)
            size = np.maximum(np.maximum(np.abs(y), np.abs(y_new)), floor)[:-1]
            error = h * float(np.max(np.abs(ESTIMATE @ slopes)[:-1] / size))
            if error <= self.relative:
                break
            # An error that is not a number fails here too, and asks for the shortest retry.
            shrink = 0.8 * (self.relative / error) ** POWER if np.isfinite(error) else 0.0
            h *= 0.5 if failed else max(0.1, shrink)
            failed, last = True, False
            if h <= SMALLEST * np.spacing(t):
                raise StepError(f"the error stays above the tolerance down to steps of {h:.3g} s")
        ahead = h
        if not failed:
            growth = 1.25 * (error / self.relative) ** POWER
            ahead = h / growth if growth > 0.2 else 5.0 * h
        return Step(end if last else t + h, y_new, slopes[6], ahead)
