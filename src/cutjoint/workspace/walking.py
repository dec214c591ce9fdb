"""Leading the tool of many postures side by side from point to point, as far as it can go on one branch.

Who leads is a `Walker`.  `march` asks it for whole ways first, and for shorter and shorter ones where the tool does not
come through; so the end of the way is found to a part of its length.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.compile import CompiledChain
from cutjoint.compile.batch import cores
from cutjoint.compile.equations import newton
from cutjoint.compile.functions.library import CompiledFunction
from cutjoint.errors import CutjointError
from cutjoint.mechanism import JointLimits, Mechanism, Posture
from cutjoint.mechanism.task import NAMES
from cutjoint.tolerances import CLOSURE
from cutjoint.workspace.goals import Goals

Mask = npt.NDArray[np.bool_]
Watch = Callable[[Array], Mask]
"""States (N, positions) -> which of them are allowed."""
NUDGE = 1e-5
"""How far a goal is moved to see how the joints follow, in lengths of the robot or radians."""
CHANGE = 1.2
"""Largest change of the rates of the joints from one posture to the next, against the least of the two; behind a type-1
singularity they have turned round, which is a change of 2."""
NARROWER = 4.0
"""Largest change of the determinant of the rates of the actuators, up or down, from one posture to the next."""
FINEST = 5
"""How often a way is halved where the tool does not come through, as a rule."""


STRAIN = 1e6
"""Largest strain (see `cutjoint.compile.equations.reduction`) of one step of Newton's method here.  Beyond 1000 other
compiled answers are thrown away; here what is left open is looked at after every step, and a wall of postures where one
order of elimination fails would part a workspace that is one."""


class Walker(Protocol):
    """Leads the tool of many postures.  A state is a row of numbers that tells a posture.

    Attributes:
        start: the state that all come from, shape (state,).
        at: coordinates of the tool there, shape (axes,).
    """

    start: Array
    at: Array

    def step(self, states: Array, begin: Array, to: Array) -> tuple[Array, Mask]:
        """States with the tool at coordinates `to` (N, axes), one short way from others with the tool at `begin`, and
        which of them came there, plainly on the same branch."""

    def actuated(self, states: Array) -> Array:
        """Actuated coordinates of states, shape (N, n)."""

    def posture(self, state: Array) -> Posture:
        """The posture of a state."""


def march(walker: Walker, states: Array, begin: Array, to: Array, finest: int = FINEST) -> tuple[Array, Array]:
    """Lead states from coordinates `begin` to coordinates `to`, both (N, axes), as far as they come.

    Returns:
        The states there, and what part of its way each has gone: 1 where it came to the end, else to 2 ** -finest.
    """
    states, done = np.array(states), np.zeros(len(states))
    stride, rows = np.ones(len(states)), np.arange(len(states))
    least = 0.5**finest
    while len(rows):
        part = np.minimum(done[rows] + stride[rows], 1.0)
        way = to[rows] - begin[rows]
        from_here, to_there = begin[rows] + done[rows, None] * way, begin[rows] + part[:, None] * way
        found, good = walker.step(states[rows], from_here, to_there)
        states[rows[good]], done[rows[good]] = found[good], part[good]
        stride[rows[~good]] *= 0.5
        rows = rows[(done[rows] < 1.0) & (stride[rows] >= least)]
    # what is not reached lies within the last stride that failed
    short = done < 1.0
    done[short] = np.minimum(done[short] + 0.5 * least, 1.0 - 0.5 * least)
    return states, done


class ChainWalker:
    """Leads the tool of a closed chain by its compiled functions.

    The branch is kept in three ways: the steps of Newton's method are short and shrink; the rates of all joints by the
    led coordinates, which have no bound at type-1 singularities and turn round behind them, change by less than half of
    themselves; and the determinant of those of the actuators alone, which vanishes at type-2 singularities, changes by
    less than a factor of two and keeps its sign.

    Args:
        robot: the chain.
        goals: what coordinates ask of the tool.
        start: the posture that all come from.
        across: whether type-2 singularities may be crossed.
        limits: whether joint limits are kept.
        watch: what is asked of every configuration beside that.
    """

    def __init__(
        self,
        robot: CompiledChain,
        goals: Goals,
        start: Posture,
        *,
        across: bool = False,
        limits: bool = True,
        watch: Watch | None = None,
    ) -> None:
        source = robot.source
        self._reach: CompiledFunction = robot.library()["reach_step"]
        names = [part.name for part in self._reach.row.parts]
        self._places = [names.index(name) for name in ("q_next", "size", "gap")]
        self._robot, self._goals, self._watch = robot, goals, watch
        self._values, self._threads, self._across = np.array(list(robot.parameters.values())), cores(), across
        self._actuated, self._scale = list(source.actuated), np.asarray(source.position_scale)
        self._nudges = np.where(np.array(robot.task.rows) < 3, NUDGE * source.chain.length, NUDGE)
        lower, upper = source.limits
        self._lower = np.minimum(lower, start.q_full) if limits else np.full(len(lower), -np.inf)
        self._upper = np.maximum(upper, start.q_full) if limits else np.full(len(upper), np.inf)
        self.at, self.start = goals.of(start, robot), np.array(start.q_full)

    def actuated(self, states: Array) -> Array:
        return np.asarray(states[:, self._actuated])

    def posture(self, state: Array) -> Posture:
        return self._robot.chain.posture(state)

    def step(self, states: Array, begin: Array, to: Array) -> tuple[Array, Mask]:
        found, good = self._newton(states, self._goals.frames(to))
        good &= ((found >= self._lower) & (found <= self._upper)).all(axis=1)
        rows = np.flatnonzero(good)
        if not len(rows):
            return found, good
        both = self.rates(np.concatenate([found[rows], states[rows]]), np.concatenate([to[rows], begin[rows]]))
        good[rows] = self._joined(both)
        if self._watch is not None and good.any():
            good[good] = self._watch(found[good])
        return found, good

    def _newton(self, states: Array, goals: Array) -> tuple[Array, Mask]:
        """Newton's method in steps that are short and shrink."""
        found, good = np.array(states), np.zeros(len(states), dtype=bool)
        q, rows = np.ascontiguousarray(states), np.arange(len(states))
        last: Array | None = None
        for _ in range(newton.STEPS):
            after, size, gap = self._step(q, goals[rows])
            fine = size <= newton.longest(last)
            ended = fine & (gap <= 0.1 * CLOSURE.value) & (size <= 1e-9)
            found[rows[ended]], good[rows[ended]] = q[ended], True
            on = fine & ~ended
            q, last, rows = np.ascontiguousarray(after[on]), size[on], rows[on]
            if not len(rows):
                break
        return found, good

    def _step(self, q: Array, goals: Array) -> tuple[Array, Array, Array]:
        """Position variables after one step of Newton's method, its size, and what was left before it; the size is NaN
        where it cannot be trusted."""
        *parts, strain = self._reach.kernel.batch([q, goals, self._values], threads=self._threads)
        after, size, gap = (parts[k] for k in self._places)
        doubtful = ~(strain[:, 0] <= STRAIN) | ~np.isfinite(after.sum(axis=1))
        return after, np.where(doubtful, np.nan, size[:, 0]), gap[:, 0]

    def _joined(self, both: Rates) -> Mask:
        """Whether no singularity lies between postures, the rates of the first ones before those of the others."""
        half = len(both.full) // 2
        full, other = both.full[:half], both.full[half:]
        size = np.minimum(np.abs(full).max(axis=(1, 2)), np.abs(other).max(axis=(1, 2)))
        joined = np.abs(full - other).max(axis=(1, 2)) <= CHANGE * size
        if not self._across:
            determinant = np.linalg.det(both.actuated)
            with np.errstate(divide="ignore", invalid="ignore"):
                ratio = determinant[:half] / determinant[half:]
            joined &= (ratio > 1.0 / NARROWER) & (ratio < NARROWER)
        return np.asarray(joined & both.trusted[:half] & both.trusted[half:])

    def rates(self, q: Array, at: Array) -> Rates:
        """Rates of the joints by all led coordinates, at closed configurations with the tool at coordinates `at`
        (N, axes).

        One step of Newton's method towards a goal that is moved along one led coordinate moves all joints as their
        rates by it say.  No elimination in which the tool follows from the actuators is asked, which fails at type-2
        singularities and, its order being fixed, elsewhere.
        """
        goals = self._goals.moved(self._goals.frames(at), self._nudges)
        count, n = len(q), len(self._nudges)
        after, size, _ = self._step(np.repeat(q, n, axis=0), goals.reshape(count * n, 12))
        moved = (after.reshape(count, n, -1) - q[:, None]).transpose(0, 2, 1)
        trusted: Mask = np.asarray(np.isfinite(size))
        full = moved / self._scale[:, None] / NUDGE
        return Rates(full, moved[:, self._actuated] / self._nudges, np.asarray(trusted.reshape(count, n).all(axis=1)))


