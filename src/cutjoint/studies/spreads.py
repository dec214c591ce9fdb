"""Spreads: where the values of something that varies come from, as a map from numbers between 0 and 1.

A normal spread is cut off at four standard deviations, which leaves out six values in 100 000: so that it has a least
and a largest value, which are looked at before a study begins.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cutjoint.arrays import Array
from cutjoint.reprs import line

Kind = Literal["uniform", "log-uniform", "normal", "relative", "values"]
KINDS: Mapping[str, str] = {
    "uniform": "[least, largest]",
    "log-uniform": "[least, largest], both > 0",
    "normal": "[mean, standard deviation]",
    "relative": "a part of its own value, such as 0.05 for 5 % more or less",
    "values": "a list of numbers",
}
CUT = 4.0
"""Standard deviations at which a normal spread is cut off."""


@dataclass(frozen=True)
class Spread:
    """Where values come from.

    Attributes:
        kind: see `KINDS`.
        numbers: as the kind has them; of "relative" the part, then the value that it is of, once it is known.
        steps: how many evenly spread values a grid takes of it.
    """

    kind: Kind
    numbers: tuple[float, ...]
    steps: int = 0

    __repr__ = line()

    def about(self, nominal: float) -> Spread:
        """The same, with "relative" as the range about the value."""
        if self.kind != "relative":
            return self
        far = self.numbers[0] * abs(nominal)
        return Spread("uniform", (nominal - far, nominal + far), self.steps)

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and largest value."""
        if self.kind == "normal":
            mean, deviation = self.numbers
            return mean - CUT * deviation, mean + CUT * deviation
        return min(self.numbers), max(self.numbers)

    @property
    def count(self) -> int:
        """Values in a grid."""
        return len(self.numbers) if self.kind == "values" else self.steps

    def at(self, part: Array) -> Array:
        """The values for numbers from 0 to below 1, any shape: its quantiles."""
        if self.kind == "values":
            known = np.array(self.numbers)
            return known[np.minimum((part * len(known)).astype(np.int64), len(known) - 1)]
        if self.kind == "normal":
            from scipy.special import ndtr, ndtri

            mean, deviation = self.numbers
            low, high = ndtr(-CUT), ndtr(CUT)
            return np.asarray(mean + deviation * np.clip(ndtri(low + part * (high - low)), -CUT, CUT))
        low, high = self.numbers
        if self.kind == "log-uniform":
            return np.clip(low * (high / low) ** part, low, high)
        return np.clip(low + part * (high - low), low, high)

    def on_grid(self, index: Array) -> Array:
        """The values number `index` of a grid."""
        where = index.astype(np.int64)
        if self.kind == "values":
            return np.array(self.numbers)[where]
        low, high = self.numbers
        if self.steps == 1:
            return np.full(len(where), 0.5 * (low + high))
        part = where / (self.steps - 1)
        return low * (high / low) ** part if self.kind == "log-uniform" else (1.0 - part) * low + part * high
