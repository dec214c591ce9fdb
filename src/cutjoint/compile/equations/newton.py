"""When Newton's method is on its way and when it has arrived: the rule of all compiled closing of loops.

Sizes are dimensionless: in robot lengths or radians.  Functions take a number, or an array of one a row.
"""

from __future__ import annotations

from typing import TypeVar

from cutjoint import tolerances
from cutjoint.arrays import Array

STEPS = 8
"""How many steps it gets."""
SHRINKS = 0.5
"""A step, or what is left open, is at most this part of the one before, or the method does not converge."""
RESTS = 1e-13
"""Rows that are closed side by side stop together, where all steps are below this."""

Size = TypeVar("Size", float, Array)


def longest(before: Size | None) -> Size | float:
    """The longest step for which the branch is plain: the first against the links, others against the one `before`."""
    return tolerances.STRIDE.value if before is None else SHRINKS * before + 1e-9


def arrived(gap: float, before: float) -> bool:
    """Whether a posture open by `gap` is as closed as rounding lets it be; it was open by `before`."""
    return gap < 1e-15 or (gap < tolerances.CLOSURE.value and gap > 0.1 * before)