class Rates(NamedTuple):
    """How joints follow the led coordinates at N postures.

    Attributes:
        full: of all position variables, dimensionless, shape (N, positions, n).
        actuated: of the actuators, shape (N, n, n), in their units by those of the coordinates.
        trusted: where the compiled equations may be trusted.
    """

    full: Array
    actuated: Array
    trusted: Mask


class SlowWalker:
    """Leads the tool of any mechanism, one posture after the other, by its own `reach`.

    Args:
        robot: the mechanism.
        goals: what coordinates ask of the tool.
        start: the posture that all come from.
        across: whether type-2 singularities may be crossed.
        limits: whether joint limits are kept.
        watch: what is asked of every configuration beside that.
    """

    def __init__(
        self,
        robot: Mechanism,
        goals: Goals,
        start: Posture,
        *,
        across: bool = False,
        limits: bool = True,
        watch: Watch | None = None,
    ) -> None:
        self._robot, self._goals, self._watch = robot, goals, watch
        self._limits: JointLimits = "respect" if limits else "ignore"
        self._postures: list[Posture] = [start]
        self.start, self.at = np.zeros(1), goals.of(start, robot)
        self._rows = [NAMES.index(name) for name in (goals.names + tuple(goals.held))]
        self._side = 0.0 if across else self._determinant(start)

    def actuated(self, states: Array) -> Array:
        return np.array([self.posture(one).q for one in states]).reshape(len(states), self._robot.n)

    def posture(self, state: Array) -> Posture:
        return self._postures[int(state[0])]

    def step(self, states: Array, begin: Array, to: Array) -> tuple[Array, Mask]:
        found, good = np.array(states), np.zeros(len(states), dtype=bool)
        for row, wanted in enumerate(to):
            posture = self._reached(self._goals.named(wanted), self.posture(states[row]))
            if posture is not None:
                found[row, 0], good[row] = len(self._postures), True
                self._postures.append(posture)
        return found, good

    def _reached(self, target: Mapping[str, float], near: Posture) -> Posture | None:
        try:
            found = self._robot.reach(target, near, free=self._goals.free, limits=self._limits)
            if self._side and not self._determinant(found) * self._side > 0.0:
                return None
        except CutjointError:
            return None
        if self._watch is not None and not self._watch(found.q_full[None])[0]:
            return None
        return found

    def _determinant(self, at: Posture) -> float:
        """Of the coordinates that are led by the actuators, which changes its sign at singularities of both types; 0
        where there are more actuators than coordinates."""
        if len(self._rows) != self._robot.n:
            return 0.0
        frame, basis = self._robot.tool(at).frame_jacobian, self._goals.basis.T
        return float(np.linalg.det(np.concatenate([basis @ frame[:3], basis @ frame[3:]])[self._rows]))
