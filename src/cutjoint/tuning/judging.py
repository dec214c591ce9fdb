"""How the loop of a case does with given gains: runs, margins and step responses."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import InputError
from cutjoint.tuning.case import Gains, TuningCase
from cutjoint.tuning.margins import LoopMargins, margins_of, sensitivity_peak
from cutjoint.tuning.runs import CaseRuns
from cutjoint.tuning.steps import StepResponse, step_responses
from cutjoint.tuning.values import JudgedGains

ROUGHLY = 120
"""Frequencies at which the worst posture is looked for."""


def worst_margins(case: TuningCase, gains: Gains) -> LoopMargins:
    """Margins at the posture and with the payload where the sensitivity peaks highest, or a pole grows fastest.

    Raises:
        MissingPackageError: python-control is not installed.
    """
    loops = case.linear(gains)
    names = tuple(one.name for one in case.robot.actuators)
    unstable = [one for one in loops if not one.stable]
    if unstable:
        return margins_of(min(unstable, key=lambda one: one.decay), names)
    return margins_of(max(loops, key=lambda one: sensitivity_peak(one, ROUGHLY)), names)


def judged(case: TuningCase, runs: CaseRuns, label: str, gains: Mapping[str, Array]) -> JudgedGains:
    """How the loop does with some gains."""
    n = case.robot.n
    each = {name: np.broadcast_to(np.asarray(one), (n,)) for name, one in gains.items()}
    figures = runs.figures({name: one[None, :] for name, one in each.items()}, whole=True)
    margins = worst_margins(case, gains)
    failed = figures.failed
    steps: tuple[StepResponse, ...] = ()
    if margins.stable:
        try:
            steps = step_responses(case, gains, margins.decay, float(np.abs(margins.poles).max()))
        except InputError as error:
            failed = failed or str(error)
    return JudgedGains(
        label,
        {name: np.asarray(one, dtype=np.float64) for name, one in gains.items()},
        float(figures.rms[0]),
        float(figures.late[0]),
        float(figures.largest[0]),
        np.where(np.isfinite(figures.peak[0]), figures.peak[0], math.inf),
        margins,
        steps,
        failed,
    )
