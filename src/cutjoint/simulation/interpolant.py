"""The state between the ends of a step.

It is the interpolant of the method, or else the cubic through states and slopes at both ends (Hermite), whose error is
of the order of the step to the fourth.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from cutjoint.arrays import Array
from cutjoint.simulation.coupled import Coupled
from cutjoint.simulation.integrators import Step


class Begin(NamedTuple):
    """Where a step begins: time [s], flat vector of the state, and its slope."""

    t: float
    y: Array
    slope: Array


def between(coupled: Coupled, begin: Begin, step: Step) -> Callable[[float], Array]:
    """The flat vector of the state at any time [s] of a step."""
    if step.between is not None:
        return step.between
    slope = coupled.field(step.t, step.y) if step.slope is None else step.slope
    return hermite(begin, Begin(step.t, step.y, slope))


def hermite(start: tuple[float, Array, Array], end: tuple[float, Array, Array]) -> Callable[[float], Array]:
    """The cubic in time through time [s], values and slopes at both ends."""
    t0, y0, f0 = start
    t1, y1, f1 = end
    h = t1 - t0

    def between(t: float) -> Array:
        s = (t - t0) / h
        rest = 1.0 - s
        values = rest * rest * (1.0 + 2.0 * s) * y0 + s * s * (1.0 + 2.0 * rest) * y1
        return values + s * rest * h * (rest * f0 - s * f1)

    return between
