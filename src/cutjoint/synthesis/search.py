"""The search for good designs, in batches that go to all cores.

With two goals or more it is NSGA-II (Deb, Pratap, Agarwal, Meyarivan: A fast and elitist multiobjective genetic
algorithm: NSGA-II, 2002) as in optuna: the designs that no other one beats in every goal are the front.  With one goal
it is multi-start: points that fill the range evenly (Sobol), and from the best of them quasi-Newton steps (SLSQP of
scipy), with exact derivatives (`cutjoint.synthesis.slopes`) or with central differences, whose designs are judged side
by side.  Both begin with the robot as it is, and the same seed gives the same designs, whatever the number of cores.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc

from cutjoint.arrays import Array
from cutjoint.errors import CutjointError, Interrupted
from cutjoint.extras import needed
from cutjoint.pool import Run, workers
from cutjoint.synthesis.judging import Design, DesignProblem, judged
from cutjoint.synthesis.slopes import ExactSlopes, short, slopes_of

Told = Callable[[int], None]
WORST = 1e6
"""What a design that does not do comes to, in sizes of the goals: far from all that do."""
STARTS = 3
DIFFERENCE = 1e-4
"""Step of a central difference, in parts of a variable's range."""


class Enough(Exception):
    """So many designs are judged as were asked for."""


class Judging:
    """Designs judged so far, side by side, and each once.

    Args:
        problem: what is judged.
        most: how many designs.
        run: the workers.
        told: is told how many are judged.

    Attributes:
        designs: in the order in which they were asked for.
        told: what was odd, in sentences.
    """

    def __init__(self, problem: DesignProblem, most: int, run: Run, told: Told | None) -> None:
        self.problem, self.most = problem, most
        self._run, self._told = run, told
        self.designs: list[Design] = []
        self.told: list[str] = []
        self._known: dict[tuple[float, ...], Design] = {}

    def __call__(self, points: Sequence[Array]) -> list[Design]:
        """Designs at points, shape (variables,) each.

        Raises:
            Enough: there were to be no more.
            Interrupted: a `KeyboardInterrupt` came.
        """
        keys = [tuple(point.tolist()) for point in points]
        new = list(dict.fromkeys(key for key in keys if key not in self._known))
        cut = new[: self.most - len(self.designs)]
        before = len(self.designs)
        told = self._told
        try:
            made = self._run(
                {key: (judged, (self.problem, np.array(key))) for key in cut},
                None if told is None else lambda done: told(before + done),
            )
        except Interrupted as stop:
            self._keep(stop.result if isinstance(stop.result, dict) else {})
            raise
        self._keep(made)
        if len(cut) < len(new) or (len(self.designs) >= self.most and not set(keys) <= set(self._known)):
            raise Enough
        return [self._known[key] for key in keys]

    def _keep(self, made: dict[tuple[float, ...], Design]) -> None:
        self._known.update(made)
        self.designs += made.values()


def searched(
    problem: DesignProblem, designs: int, seed: int, told: Told | None = None
) -> tuple[list[Design], list[str]]:
    """So many designs, the robot as it is first, and what was odd, in sentences.

    Raises:
        MissingPackageError: there are several goals, and optuna is not installed.
        Interrupted: a `KeyboardInterrupt` came; `result` holds the designs that are judged.
    """
    search = _pareto if len(problem.goals) > 1 else _multi_start
    if search is _pareto:
        needed("optuna", "a Pareto front")
    with workers() as run:
        judging = Judging(problem, designs, run, told)
        try:
            judging([problem.now])
            search(judging, seed)
        except Enough:
            pass
        except Interrupted as stop:
            raise Interrupted(
                f"interrupted; {len(judging.designs)} of {designs} designs are judged",
                done=len(judging.designs) / designs,
                result=judging.designs,
            ) from stop
    return judging.designs, judging.told


def _spread(problem: DesignProblem, count: int, seed: int) -> Array:
    """Points that fill the ranges evenly, shape (count, variables)."""
    low, high = bounds(problem)
    power = int(np.ceil(np.log2(max(count, 2))))
    unit = qmc.Sobol(len(low), scramble=True, seed=seed).random_base2(power)[:count]
    return np.asarray(low + unit * (high - low))


def bounds(problem: DesignProblem) -> tuple[Array, Array]:
    """Least and largest values of the variables, shape (variables,) each."""
    return np.array([one.low for one in problem.variables]), np.array([one.high for one in problem.variables])


# ---- several goals ---------------------------------------------------------------------------------------------------


