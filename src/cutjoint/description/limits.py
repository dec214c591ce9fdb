"""The range of a joint, and how fast and strong it may be driven, as far as a file says so."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cutjoint.reprs import line


@dataclass(frozen=True)
class Limits:
    """Range of a joint; None where the file says nothing (which is not the same as 0)."""

    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    effort: float | None = None

    __repr__ = line(lower="m or rad", upper="m or rad", velocity="m/s or rad/s", effort="N or N m")

    @property
    def bounded(self) -> bool:
        """Whether the range ends anywhere."""
        return self.lower is not None or self.upper is not None

    @property
    def ends(self) -> tuple[float, float]:
        """Lower and upper end of the range, infinite where it does not end."""
        return -math.inf if self.lower is None else self.lower, math.inf if self.upper is None else self.upper
