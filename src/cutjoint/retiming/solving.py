"""The quickest motion along one piece of a way: rounds of the reachability passes, each with tangents of damping and
power at the speeds of the round before, until the time that it takes stays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import RetimingError
from cutjoint.mechanism import Mechanism
from cutjoint.retiming.limits import MotionLimits
from cutjoint.retiming.path import WayPiece, WholeWay
from cutjoint.retiming.rows import LimitRows, Margins, rows_of, static_faults
from cutjoint.retiming.sweep import Blocked, quickest
from cutjoint.retiming.terms import WayTerms
from cutjoint.retiming.time_law import elapsed

ROUNDS, STAYS, NEARLY = 40, 1e-4, 0.02
"""Rounds, and by what part the time changes where it stays, and where it nearly does."""
RETRIES = 12
LAPS = 3


class PieceSolver:
    """Finds the quickest motion along one piece.

    Attributes:
        piece: of the way.
        terms: of motion along it, with the friction at the speeds that were found last.
        squares: s_dot^2 of the last round, shape (k,).
        goes_round: whether its end is its beginning, passed at speed.
    """

    def __init__(self, robot: Mechanism, way: WholeWay, piece: WayPiece, terms: WayTerms, *, goes_round: bool) -> None:
        self.piece, self.terms, self.goes_round = piece, terms, goes_round
        self._robot, self._way = robot, way
        self.squares = np.zeros(len(piece.s))

    def solve(self, limits: MotionLimits, margins: Margins) -> Array:
        """s_dot^2 at the samples, shape (k,).

        Raises:
            RetimingError: no motion keeps the limits; it tells which, and where.
        """
        powered = bool(np.isfinite(limits.power).any())
        if not (powered or self._robot.dissipates):
            self.squares = self._once(limits, margins, np.ones(len(self.piece.s)))
            return self.squares
        if not self.squares.any():
            self._begin(limits, margins, powered=powered)
        before, fresh = np.inf, False
        for _ in range(ROUNDS):
            self.squares = self._patiently(limits, margins)
            time = float(elapsed(self.piece.s, self.squares)[-1])
            change = abs(time - before) / time
            if change <= STAYS and fresh:
                break
            fresh = change <= NEARLY
            if fresh:  # friction costs more than all the rest of a round
                self.terms = self.terms.rubbed(self._robot, self.piece, self.squares)
            before = time
        return self.squares

    def _begin(self, limits: MotionLimits, margins: Margins, *, powered: bool) -> None:
        """A first guess: without the limits of power, then slowed to keep them."""
        free = replace(limits, power=np.full_like(limits.power, np.inf))
        first = np.ones(len(self.piece.s))
        for _ in range(3 if self._robot.dissipates else 1):
            self.terms = self.terms.rubbed(self._robot, self.piece, first)
            first = self._once(free, margins, first)
        self.squares = first
        if powered:
            self.squares = self._slowed(limits)

    def like(self, s: Array, squares: Array) -> None:
        """Begin with s_dot^2 as they were found at other samples."""
        self.squares = np.interp(self.piece.s, s, squares)
        self.terms = self.terms.rubbed(self._robot, self.piece, self.squares)

    def halved(self, limits: MotionLimits, margins: Margins) -> float:
        """The time that the piece takes with every other sample, after `solve` [s]; infinite where that is too few."""
        kept = np.unique(np.append(np.arange(0, len(self.piece.s), 2), len(self.piece.s) - 1))
        rows, s = rows_of(self.terms, limits, margins, self.squares), self.piece.s[kept]
        few = LimitRows(rows.a[kept], rows.b[kept], rows.g[kept], rows.of)
        found = self._round(few, s) if self.goes_round else quickest(few, s)
        return np.inf if isinstance(found, Blocked) else float(elapsed(s, found)[-1])

    def _patiently(self, limits: MotionLimits, margins: Margins) -> Array:
        """Once, from slower tangents where quick ones leave nothing."""
        for last in [False] * RETRIES + [True]:
            try:
                return self._once(limits, margins, self.squares)
            except RetimingError:
                if last:
                    raise
                self.squares = 0.25 * self.squares
        raise AssertionError

    def _once(self, limits: MotionLimits, margins: Margins, squares: Array) -> Array:
        rows = rows_of(self.terms, limits, margins, squares)
        found = self._round(rows, self.piece.s) if self.goes_round else quickest(rows, self.piece.s)
        if isinstance(found, Blocked):
            raise self._none(found, rows, limits)
        return found

    def _round(self, rows: LimitRows, s: Array) -> Array | Blocked:
        """A lap in the middle of several, whose begin and end are forgotten."""
        count = len(s) - 1
        whole = s[-1] - s[0]
        around = np.concatenate([np.tile(np.arange(count), LAPS), [count]])
        laps = np.concatenate([*(s[:-1] + lap * whole for lap in range(LAPS)), [s[-1] + (LAPS - 1) * whole]])
        many = LimitRows(rows.a[around], rows.b[around], rows.g[around], rows.of)
        found = quickest(many, laps)
        if isinstance(found, Blocked):
            return Blocked(found.at % count, found.rows)
        middle = found[count : 2 * count + 1].copy()
        middle[0] = middle[-1] = min(middle[0], middle[-1])
        return middle

    def _slowed(self, limits: MotionLimits) -> Array:
        """The squares of a motion that keeps the power at every sample, were it slowed there alone."""
        x, terms = np.maximum(self.squares, 1e-9 * self.squares.max()), self.terms
        u = np.gradient(x, self.piece.s) / 2.0
        moving = terms.per_acceleration * u[:, None] + terms.per_square * x[:, None]
        part = np.ones(len(x))
        for _ in range(60):
            effort = moving * part[:, None] + terms.holding + terms.dry
            spent = np.abs(effort * terms.rates) * np.sqrt(part * x)[:, None]
            over = (spent > limits.power).any(axis=1)
            if not over.any():
                break
            part[over] *= 0.8
        return np.asarray(part * x)

    def _none(self, found: Blocked, rows: LimitRows, limits: MotionLimits) -> RetimingError:
        """Why there is no motion."""
        place = float(self.piece.s[found.at])
        faults = static_faults(self.terms, limits)
        if faults:
            j, (where, needed) = max(faults.items(), key=lambda one: abs(one[1][1]) / limits.effort[one[0]])
            time, unit = self._way.time_of(where), limits.unit("effort", j)
            return RetimingError(
                f"no motion along the way: to hold the robot still where the trajectory is at t = {time:.4g} s "
                f"(s = {where:.3g} of the way) {limits.actuators[j].name} needs {abs(needed):.4g} {unit}, and its "
                f"limit is {limits.effort[j]:.4g} {unit}. Raise that limit, or lighten the robot or its load",
                limits=[limits.named("effort", j)],
                place=where,
                t=time,
            )
        named = list(dict.fromkeys(limits.named(*rows.of[k]) for k in found.rows)) or ["the limits together"]
        time = self._way.time_of(place)
        return RetimingError(
            f"no motion along the way: where the trajectory is at t = {time:.4g} s (s = {place:.3g} of the way), "
            f"{' and '.join(named)} leave no acceleration with which the rest can be gone. Raise them",
            limits=named,
            place=place,
            t=time,
        )