def _pareto(judging: Judging, seed: int) -> None:
    optuna = needed("optuna", "a Pareto front")
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    problem, goals = judging.problem, judging.problem.goals
    population = int(np.clip(judging.most // 6, 8, 48))
    sampler = optuna.samplers.NSGAIISampler(population_size=population, seed=seed)
    directions = ["maximize" if one.goal == "most" else "minimize" for one in goals]
    study = optuna.create_study(directions=directions, sampler=sampler)
    low, high = bounds(problem)
    ranges = {
        f"v{k}": optuna.distributions.FloatDistribution(float(a), float(b))
        for k, (a, b) in enumerate(zip(low, high, strict=True))
    }
    first = [np.clip(problem.now, low, high), *_spread(problem, population - 1, seed)]
    for point in first:
        study.enqueue_trial({f"v{k}": float(x) for k, x in enumerate(point)})
    while True:
        trials = [study.ask(ranges) for _ in range(population)]
        points = [np.array([trial.params[f"v{k}"] for k in range(len(low))]) for trial in trials]
        for trial, design in zip(trials, judging(points), strict=True):
            trial.set_constraint("bounds", _violation(problem, design))
            study.tell(trial, [_goal_value(one.goal, design.found.get(one.name)) for one in goals])


def _goal_value(goal: str | None, found: float | None) -> float:
    if found is None or not np.isfinite(found):
        return -WORST if goal == "most" else WORST
    return found


def _violation(problem: DesignProblem, design: Design) -> float:
    """By how much bounds are missed in all; `WORST` where the design cannot be judged."""
    if len(design.found) < len(problem.wants):
        return WORST
    return float(sum(one.missed_by(design.found[one.name]) for one in problem.wants))


# ---- one goal --------------------------------------------------------------------------------------------------------


def _multi_start(judging: Judging, seed: int) -> None:
    problem = judging.problem
    low, high = bounds(problem)
    judging([np.clip(problem.now, low, high), *_spread(problem, max(judging.most // 3, 4), seed)])
    starts = sorted(judging.designs, key=lambda one: _merit(problem, one))[:STARTS]
    exact, sentence = slopes_of(problem)
    judging.told.append(sentence)
    for start in starts:
        _Descent(judging, np.clip(start.values, low, high), exact).go()


def _merit(problem: DesignProblem, design: Design) -> tuple[float, float]:
    """By what starts are sorted: first what misses the bounds, then the goal."""
    goals = [_small(one.goal, design.found.get(one.name)) for one in problem.goals]
    return _violation(problem, design), goals[0] if goals else 0.0


def _small(goal: str | None, found: float | None) -> float:
    """A goal's value as what is made small."""
    return _goal_value(goal, found) * (-1.0 if goal == "most" else 1.0)


class _Descent:
    """Steps of SLSQP from one start, in parts of the ranges, with exact derivatives where there are some."""

    def __init__(self, judging: Judging, start: Array, exact: ExactSlopes | None) -> None:
        self._judging, self._problem, self._exact = judging, judging.problem, exact
        self._low, self._high = bounds(judging.problem)
        self._start = (start - self._low) / (self._high - self._low)
        first = self._rows(judging([start])[0])
        self._size = np.where(first[:1] == 0.0, 1.0, np.abs(first[:1]))

    def go(self) -> None:
        """Until it converges.

        Raises:
            Enough, Interrupted: as of `Judging`.
        """
        held = {"type": "ineq", "fun": lambda unit: -self._at(unit)[1:], "jac": lambda unit: -self._slopes(unit)[1:]}
        minimize(
            lambda unit: self._at(unit)[0] / self._size[0],
            self._start,
            jac=lambda unit: self._slopes(unit)[0] / self._size[0],
            bounds=[(0.0, 1.0)] * len(self._low),
            constraints=[held] if len(self._at(self._start)) > 1 else [],
            method="SLSQP",
            options={"maxiter": 40, "ftol": 1e-7},
        )

    def _point(self, unit: Array) -> Array:
        return np.asarray(self._low + np.clip(unit, 0.0, 1.0) * (self._high - self._low))

    def _rows(self, design: Design) -> Array:
        """The goal as what is made small, and what must be at most 0: one row a bound, in parts of it."""
        rows = [_small(one.goal, design.found.get(one.name)) for one in self._problem.goals] or [0.0]
        for want in self._problem.wants:
            found = design.found.get(want.name)
            for bound, sign in ((want.at_least, 1.0), (want.at_most, -1.0)):
                if bound is not None:
                    rows.append(WORST if found is None else sign * (bound - found) / (abs(bound) or 1.0))
        return np.array(rows)

    def _at(self, unit: Array) -> Array:
        return self._rows(self._judging([self._point(unit)])[0])

    def _slopes(self, unit: Array) -> Array:
        """Derivatives of the rows, shape (rows, variables): exact ones, or differences where there are none."""
        design = self._judging([self._point(unit)])[0]
        if self._exact is None or len(design.found) < len(self._problem.wants):
            return self._differences(unit)
        try:
            return self._rows_by(self._exact.of(design))
        except CutjointError as error:
            told = f"derivatives: differences for some designs, since {short(error)}"
            if not self._judging.told[-1].startswith("derivatives: differences"):
                self._judging.told.append(told)
            return self._differences(unit)

    def _rows_by(self, slopes: Mapping[str, Array]) -> Array:
        """Derivatives of the rows from those of the wants."""
        span = self._high - self._low
        rows = [_small(one.goal, 1.0) * slopes[one.name] for one in self._problem.goals] or [np.zeros_like(span)]
        for want in self._problem.wants:
            for bound, sign in ((want.at_least, -1.0), (want.at_most, 1.0)):
                if bound is not None:
                    rows.append(sign * slopes[want.name] / (abs(bound) or 1.0))
        return np.array(rows) * span

    def _differences(self, unit: Array) -> Array:
        """Derivatives of the rows by central differences; where an end cannot be judged by the other one."""
        ends = []
        for k in range(len(unit)):
            for sign in (-1.0, 1.0):
                end = np.clip(unit, 0.0, 1.0)
                end[k] = np.clip(end[k] + sign * DIFFERENCE, 0.0, 1.0)
                ends.append(end)
        designs = self._judging([self._point(one) for one in (*ends, np.clip(unit, 0.0, 1.0))])
        columns = []
        for k in range(len(unit)):
            pair = [
                (ends[2 * k + j][k], self._rows(designs[2 * k + j]))
                for j in (0, 1)
                if len(designs[2 * k + j].found) == len(self._problem.wants)
            ]
            if len(pair) < 2:
                pair.append((float(np.clip(unit[k], 0.0, 1.0)), self._rows(designs[-1])))
            (a, rows_a), (b, rows_b) = pair[:2] if len(pair) > 1 else (pair[0], pair[0])
            columns.append((rows_b - rows_a) / (b - a) if a != b else np.zeros_like(rows_a))
        return np.array(columns).T
