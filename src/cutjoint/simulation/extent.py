"""How much a run may be: more than these is a slip in a unit, and would take weeks or fill the memory."""

from __future__ import annotations

from cutjoint.errors import InputError
from cutjoint.simulation.integrators import Integrator
from cutjoint.simulation.integrators.fixed import FixedStep

LONGEST = 1e8
"""[s], three years."""
MOST_STEPS = 1e9
MOST_RECORDS = 2e7
"""Samples of a result: some gigabytes."""


def check_extent(span: float, spacing: float, method: Integrator) -> None:
    """Raises InputError where a run of `span` [s] with samples every `spacing` [s] is out of all measure."""
    if span > LONGEST:
        raise InputError(f"duration must be at most {LONGEST:g} s, found {span:g} s")
    if isinstance(method, FixedStep) and span / method.h > MOST_STEPS:
        raise InputError(
            f"a step of {method.h:g} s is {span / method.h:.2g} steps in a run of {span:g} s; up to {MOST_STEPS:g} can "
            "be run"
        )
    if span / spacing > MOST_RECORDS:
        raise InputError(
            f"a sample every {spacing:g} s is {span / spacing:.2g} samples in a run of {span:g} s; up to "
            f"{MOST_RECORDS:g} can be kept"
        )
