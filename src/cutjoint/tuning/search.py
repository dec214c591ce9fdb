"""Gains by optimisation over runs of the loop as it is built: rate, delay, noise, friction, every payload.

What is made small is the root mean square error of the run, of the worst payload and noise, times a penalty

    J = rms (1 + 10 x),   x = sum of how far efforts are beyond their limit, as a part of it,
                              and how far the sensitivity's peak is beyond what is allowed

A run that cannot be simulated, or whose linear loop is unstable, is worse than any that can.  Sought are the logarithms
of factors on the gains to begin with, one a gain, within `RANGE` either way; those gains themselves are among the first
that are tried, so what is found is never worse.

`evolution` is differential evolution (R. Storn, K. Price 1997, as scipy has it), a generation of runs at a time;
`optuna` its tree-structured Parzen estimator, in batches of the same size.  Both are the same for the same seed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cutjoint.arrays import Array, positive
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.extras import needed
from cutjoint.reprs import line
from cutjoint.tuning.case import TuningCase
from cutjoint.tuning.margins import sensitivity_peak
from cutjoint.tuning.rule import FoundGains
from cutjoint.tuning.runs import CaseRuns

RANGE = 30.0
"""Largest factor on a gain, and the reciprocal of the least."""
PENALTY, WORSE = 10.0, 1e6
ROUGHLY = 60
"""Frequencies at which the sensitivity is looked at in the search."""
LARGEST_RMS = 1e30


@door
@dataclass(frozen=True)
class GainSearch:
    """How gains are sought.

    Attributes:
        method: "evolution", or "optuna" (extra `optimise`).
        trials: how many sets of gains are tried, about.
        seed: of the search.
        sensitivity: largest peak of the sensitivity that is allowed; 2 leaves every actuator a gain margin of 2 and a
            phase margin of 29 deg at least.

    Raises:
        InputError: numbers out of their ranges.
    """

    method: Literal["evolution", "optuna"] = "evolution"
    trials: int = 400
    seed: int = 0
    sensitivity: float = 2.0

    __repr__ = line("method", "trials", "seed", "sensitivity")

    def __post_init__(self) -> None:
        if self.trials < 20:
            raise InputError(f"a search needs 20 trials or more, found {self.trials}")
        if self.seed < 0:
            raise InputError(f"a seed is a whole number >= 0, found {self.seed}")
        if positive("sensitivity", self.sensitivity) <= 1.0:
            raise InputError(f"every loop has a peak of sensitivity of 1 or more; allow more than {self.sensitivity:g}")

    @property
    def words(self) -> str:
        """How it is told."""
        return f"search ({self.method}, {self.trials} trials, seed {self.seed})"


class Searching:
    """The search of a case.

    Attributes:
        best: logarithms of the factors of the best gains so far, shape (gains,).
        least: its J.
        done: how many sets were tried.
        interrupted: whether a `KeyboardInterrupt` ended it.
    """

    def __init__(
        self,
        case: TuningCase,
        how: GainSearch,
        begin: Mapping[str, Array],
        progress: Callable[[float], None] | None = None,
    ) -> None:
        if how.method == "optuna":
            needed("optuna", "a search by optuna")
        n = case.robot.n
        self.case, self.how, self._progress = case, how, progress
        self.begin = {name: np.broadcast_to(np.asarray(one, dtype=np.float64), (n,)) for name, one in begin.items()}
        if any(not (one > 0.0).all() for one in self.begin.values()):
            raise InputError("a search begins at gains above 0; give some")
        top = {name: RANGE * one for name, one in self.begin.items()} if case.hardware is None else self.begin
        self.runs = CaseRuns(case, top)
        self.best, self.least, self.done = np.zeros(len(self.begin)), math.inf, 0
        self.first, self.interrupted = math.nan, False
        self._size = max(10, 8 * len(self.begin))

    def gains(self, logs: Array) -> dict[str, Array]:
        """Gains of sets of logarithms, shape (N, gains): name -> (N, n)."""
        return {name: np.exp(logs[:, [k]]) * one for k, (name, one) in enumerate(self.begin.items())}

    def costs(self, logs: Array) -> Array:
        """J of every set, shape (N,)."""
        case, gains = self.case, self.gains(logs)
        figures = self.runs.figures(gains, late=False)
        excess = np.zeros(len(logs))
        if case.limits is not None:
            excess += np.maximum(figures.peak / case.limits - 1.0, 0.0).sum(axis=1)
        cost = figures.rms.copy()
        for k in range(len(logs)):
            peak = self._peak({name: one[k] for name, one in gains.items()}) if np.isfinite(cost[k]) else math.inf
            if not math.isfinite(peak):
                cost[k] = WORSE * min(max(float(cost[k]), 1.0), LARGEST_RMS)
            else:
                excess[k] += max(peak / self.how.sensitivity - 1.0, 0.0)
        cost *= 1.0 + PENALTY * np.minimum(excess, LARGEST_RMS)
        at = int(cost.argmin())
        if cost[at] < self.least:
            self.best, self.least = logs[at].copy(), float(cost[at])
        self.done += len(logs)
        if self._progress is not None:
            self._progress(min(self.done, self.how.trials))
        return cost

    def _peak(self, gains: Mapping[str, Array]) -> float:
        """The highest sensitivity of all postures and payloads."""
        loops = self.case.linear(gains)
        if not all(one.stable for one in loops):
            return math.inf
        return max(sensitivity_peak(one, ROUGHLY) for one in loops)

    def outcome(self) -> FoundGains:
        """The best gains.

        Raises:
            InputError: no gains give a run that can be simulated.
        """
        try:
            self.first = float(self.costs(np.zeros((1, len(self.begin))))[0])
            if self.how.method == "optuna":
                self._by_optuna()
            else:
                self._by_evolution()
        except KeyboardInterrupt:
            if not math.isfinite(self.least):
                raise
            self.interrupted = True
        if self.least >= WORSE:
            raise InputError(
                "no gains within a factor of 30 of those to begin with give a stable loop; begin elsewhere, or ask "
                "for a slower rate, less delay or less payload"
            )
        found = {name: one[0] for name, one in self.gains(self.best[None, :]).items()}
        draws = f" and {self.case.draws} draws of noise" if self.case.draws > 1 else ""
        fell = f"J fell from {self.first:.4g} to {self.least:.4g}"
        told = [f"{self.done} sets of gains were run with every payload{draws}; {fell}"]
        edge = [name for name, x in zip(found, self.best, strict=True) if abs(x) > 0.99 * math.log(RANGE)]
        if edge:
            told.append(f"at the edge of what was looked at: {', '.join(edge)}; begin there to go on")
        free = ("gains of the actuators keep the proportions of those to begin with; only one factor a gain is sought",)
        return FoundGains(found, free, tuple(told))

    def _by_evolution(self) -> None:
        from scipy.optimize import differential_evolution

        count, width = len(self.begin), math.log(RANGE)
        rng = np.random.default_rng(self.how.seed)
        first = rng.uniform(-width, width, (self._size, count))
        first[0] = 0.0
        differential_evolution(
            lambda x: self.costs(x.reshape(count, -1).T),
            [(-width, width)] * count,
            init=first,
            maxiter=max(1, self.how.trials // self._size - 1),
            vectorized=True,
            updating="deferred",
            polish=False,
            tol=0.0,
            rng=rng,
        )

    def _by_optuna(self) -> None:
        optuna = needed("optuna", "a search by optuna")
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        width, names = math.log(RANGE), list(self.begin)
        study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=self.how.seed, constant_liar=True))
        study.enqueue_trial(dict.fromkeys(names, 0.0))
        while self.done < self.how.trials:
            trials = [study.ask() for _ in range(self._size)]
            logs = np.array([[one.suggest_float(name, -width, width) for name in names] for one in trials])
            for one, cost in zip(trials, self.costs(logs).tolist(), strict=True):
                study.tell(one, cost)
