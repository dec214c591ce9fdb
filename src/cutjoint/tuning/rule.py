"""The CPM paper's rule for gains (Elkady et al. 2008, sections 5.3 and 5.4), and what it leaves open.

The robot starts at rest where the reference starts.  Of a law with kp and kd

    kd    the largest whose first effort stays within the limit: only kd acts then, on the speed that is desired
    kp    the smallest that keeps the error under the bound from a time on

and of computed torque kp = kd^2 / 4 (equation 46) with the largest kd whose first effort stays within the limit.  Gains
are whole numbers as the paper's, or of four digits (kp) and three (kd) where they are small.

Where some actuators slide and some turn, no one gain serves all: kp and kd are then sought per inertia, in [1/s2] and
[1/s], and every actuator has its own, kp_i = kp D_i and kd_i = kd D_i, with D_i its largest inertia on the way.

Where a reference starts at rest no first effort depends on kd, and the rule does not fix it; it is then taken for
critical damping of the largest inertia, kd = 2 sqrt(kp M).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, positive
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.reprs import line
from cutjoint.tuning.case import TuningCase
from cutjoint.tuning.runs import CaseRuns
from cutjoint.tuning.smallest import smallest_gain

LARGEST_KD = 1e12
OTHERS = 6
"""Other kd at which the smallest kp is told."""
ROOM = 3.0
"""Gains beyond those that are run now, for which the next loop is made too."""
BELOW, ABOVE = 30.0, 3.0
"""How far below and above of the kd taken others are looked at."""
ALONG = 40
"""Values of kd between which the interval that serves is looked for, and again at its ends."""


@door
@dataclass(frozen=True)
class PaperRule:
    """The rule of the CPM's paper.

    Attributes:
        error: bound of the late error, [m] of the tool, or [m] or [rad] of the actuators (where some slide and some
            turn, in lengths of the robot of those that slide); computed torque needs none.

    Raises:
        InputError: it is not positive.
    """

    error: float | None = None

    __repr__ = line(error="m or rad")

    def __post_init__(self) -> None:
        if self.error is not None:
            object.__setattr__(self, "error", positive("error of the rule", self.error, "m or rad"))

    @property
    def words(self) -> str:
        """How it is told."""
        return "the CPM paper's rule"


class FoundGains(NamedTuple):
    """Gains, what the way they were found leaves open, and what was chosen."""

    gains: Mapping[str, Array]
    free: tuple[str, ...] = ()
    told: tuple[str, ...] = ()


def by_rule(case: TuningCase, rule: PaperRule, guess: Mapping[str, npt.ArrayLike]) -> FoundGains:
    """Gains by the rule.

    Args:
        case: with limits of the efforts.
        rule: with the bound of the error.
        guess: gains to begin with.

    Raises:
        InputError: the rule does not serve this law, needs a bound or a limit, or no gains keep them.
    """
    if set(case.row.gains) != {"kp", "kd"}:
        takes = ", ".join(case.row.gains)
        raise InputError(f"the rule is for laws with the gains kp and kd; {case.name} takes {takes}. Tune it by search")
    if case.limits is None:
        raise InputError(f"the rule takes kd from a limit of the efforts; give one [{case.effort_unit}]")
    if _cancels(case):
        return _computed_torque(case, rule)
    if rule.error is None:
        raise InputError(f"the rule takes kp from a bound of the error after {case.after:g} s; give one")
    return _Sought(case, rule.error, guess).outcome()


def _cancels(case: TuningCase) -> bool:
    """Whether the law's gains are those of the error's own equation."""
    return case.row.gains["kp"].unit == "1/s2"


def _effort_part(case: TuningCase, kp: float, kd: float, weights: float | Array = 1.0) -> float:
    """The largest first effort over its limit, with gains times `weights`: at rest where the reference starts."""
    assert case.limits is not None
    desired, n = case.reference.at(0.0), case.robot.n
    made = case.law({"kp": kp * weights, "kd": kd * weights})
    first = made.effort(desired, desired.q, np.zeros(n), np.zeros(made.memory(n)))
    return float((np.abs(first) / case.limits).max())


def _largest(part_of: Callable[[float], float], digits: int) -> float | None:
    """The largest kd with part_of(kd) <= 1, a whole number or of so many digits; None where every one is.

    Raises:
        InputError: none is.
    """
    if (least := part_of(0.0)) > 1.0:
        raise InputError(
            f"without any gain the first effort is {least:.3g} of its limit already: what holds and leads the robot "
            "is beyond it; raise the limit"
        )
    if part_of(LARGEST_KD) <= 1.0:
        return None
    low, high = 0.0, 1e-12
    while part_of(high) <= 1.0:
        low, high = high, 10.0 * high
    step = min(1.0, 10.0 ** (math.floor(math.log10(high)) - digits))
    while high - low > 1e-3 * step:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if part_of(middle) <= 1.0 else (low, middle)
    found = math.floor(low / step + 1e-9) * step
    return float(f"{found:.12g}")


def _computed_torque(case: TuningCase, rule: PaperRule) -> FoundGains:
    kd = _largest(lambda kd: _effort_part(case, kd * kd / 4.0, kd), 3)
    if kd is None:
        raise InputError("the first effort does not depend on kd, as the reference starts at rest; place poles instead")
    gains = {"kp": np.array(kd * kd / 4.0), "kd": np.array(kd)}
    told = ["kp = kd^2 / 4 (critical damping), kd the largest whose first effort stays within the limit"]
    if rule.error is not None:
        late = float(CaseRuns(case, gains).figures({name: one[None] for name, one in gains.items()}).late[0])
        verb = "keeps" if late < rule.error else "does not keep"
        told.append(
            f"the rule has no bound of the error for this law; the error is {late:.4g}, which {verb} {rule.error:g}"
        )
    free = (
        "kp = kd^2 / 4 is the paper's choice: no bound of the error fixes kp, and every smaller kd keeps the limit too"
    )
    return FoundGains(gains, (free,), tuple(told))


class _Sought:
    """The search for kp of a law that needs a bound."""

    def __init__(self, case: TuningCase, bound: float, guess: Mapping[str, npt.ArrayLike]) -> None:
        self.case, self.bound = case, bound
        inertias = np.max([np.diag(plant.mass) for _, plants in case.plants for plant in plants], axis=0)
        self.weights = inertias if case.mixes else np.ones(case.robot.n)
        self.units = {"kp": "1/s2", "kd": "1/s"} if case.mixes else case.units()
        self.kp_guess = float(np.max(np.asarray(guess["kp"]) / self.weights))
        self.fixed = _largest(lambda kd: _effort_part(case, 0.0, kd, self.weights), 3)
        self.inertia = float((inertias / self.weights).max())
        self.step = min(1.0, 10.0 ** (math.floor(math.log10(max(self.kp_guess, 1e-300))) - 3))
        self._runs: CaseRuns | None = None
        self._top = (0.0, 0.0)

    def kd_of(self, kp: float) -> float:
        """The kd that goes with a kp."""
        if self.fixed is not None:
            return self.fixed
        kd = 2.0 * math.sqrt(kp * self.inertia)
        return float(f"{kd:.6g}")

    def figures(self, kp: Array, kd: Array) -> tuple[Array, Array]:
        """Late error and largest part of the limit, shape (N,) each."""
        top = (float(kp.max()), float(kd.max()))
        if self._runs is None or top[0] > 2.0 * self._top[0] or top[1] > 2.0 * self._top[1]:
            room = ROOM if self._runs else 1.0
            self._top = (max(room * top[0], self._top[0]), max(room * top[1], self._top[1]))
            self._runs = CaseRuns(self.case, {"kp": self._top[0] * self.weights, "kd": self._top[1] * self.weights})
        found = self._runs.figures({"kp": kp[:, None] * self.weights, "kd": kd[:, None] * self.weights})
        assert self.case.limits is not None
        return found.late, (found.peak / self.case.limits).max(axis=1)

    def error_of(self, count: int, kd: float | None = None) -> float:
        """Late error of a kp of so many steps."""
        kp = count * self.step
        late, _ = self.figures(np.array([kp]), np.array([self.kd_of(kp) if kd is None else kd]))
        return float(late[0])

    def smallest(self, guess: float, kd: float | None = None) -> float:
        """The smallest kp that keeps the bound; with a kd, or with the one that goes with it."""
        count = max(2, round(guess / self.step))
        found = smallest_gain(lambda count: self.error_of(count, kd), self.bound, count)
        return float(f"{found.gain * self.step:.12g}")

    def outcome(self) -> FoundGains:
        kp = self.smallest(self.kp_guess)
        kd = self.kd_of(kp)
        unit = self.units["kd"]
        told = []
        if self.fixed is None:
            told.append("the reference starts at rest, so no first effort depends on kd: it is taken as 2 sqrt(kp M)")
        _, part = self.figures(np.array([kp]), np.array([kd]))
        if part[0] > 1.0:
            told.append(f"later on the run needs {part[0]:.3g} of the limit, which no gain of this rule changes")
        low, high = self._interval(kp, kd)
        what = "keeps the bound and the limit" if part[0] <= 1.0 else "keeps the bound"
        taken = "the largest is taken" if self.fixed is not None else "critical damping is taken"
        free = [f"kd is free: with kp = {kp:g} every kd from {low:.4g} to {high:.4g} {unit} {what}; {taken}"]
        others = self._others(kp, low, high)
        if others:
            least, most = min(others, key=lambda one: one[1]), max(others, key=lambda one: one[1])
            unit = self.units["kp"]
            if least[1] == most[1]:
                free.append(f"over that range the smallest kp is the same, {kp:g} {unit}: kd does not move it")
            else:
                words = f"{least[1]:g} (kd = {least[0]:.4g}) to {most[1]:g} (kd = {most[0]:.4g}) {unit}"
                free.append(f"and kp hangs on kd: over that range the smallest kp is from {words}")
        if self.fixed is None and high >= 0.999 * ABOVE * kd:
            free.append(f"no kd beyond {high:.4g} {unit} was looked at")
        free.append("nor does it say where the run starts: here at rest in the first desired posture")
        if self.case.mixes:
            told.append(f"kp = {kp:g} 1/s2 and kd = {kd:g} 1/s times the largest inertia of every actuator on the way")
            return FoundGains({"kp": kp * self.weights, "kd": kd * self.weights}, tuple(free), tuple(told))
        return FoundGains({"kp": np.array(kp), "kd": np.array(kd)}, tuple(free), tuple(told))

    def _interval(self, kp: float, kd: float) -> tuple[float, float]:
        """The kd about the one taken that serve with this kp."""
        top = kd if self.fixed is not None else ABOVE * kd
        grid = np.unique(np.append(np.geomspace(kd / BELOW, top, ALONG), kd))
        for _ in range(3):
            late, part = self.figures(np.full(len(grid), kp), grid)
            _, now = self.figures(np.array([kp]), np.array([kd]))
            good = (late < self.bound) & (part <= max(1.0, now[0]) * (1.0 + 1e-9))
            here = int(np.abs(grid - kd).argmin())
            first = here
            while first > 0 and good[first - 1]:
                first -= 1
            last = here
            while last + 1 < len(grid) and good[last + 1]:
                last += 1
            ends = (grid[max(first - 1, 0)], grid[first], grid[last], grid[min(last + 1, len(grid) - 1)])
            at_ends = (np.linspace(*ends[:2], ALONG // 2), np.linspace(*ends[2:], ALONG // 2))
            grid = np.unique(np.concatenate([*at_ends, [kd], np.geomspace(ends[1], ends[2], 4)]))
        return float(ends[1]), float(ends[2])

    def _others(self, kp: float, low: float, high: float) -> list[tuple[float, float]]:
        """Other kd, and the smallest kp with each."""
        found = []
        if high <= 1.001 * low:
            return []
        for kd in np.geomspace(low, high, OTHERS).tolist():
            try:
                found.append((kd, self.smallest(kp, kd)))
            except InputError:
                continue
        return found
