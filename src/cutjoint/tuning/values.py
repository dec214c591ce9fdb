"""What tuning gives: gains, how the loop does with them beside others, and what the way they were found leaves open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, Frozen, Values
from cutjoint.reprs import line
from cutjoint.tuning.margins import LoopMargins
from cutjoint.tuning.steps import StepResponse


@dataclass(frozen=True, eq=False)
class JudgedGains(Frozen):
    """How a loop does with some gains: on its reference, near rest, and on a step.

    Attributes:
        label: whose gains these are.
        gains: by name, a number or one an actuator.
        rms: root mean square of the actuators' errors, [m] or [rad] (where some slide and some turn, those that slide
            in lengths of the robot), of the worst payload and noise.
        late: largest error along any axis from the tuning's `after` on, of the tool [m] or the actuators, in the
            tuning's `error_unit`.
        largest: the same over the whole run.
        peak: largest effort of every actuator, shape (n,) [N] or [N m].
        margins: at the posture and with the payload where they are least.
        steps: responses of every actuator; none where the loop is unstable.
        failed: why a run ended early, or "".
    """

    label: str
    gains: Mapping[str, Array]
    rms: float
    late: float
    largest: float
    peak: Array
    margins: LoopMargins
    steps: tuple[StepResponse, ...]
    failed: str = ""

    __repr__ = line("label", "rms", "late", "peak", peak="N or N m", rms="m or rad", late="m or rad")


@dataclass(frozen=True, eq=False)
class Tuning(Values):
    """Gains that were found.

    Attributes:
        robot, law: names.
        actuators: names of the robot's.
        by: how the gains were found, in words.
        units: of the gains, by name.
        effort_units: of the actuators.
        of: whether late errors are those of the tool or of the actuators.
        error_unit: of late errors.
        after: from when on they count [s].
        rows: the loop with the gains found, then with others to compare.
        free: what the way they were found does not fix, in sentences.
        told: what was chosen or left out, in sentences.
        unmet: what was asked for and does not hold with the gains found, in sentences.
    """

    robot: str
    law: str
    actuators: tuple[str, ...]
    by: str
    units: Mapping[str, str]
    effort_units: tuple[str, ...]
    of: str
    error_unit: str
    after: float
    rows: tuple[JudgedGains, ...]
    free: tuple[str, ...] = ()
    told: tuple[str, ...] = ()
    unmet: tuple[str, ...] = ()

    __repr__ = line("robot", "law", "by", "gains")

    @property
    def found(self) -> JudgedGains:
        """The loop with the gains found."""
        return self.rows[0]

    @property
    def gains(self) -> Mapping[str, Array]:
        """The gains found, by name; `cutjoint.control.law(name, model, gains)` takes them."""
        return self.found.gains


def in_words(gains: Mapping[str, Array], units: Mapping[str, str]) -> str:
    """Gains with their units, in one line."""
    parts = []
    for name, value in gains.items():
        numbers = ", ".join(f"{one:.6g}" for one in np.ravel(value))
        parts.append(f"{name} = {numbers if np.ndim(value) == 0 else f'({numbers})'} {units.get(name, '')}".rstrip())
    return ", ".join(parts)
