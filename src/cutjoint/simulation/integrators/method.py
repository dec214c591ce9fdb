"""What the loop needs of an integrator: one step at a time, with all state handed in and out.

One-step methods only.  So the loop may put a state back onto its loops, change the chart of a rotation or change the
effort between two steps, and nothing that the integrator remembers becomes wrong.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from cutjoint.arrays import Array, Values
from cutjoint.errors import CutjointError
from cutjoint.reprs import line

Field = Callable[[float, Array], Array]
"""Right hand side (t, y) -> dy/dt; not-a-number entries say that y is out of bounds."""


class StepError(CutjointError):
    """No step is small enough."""


@dataclass(frozen=True, eq=False)
class Step(Values):
    """One accepted step.

    Attributes:
        t: new time [s].
        y: new state.
        slope: dy/dt at (t, y) where the method computed it on its way, else None.
        ahead: length that the method proposes for the next step [s].
        between: interpolant t -> y over the step, where the method has one.
    """

    t: float
    y: Array
    slope: Array | None
    ahead: float
    between: Callable[[float], Array] | None = None

    __repr__ = line("t", "y", "ahead", t="s", ahead="s")


class Integrator(Protocol):
    """A one-step method."""

    @property
    def name(self) -> str:
        """Method and settings, for tables and result files."""

    @property
    def interpolates(self) -> bool:
        """Whether its steps come with an interpolant; otherwise steps end where a sample is wanted."""

    def first(self, field: Field, t: float, y: Array, slope: Array, span: float) -> float:
        """Length of the first step [s] of a run over `span` [s]."""

    def step(self, field: Field, t: float, y: Array, slope: Array, h: float, end: float, span: float) -> Step:
        """One step from (t, y), where dy/dt = `slope`, of about `h` [s] and never past `end`.

        The last component of y (the work of the actuators) rides along and does not steer the step.

        Raises:
            StepError: no step is small enough.
        """
