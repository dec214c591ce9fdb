"""Statistics of many runs that are taken on the way, chunk by chunk."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cutjoint.arrays import Array, Values, readonly
from cutjoint.compile.many.results import Many
from cutjoint.reprs import line


@dataclass(frozen=True, eq=False)
class Statistics(Values):
    """Of one quantity an actuator, over runs that did not fail.

    Attributes:
        count: of runs.
        mean, variance: shape (n,); the variance is that of a sample (over count - 1).
        smallest, largest: shape (n,).
    """

    count: int = 0
    mean: Array = field(default_factory=lambda: readonly(np.zeros(0)))
    squares: Array = field(default_factory=lambda: readonly(np.zeros(0)))
    """Sum of the squared distances from the mean."""
    smallest: Array = field(default_factory=lambda: readonly(np.zeros(0)))
    largest: Array = field(default_factory=lambda: readonly(np.zeros(0)))

    @property
    def variance(self) -> Array:
        """See the class; not a number of fewer than two runs."""
        if self.count < 2:
            return np.full_like(self.mean, np.nan)
        return self.squares / (self.count - 1)

    def extended(self, rows: Array) -> Statistics:
        """With more runs, shape (N, n).

        T. F. Chan, G. H. Golub, R. J. LeVeque: Updating formulae and a pairwise algorithm for computing sample
        variances. COMPSTAT 1982, 30-41.
        """
        if not len(rows):
            return self
        mean = rows.mean(axis=0)
        squares, low, high = ((rows - mean) ** 2).sum(axis=0), rows.min(axis=0), rows.max(axis=0)
        if not self.count:
            return Statistics(len(rows), *(readonly(x) for x in (mean, squares, low, high)))
        count, apart = self.count + len(rows), mean - self.mean
        return Statistics(
            count,
            readonly(self.mean + apart * (len(rows) / count)),
            readonly(self.squares + squares + apart**2 * (self.count * len(rows) / count)),
            readonly(np.minimum(self.smallest, low)),
            readonly(np.maximum(self.largest, high)),
        )


@dataclass(frozen=True)
class Summary:
    """What is kept of many runs that went elsewhere.

    Attributes:
        runs: how many.
        failed, slow: how many could not be simulated to their end, and how many were done by the model itself.
        error_rms, error_max, effort_max: see `Many`.
    """

    runs: int = 0
    failed: int = 0
    slow: int = 0
    error_rms: Statistics = field(default_factory=Statistics)
    error_max: Statistics = field(default_factory=Statistics)
    effort_max: Statistics = field(default_factory=Statistics)

    __repr__ = line(error_rms="m", error_max="m", effort_max="N or N m")

    def extended(self, many: Many) -> Summary:
        """With more runs."""
        whole = np.ones(len(many.q), dtype=bool)
        whole[list(many.failed)] = False
        return Summary(
            self.runs + len(whole),
            self.failed + len(many.failed),
            self.slow + len(many.slow),
            self.error_rms.extended(many.error_rms[whole]),
            self.error_max.extended(many.error_max[whole]),
            self.effort_max.extended(many.effort_max[whole]),
        )
