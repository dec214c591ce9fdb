"""How often each of a set of things was found, and how much is likely to be missing.

Of n independent finds, those that turned up once make the share n_1 / n; by Good and Turing that is about the chance
that the next find is a new one (I. J. Good, The population frequencies of species and the estimation of population
parameters, Biometrika 40, 1953).  It bounds the share of the starts, not the number of solutions: one that hardly any
start leads to can hide for ever.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array

TIMES = 3
"""A search ends when everything was found as often as this: of m solutions that are found equally often the last one
is then missing with a chance of about 1 in (log m)^2 m."""


@dataclass(eq=False)
class TallyEntry:
    """One of the things: what tells it from the others, a configuration that shows it, whether the robot's joints allow
    it, and how often it was found."""

    shape: Array
    q: Array
    allowed: bool
    count: int = 0


@dataclass(eq=False)
class Tally:
    """Things told apart by a vector, their shape, to within the tolerance DISTINCT."""

    entries: list[TallyEntry] = field(default_factory=list)
    total: int = 0

    def find(self, shape: Array) -> int | None:
        """Which of the entries has this shape."""
        for index, entry in enumerate(self.entries):
            if np.abs(entry.shape - shape).max(initial=0.0) < tolerances.DISTINCT.value:
                return index
        return None

    def add(self, shape: Array, q: Array, allowed: bool = True) -> int:
        """Add an entry, not counted as found yet."""
        self.entries.append(TallyEntry(shape, q, allowed))
        return len(self.entries) - 1

    def count(self, index: int) -> None:
        """Count one find of an entry."""
        self.entries[index].count += 1
        self.total += 1

    @property
    def unseen(self) -> float:
        """Estimated share of further finds that are new and allowed; 1 where nothing was found yet."""
        once = sum(entry.count == 1 and entry.allowed for entry in self.entries)
        return once / self.total if self.total else 1.0

    def settled(self, fewest: int) -> bool:
        """Whether at least `fewest` finds were made and each thing that is allowed was found TIMES."""
        return self.total >= fewest and all(entry.count >= TIMES or not entry.allowed for entry in self.entries)
