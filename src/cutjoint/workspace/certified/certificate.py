"""What is known of a box afterwards: certified, refused with a counter-example, or open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Frozen, Values
from cutjoint.reprs import one_line, quoted, short

Status = Literal["certified", "refused", "open"]
Why = Literal["unreachable", "joint limit", "type-1 singular", "type-2 singular", "another assembly mode"]


@dataclass(frozen=True, eq=False)
class CounterExample(Frozen):
    """A point of a box that does not hold what is asked.

    Attributes:
        at: led coordinates by name, [m] or [rad].
        why: what is wrong there.
        joint: whose limit it is; empty otherwise.
        shown: how it was found to be so, in a sentence.
    """

    at: Mapping[str, float]
    why: Why
    joint: str
    shown: str

    def __repr__(self) -> str:
        place = [f"{name}={short(value, 'rad' if name.startswith('r') else 'm')}" for name, value in self.at.items()]
        return one_line("CounterExample", [quoted(self.why), *place])


@dataclass(frozen=True, eq=False)
class Certificate(Values):
    """The answer to whether a box of tool coordinates is wholly inside and free of singularities.

    Attributes:
        robot: its name.
        names, units: coordinates of the tool that the box is over, and [m] or [rad] of each.
        lower, upper: ends of the box, shape (axes,).
        held: the other led coordinates -> [m] or [rad].
        status: "certified", "refused" (see `counter_example`) or "open": neither was shown within the budget.
        counter_example: where it is refused.
        part: of the box that is proven, 0 to 1; 1 where it is certified, and less where not.
        lows, highs: ends of the sub-boxes that were left in the end, shape (boxes, axes).
        proven: which of these are proven, shape (boxes,).
        margins: 1 less a bound of how much the equations' derivative changes within a sub-box, for which 1 would be
            singular; not above 0 where nothing is proven, shape (boxes,).
        looked: how many sub-boxes were looked at.
    """

    robot: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    lower: Array
    upper: Array
    held: Mapping[str, float]
    status: Status
    counter_example: CounterExample | None
    part: float
    lows: Array
    highs: Array
    proven: npt.NDArray[np.bool_]
    margins: Array
    looked: int

    def __repr__(self) -> str:
        ends = zip(self.names, self.lower.tolist(), self.upper.tolist(), self.units, strict=True)
        box = [f"{name}={low:.4g}..{high:.4g} {unit}" for name, low, high, unit in ends]
        return one_line("Certificate", [quoted(self.status), quoted(self.robot), *box, f"part={self.part:.3g}"])

    @property
    def is_certified(self) -> bool:
        """Whether the whole box is proven."""
        return self.status == "certified"

    @property
    def doubtful(self) -> dict[str, tuple[float, float]]:
        """The smallest sub-box that is not proven, ends by name, [m] or [rad]: most likely a singularity or a limit is
        in it or close by.  Empty where all are proven."""
        left = np.flatnonzero(~self.proven)
        if not len(left):
            return {}
        k = left[np.prod((self.highs - self.lows)[left] / (self.upper - self.lower), axis=1).argmin()]
        return dict(zip(self.names, zip(self.lows[k].tolist(), self.highs[k].tolist(), strict=True), strict=True))
