"""The quickest motion along a way within limits: `retime`.

1. The way of the actuators without its time (`path`), and the equation of motion along it (`terms`).
2. The quickest s_dot^2 at its samples (`sweep`, `solving`).
3. A law of time whose acceleration is continuous (`time_law`), and rows of it as a spline of the actuators.
4. What that spline asks of every limit between its rows (`peaks`): where it is beyond, the limits are tightened around
   that place, and all is done again.
5. Inverse dynamics of the finished spline at other instants; what is beyond a limit there tightens once more.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from cutjoint.arrays import Array
from cutjoint.doors import door, of_type
from cutjoint.errors import InputError, RetimingError
from cutjoint.mechanism import NO_LOADS, Loads, Mechanism
from cutjoint.motion import JointSpline, Reference, Trajectory
from cutjoint.motion.following import size_of
from cutjoint.motion.splines import is_closed
from cutjoint.retiming import peaks
from cutjoint.retiming.answer import Retimed
from cutjoint.retiming.limit_peaks import peaks_of
from cutjoint.retiming.limits import OF_TOOL, MotionLimits
from cutjoint.retiming.path import MOST_NODES, NODES, WholeWay, way_of
from cutjoint.retiming.rows import Margins, rows_of
from cutjoint.retiming.smoothing import Smoothed, smoothed
from cutjoint.retiming.solving import PieceSolver
from cutjoint.retiming.sweep import ceiling
from cutjoint.retiming.terms import has_tool, terms_along
from cutjoint.retiming.time_law import elapsed

KEPT = 1e-3
"""Beyond a limit by at most this part of it, anywhere; and what is aimed at."""
AIM = 4e-4
ROUNDS = 12
CHECKS = 1500
FIRST = 200.0
"""The time in which the acceleration goes from one limit to another is that of the motion by this number."""
LOST = 2e-3
"""The part of the time that steps of constant acceleration may lose."""
LEAST_ROOM = 0.05
Told = Callable[[float], None]


@dataclass
class _Found:
    """A motion of one round, and what it is estimated to ask of the limits."""

    motion: JointSpline
    spline: CubicSpline
    smooth: Smoothed
    t: Array
    used: peaks.Used


@door
def retime(
    robot: Mechanism,
    trajectory: Trajectory,
    limits: MotionLimits,
    *,
    goes_round: bool = False,
    ramp: float | None = None,
    loads: Loads = NO_LOADS,
    progress: Told | None = None,
) -> Retimed:
    """The quickest motion along the way of a trajectory that keeps limits, from rest to rest.

    Args:
        robot: that moves.
        trajectory: whose way is gone; its own time does not matter.
        limits: from `limits_of`.
        goes_round: for a closed way: the quickest motion that goes round for ever, at speed where it begins anew.
        ramp: time in which the acceleration goes from one limit to another [s]; default a 200th of the motion, longer
            where a limit of jerk needs it.
        loads: that act from outside meanwhile.
        progress: told the part of the work that is done.

    Raises:
        RetimingError: no motion keeps the limits: it tells which, and where.
        UnreachableError, LimitError: the way leaves the workspace, goes beyond joint limits, or through a singularity.
        InputError: the trajectory does not move or cannot go round, limits of another robot, or no ramp.
    """
    if tuple(one.name for one in limits.actuators) != tuple(one.name for one in robot.actuators):
        raise InputError(f"the limits are those of another robot; limits_of makes those of {robot.name}")
    if ramp is not None and not (np.isfinite(ramp) and ramp > 0.0):
        raise InputError(f"ramp must be a time > 0 [s], found {ramp!r}")
    if any(np.isfinite(limits.of(one)).any() for one in OF_TOOL) and not has_tool(robot):
        raise InputError(f"{robot.name} has no tool, so its speed and acceleration cannot be limited")
    of_type("loads", loads, tuple, list)
    told = progress or (lambda _: None)
    work = _Work(robot, trajectory, limits, goes_round=goes_round, ramp=ramp, loads=loads)
    return work.done(told)


class _Work:
    """One retiming."""

    def __init__(
        self,
        robot: Mechanism,
        trajectory: Trajectory,
        limits: MotionLimits,
        *,
        goes_round: bool,
        ramp: float | None,
        loads: Loads,
    ) -> None:
        self.robot, self.limits, self.loads, self.ramp, self.goes_round = robot, limits, loads, ramp, goes_round
        self.former, self.name = trajectory.duration, trajectory.name
        size = size_of(robot) if has_tool(robot) else 1.0
        self.units = np.array([1.0 if one.kind == "rotation" else size for one in robot.actuators])
        self.reference = Reference(trajectory, robot)
        self._prepare(NODES)

    def _prepare(self, nodes: int) -> None:
        """The way, with about so many samples, and the terms along it."""
        self.way: WholeWay = way_of(self.reference, self.units, round_and_round=self.goes_round, nodes=nodes)
        self.solvers = [
            PieceSolver(self.robot, self.way, one, terms_along(self.robot, one, self.loads), goes_round=self.goes_round)
            for one in self.way.pieces
        ]
        self.margins = [Margins(len(one.s), self.robot.n) for one in self.way.pieces]

    def _first(self, told: Told) -> tuple[list[Array], float]:
        """The quickest motion at the samples, and the time below which none is.

        What a step of constant acceleration loses goes with its length, so twice as many samples lose half: that tells
        how much there is to gain, and there are more samples while it is too much.
        """
        while True:
            squares = self._solved()
            parts = zip(self.solvers, squares, strict=True)
            time = sum(float(elapsed(one.piece.s, x)[-1]) for one, x in parts)
            half = sum(one.halved(self.limits, m) for one, m in zip(self.solvers, self.margins, strict=True))
            nodes = sum(len(one.s) - 1 for one in self.way.pieces)
            if half - time <= LOST * time or 2 * nodes > MOST_NODES:
                return squares, time - max(half - time, 0.0) if np.isfinite(half) else time
            before = [(one.piece.s, x) for one, x in zip(self.solvers, squares, strict=True)]
            self._prepare(2 * nodes)
            for one, (s, x) in zip(self.solvers, before, strict=True):
                one.like(s, x)
            told(0.5 - 0.5 * NODES / nodes)

    def _solved(self) -> list[Array]:
        return [one.solve(self.limits, margins) for one, margins in zip(self.solvers, self.margins, strict=True)]

    def done(self, told: Told) -> Retimed:
        """All steps."""
        squares, shortest = self._first(told)
        tops = self._ceiling(squares)
        for _ in range(3):
            best = self._tightened(squares, shortest, told)
            worst, checked, used, t = self._checked(best)
            if worst <= 1.0 + KEPT:
                return self._answer(best, shortest, tops, (checked, used, t))
            self._tighten(best, t, used)
            squares = self._solved()
        raise RetimingError(
            f"the motion found keeps its limits by the terms along the way, but not by inverse dynamics, which finds "
            f"{100.0 * worst:.2f} % of one; this way has places that the samples do not show",
            limits=[],
            place=0.0,
            t=0.0,
        )

    # ---- rounds ------------------------------------------------------------------------------------------------------

    def _tightened(self, squares: list[Array], shortest: float, told: Told) -> _Found:
        """Rounds of tightening until no limit is passed between the samples; or else the nearest of them, stretched."""
        nearest, least = None, np.inf
        for i in range(ROUNDS):
            now = self._motion(squares, shortest)
            worst = peaks.worst_of(now.used)
            told(0.5 + 0.3 * (i + 1) / ROUNDS)
            if worst <= 1.0 + AIM:
                return now
            if worst < least:
                nearest, least = now, worst
            self._tighten(now)
            try:
                squares = self._solved()
            except RetimingError:
                break
        assert nearest is not None
        kept = nearest
        return self._longer(
            kept, peaks.stretch_that_keeps(lambda by: peaks.worst_of(self._longer(kept, by).used), 1.0 + AIM)
        )

    def _motion(self, squares: list[Array], shortest: float) -> _Found:
        half = 0.5 * (shortest / FIRST if self.ramp is None else self.ramp)
        parts = [(one.piece, x) for one, x in zip(self.solvers, squares, strict=True)]
        smooth = smoothed(parts, half, self.limits.jerk, goes_round=self.goes_round)
        motion = JointSpline(smooth.times, smooth.q, is_closed(smooth.q), f"{self.name}, retimed")
        spline = peaks.spline_of(motion)
        t = peaks.instants_between(motion.times)
        return _Found(motion, spline, smooth, t, self._estimate(spline, t, smooth, 1.0))

    def _estimate(self, spline: CubicSpline, t: Array, smooth: Smoothed, longer: float) -> peaks.Used:
        """What is asked at instants t, of a motion that is `longer` than the laws by a factor."""
        parts = []
        for k, one in enumerate(self.solvers):
            here = smooth.inside(k, t / longer, last=k == len(self.solvers) - 1)
            if here.any():
                terms = one.terms.between(smooth.place(k, t[here] / longer))
                parts.append(peaks.estimated(spline, t[here], terms, self.units, self.limits))
        return {one: np.concatenate([part[one] for part in parts]) for one in parts[0]}

    def _longer(self, now: _Found, factor: float) -> _Found:
        if factor == 1.0 or not np.isfinite(factor):
            return now
        motion = JointSpline(factor * now.motion.times, now.motion.q, now.motion.closed, now.motion.name)
        spline, t = peaks.spline_of(motion), factor * now.t
        return _Found(motion, spline, now.smooth, t, self._estimate(spline, t, now.smooth, factor))

    def _tighten(self, now: _Found, t: Array | None = None, used: peaks.Used | None = None) -> None:
        """Tighten limits around the places where they are passed."""
        t, used = now.t if t is None else t, now.used if used is None else used
        longer = float(now.motion.duration / now.smooth.times[-1])
        for k, (one, margins) in enumerate(zip(self.solvers, self.margins, strict=True)):
            here = now.smooth.inside(k, t / longer, last=k == len(self.solvers) - 1)
            if not here.any():
                continue
            at = np.searchsorted(one.piece.s, now.smooth.place(k, t[here] / longer))
            for quantity in (name for name in used if name != "jerk"):
                for j, column in enumerate(np.abs(used[quantity][here]).T):
                    over = np.zeros(len(one.piece.s))
                    for off in (-2, -1, 0, 1):
                        np.maximum.at(over, np.clip(at + off, 0, len(over) - 1), column)
                    near = np.flatnonzero(over > 1.0 + 0.25 * AIM)
                    margins.tighten(quantity, j, near, over[near])
            self._leave_room(one, margins)

    def _leave_room(self, one: PieceSolver, margins: Margins) -> None:
        """Efforts keep a little more than what holds the robot still."""
        limit = self.limits.effort
        bounded = np.isfinite(limit)
        holding = np.abs(one.terms.holding[:, bounded]) / limit[bounded]
        least = np.minimum(1.0, holding + LEAST_ROOM * np.maximum(1.0 - holding, 0.0))
        margins["effort"][:, bounded] = np.maximum(margins["effort"][:, bounded], least)

    # ---- the end -----------------------------------------------------------------------------------------------------

    def _checked(self, best: _Found) -> tuple[float, int, peaks.Used, Array]:
        """The largest part of a limit by inverse dynamics, of how many instants, and all of them."""
        t = peaks.instants_to_check(best.used, best.t, best.motion.duration, CHECKS)
        used = peaks.found(Reference(best.motion, self.robot), self.robot, best.spline, t, self.limits, self.loads)
        return peaks.worst_of(used), len(t), used, t

    def _ceiling(self, squares: list[Array]) -> Array:
        """Way lengths and the largest rates that limits leave there."""
        found = []
        for one, margins, x in zip(self.solvers, self.margins, squares, strict=True):
            top = ceiling(rows_of(one.terms, self.limits, margins, x))
            found.append(np.column_stack([one.piece.s, np.sqrt(np.maximum(top, 0.0))]))
        return np.concatenate(found)

    def _answer(self, best: _Found, shortest: float, tops: Array, check: tuple[int, peaks.Used, Array]) -> Retimed:
        checked, used, t = check
        rows, columns = peaks_of(used, self.limits, t)
        longer = float(best.motion.duration / best.smooth.times[-1])
        place, speed = best.smooth.along(t / longer)
        told = list(self.limits.told)
        if self.way.rests > 0.0:
            told.append(f"the trajectory stood still for {self.way.rests:.4g} s meanwhile, which is left out")
        if len(self.way.pieces) > 1:
            corners = len(self.way.pieces) - 1
            told.append(f"the way has {corners} corner{'s' * (corners > 1)}, where any motion must stop")
        return Retimed(
            self.robot.name,
            best.motion,
            self.robot.actuators,
            self.limits,
            best.motion.duration,
            shortest,
            self.former,
            self.way.closed,
            self.goes_round,
            2.0 * best.smooth.half * longer,
            rows,
            checked,
            self._deviation(best, longer),
            t,
            place,
            speed / longer,
            columns,
            tops,
            tuple(told),
        )

    def _deviation(self, best: _Found, longer: float) -> float:
        """How far the motion leaves the way between its rows, in robot sizes, and the way the trajectory."""
        most, smooth = 0.0, best.smooth
        for k, one in enumerate(self.solvers):
            here = smooth.inside(k, best.t / longer, last=True)
            t = best.t[here][:: max(1, int(here.sum()) // 200) | 1]
            for q, s in zip(best.spline(t), smooth.place(k, t / longer), strict=True):
                most = max(most, float(np.abs(one.piece.away(q, float(s), self.units) * self.units).max()))
        return most + self.way.missed * float(self.units.max())
