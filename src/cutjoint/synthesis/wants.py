"""What is wanted of a design: quantities to be as large or as small as can be, and bounds that hold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from cutjoint.arrays import Frozen
from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.reprs import line
from cutjoint.synthesis.quantities import QUANTITIES, Goal, Options


@dataclass(frozen=True, eq=False)
class Want(Frozen):
    """One thing that is wanted.

    Attributes:
        quantity: a row of `QUANTITIES`.
        options: of the quantity; those that are left out are as by default.
        goal: "most" or "least"; None where it is only kept within bounds.
        at_least, at_most: bounds, in the quantity's unit.
    """

    quantity: str
    options: Mapping[str, float | str]
    goal: Goal | None = None
    at_least: float | None = None
    at_most: float | None = None

    __repr__ = line("quantity", "options", "goal", "at_least", "at_most")

    def __post_init__(self) -> None:
        if self.quantity not in QUANTITIES:
            raise UnknownNameError("quantity", self.quantity, tuple(QUANTITIES))
        row = QUANTITIES[self.quantity]
        for name in self.options:
            if name not in row.options:
                raise UnknownNameError(f"option of {self.quantity}", name, tuple(row.options))
        filled = {name: self.options.get(name, default) for name, (_, default) in row.options.items()}
        for name, (about, _) in row.options.items():
            if filled[name] is None:
                raise InputError(f"{self.quantity} needs {name}: {about}")
        object.__setattr__(self, "options", {name: one for name, one in filled.items() if one is not None})
        if self.goal is None and self.at_least is None and self.at_most is None:
            raise InputError(f"{self.quantity} is neither to be most or least nor within bounds: say which")
        for bound in (self.at_least, self.at_most):
            if bound is not None and not math.isfinite(bound):
                raise InputError(f"{self.quantity}: a bound must be a finite number, found {bound}")
        if self.at_least is not None and self.at_most is not None and self.at_least > self.at_most:
            raise InputError(f"{self.quantity}: at_least {self.at_least:g} is more than at_most {self.at_most:g}")
        super().__post_init__()

    @property
    def name(self) -> str:
        """The quantity, and where it is along a trajectory other than the usual one, which."""
        spec = self.options.get("trajectory", "about-home")
        return self.quantity if spec == "about-home" else f"{self.quantity} ({spec})"

    def unit(self, chain: ClosedChain, axes: int) -> str:
        """SI unit for a robot whose workspace has so many axes."""
        turns = all(one.kind == "rotation" for one in chain.actuators)
        extent = {1: "m", 2: "m2", 3: "m3"}.get(axes, "")
        return QUANTITIES[self.quantity].unit.format(effort="N m" if turns else "N", extent=extent)

    def missed_by(self, found: float) -> float:
        """By how much a value is beyond the bounds, as a part of the bound; 0 where it is within."""
        missed = 0.0
        if self.at_least is not None and found < self.at_least:
            missed = (self.at_least - found) / (abs(self.at_least) or 1.0)
        if self.at_most is not None and found > self.at_most:
            missed = (found - self.at_most) / (abs(self.at_most) or 1.0)
        return missed


def of_want(options: Options) -> str:
    """Options in words."""
    return ", ".join(f"{name} {value}" for name, value in options.items())
