"""Collects the samples of a run until they become a `Result`."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cutjoint.simulation.observables import OBSERVABLES, Sample
from cutjoint.simulation.result import About, Result, result_of


class Recorder:
    """A growing record."""

    def __init__(self) -> None:
        self._columns: dict[str, list[npt.ArrayLike]] = {name: [] for name in OBSERVABLES}

    def add(self, sample: Sample) -> None:
        """Take one sample."""
        for name, one in OBSERVABLES.items():
            self._columns[name].append(one.take(sample))

    def result(self, about: About) -> Result:
        """Everything taken so far."""
        return result_of({name: np.array(rows, dtype=np.float64) for name, rows in self._columns.items()}, about)
