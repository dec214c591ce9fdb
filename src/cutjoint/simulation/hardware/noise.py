"""Chance of a sampled loop: a run has its own numbers, which depend on nothing but seed and number of the run.

Noise is `numpy.random.default_rng([seed, run])`, standard normal numbers sample after sample, in a sample first those
of the encoders, then those of the tachometers, as far as these are noisy.  Jitter is whole numbers from
`numpy.random.default_rng([seed, run, 1])`, sample after sample.  How many are drawn at a time changes nothing.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.errors import InputError

Integers = npt.NDArray[np.int64]


class Noise:
    """Standard normal numbers of one run, to be drawn in order.

    Args:
        seed, run: whole numbers >= 0.
        channels: numbers a sample.
    """

    def __init__(self, seed: int, run: int, channels: int) -> None:
        self._source, self.channels = np.random.default_rng([seed, check_run(run)]), channels

    def rows(self, samples: int) -> Array:
        """Of the next samples, shape (samples, channels)."""
        return self._source.standard_normal((samples, self.channels))


class Jitter:
    """Ticks by which the edges of one run are late (or early, below 0), to be drawn in order.

    The first edge is on time.  All numbers from -most to most are as likely.
    """

    def __init__(self, seed: int, run: int, most: int) -> None:
        self._source, self._most = np.random.default_rng([seed, check_run(run), 1]), most
        self._begun = False

    def ticks(self, samples: int) -> Integers:
        """Of the next samples, shape (samples,)."""
        drawn = self._source.integers(-self._most, self._most, samples, endpoint=True)
        if samples and not self._begun:
            drawn[0], self._begun = 0, True
        return drawn


def check_run(run: int) -> int:
    """`run` as a number of a run.

    Raises:
        InputError: it is no whole number >= 0.
    """
    if isinstance(run, bool) or not isinstance(run, int | np.integer) or run < 0:
        raise InputError(f"the number of a run is a whole number >= 0, found {run!r}")
    return int(run)
