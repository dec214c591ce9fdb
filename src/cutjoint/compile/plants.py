"""Compiled robots as plants: between two samples of a controller they are integrated in machine code.

Order 5 with the error of every step under control (`cutjoint.compile.machine.llvm.advance`), far below what a
controller or a sensor resolves.  Where a step cannot be trusted nothing is handed out, and whoever simulates goes on
with the equations of motion one evaluation at a time, which come from the model itself there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.compiled_chain import CompiledChain
from cutjoint.compile.compiled_paper import CompiledPaper
from cutjoint.compile.compiler import Compiled
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.compile.functions.library import Library
from cutjoint.compile.machine.backends import backend
from cutjoint.compile.machine.kernel import MotionPrograms
from cutjoint.doors import door
from cutjoint.mechanism.rotations import quaternion_of
from cutjoint.reprs import line
from cutjoint.simulation import ConstrainedPlant, ReducedPlant
from cutjoint.simulation.plant import Advanced, Observation, State

RELATIVE, ABSOLUTE = 1e-10, 1e-12
"""Tolerance of a step."""
METHOD = f"Dormand-Prince 5(4) in machine code, tolerances {RELATIVE:g} and {ABSOLUTE:g}"
OPEN = 1e-13
"""Loops that are open by no more than this, in lengths of the robot, are left as they are."""


class Stretched(NamedTuple):
    """What became of a robot: positions, velocities, work of the efforts and what friction took [J], what the loops
    were open by before they were closed and are now, shape (2, rows), what else is asked for of the state, evaluations,
    and the step to go on with [s]."""

    q: Array
    v: Array
    work: float
    lost: float
    residual: Array
    more: Array
    evaluations: int
    ahead: float


class Stretches:
    """Integrates one robot over stretches of time with the same efforts.

    Args:
        library: the compiled functions.
        motion: name of the one that gives the rates.
        values: of the parameters that are arguments.
        settled: whether positions are put onto the loops at the end of a stretch.

    Raises:
        CutjointError: the robot has no such function, or it cannot be compiled.
    """

    def __init__(self, library: Library, motion: str, values: Array, *, settled: bool) -> None:
        source, options = library.source, library.options
        step = library.program("step") if settled and source.rows else None
        places = tuple(int(k) for k in getattr(source, "actuated", range(source.n))) if step else ()
        self.motion = MotionPrograms(library.program(motion), step, places)
        self._advance = backend(options.backend).advance(
            self.motion, RELATIVE, ABSOLUTE, STRAIN_LIMIT, kept=options.cached
        )
        self._values = values

    def __call__(self, q: Array, v: Array, effort: Array, span: float, ahead: float) -> Stretched | None:
        """From positions and velocities over `span` [s], with steps of about `ahead` [s] at first; None where that
        cannot be trusted."""
        n, rows = self.motion.positions, self.motion.rows
        state, given = np.concatenate((q, v, (0.0, 0.0))), np.concatenate((effort, self._values))
        found, step = np.zeros(2 * rows + self.motion.more), np.array([ahead])
        calls = self._advance(state, given, found, step, span)
        # a sum is finite only if all its terms are
        if calls < 0 or not np.isfinite(np.add.reduce(state) + np.add.reduce(found[rows:])):
            return None
        residual, more = found[: 2 * rows].reshape(2, rows), found[2 * rows :]
        work, lost = state[-2:].tolist()
        return Stretched(state[:n], state[n:-2], work, lost, residual, more, calls, float(step[0]))


class CompiledChainPlant(ConstrainedPlant):
    """A compiled chain: between samples in its actuated coordinates where these tell its motion, else in all joints.

    Raises:
        CutjointError: it has no tool, or cannot be compiled.
    """

    method = METHOD

    __repr__ = line("name")

    def __init__(self, robot: CompiledChain) -> None:
        super().__init__(robot.plain)
        self.robot, self._library = robot, robot.library()
        self._values = np.array(list(robot.parameters.values()))
        self._reduced = robot.source.determined and not robot.source.idle
        motion = "motion" if self._reduced else "full_motion"
        self._stretches = Stretches(self._library, motion, self._values, settled=self._reduced)
        self._lengths, self._open = robot.source.closure.is_length, OPEN * robot.source.row_scale

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.robot,)

    @property
    def name(self) -> str:
        """For messages and tables."""
        return self.robot.name

    def acceleration(self, state: State, effort: Array, push: Array | None = None) -> Array:
        """Of all joints, shape (nv,)."""
        full = self.chain.full_effort(effort)
        return self.robot.full_acceleration(state.q, state.v, full if push is None else full + push)

    def advance(self, state: State, effort: Array, span: float, ahead: float) -> Advanced | None:
        """See `Advancing.advance`."""
        if self._reduced:
            done = self._stretches(state.q, state.v[self.actuated], effort, span, ahead)
            if done is None:
                return None
            after, gap = State(done.q, done.more), self._gap(done.residual[0])[0]
        else:
            done = self._stretches(state.q, state.v, self.chain.full_effort(effort), span, ahead)
            if done is None:
                return None
            after, gap = State(done.q, done.v), self._gap(done.more)[0]
            if (np.abs(done.more) > self._open).any():
                after, gap = self.settled(after)
        return Advanced(after, done.work, done.lost, gap, done.evaluations, done.ahead)

    def _gap(self, residual: Array) -> tuple[float, float]:
        size, lengths = np.abs(residual), self._lengths
        return float(size[lengths].max(initial=0.0)), float(size[~lengths].max(initial=0.0))

    def observe_all(self, states: Sequence[State]) -> list[Observation]:
        """See `Advancing.observe_all`."""
        if not (self._reduced and states):
            return [self.observe(state) for state in states]
        q, v = np.array([one.q for one in states]), np.array([one.v[self.actuated] for one in states])
        closed, good = self._library.soon("step").batch([q, q[:, list(self.robot.source.actuated)], self._values])
        rows = zip(states, looked(self._library, [q, v, self._values]), good, closed["residual"], strict=True)
        return [
            self.observe(state) if seen is None or not well else self._observation(state, seen, self._gap(residual))
            for state, seen, well, residual in rows
        ]

    def _observation(self, state: State, seen: dict[str, Array], gap: tuple[float, float]) -> Observation:
        q, v = self.measured(state)
        return _observation(q, v, seen, gap, state.q, self._turns)


class CompiledPaperPlant(ReducedPlant):
    """A compiled published model.

    Raises:
        CutjointError: it cannot be compiled.
    """

    method = METHOD

    __repr__ = line("name")

    def __init__(self, robot: CompiledPaper) -> None:
        super().__init__(robot)
        self.robot, self._library = robot, robot.library()
        self._values = np.array(list(robot.parameters.values()))
        self._stretches = Stretches(self._library, "motion", self._values, settled=False)

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.robot,)

    @property
    def name(self) -> str:
        """For messages and tables."""
        return self.robot.name

    def advance(self, state: State, effort: Array, span: float, ahead: float) -> Advanced | None:
        """See `Advancing.advance`."""
        at = state.posture
        if at is None or self.robot.library(at) is not self._library:
            return None
        done = self._stretches(state.q, state.v, effort, span, ahead)
        if done is None:
            return None
        after = State(done.q, done.v, self.robot.close(done.q, at, limits="ignore"))
        return Advanced(after, done.work, done.lost, 0.0, done.evaluations, done.ahead)

    def observe_all(self, states: Sequence[State]) -> list[Observation]:
        """See `Advancing.observe_all`."""
        postures = [state.posture for state in states]
        if not states or any(at is None or self.robot.library(at) is not self._library for at in postures):
            return [self.observe(state) for state in states]
        q, v = np.array([one.q for one in states]), np.array([one.v for one in states])
        found = looked(self._library, [q, v, self._values])
        return [
            self.observe(state) if seen is None else self._observation(state, seen)
            for state, seen in zip(states, found, strict=True)
        ]

    def _observation(self, state: State, seen: dict[str, Array]) -> Observation:
        at = state.posture
        assert at is not None, "see `observe_all`"
        return _observation(at.q, state.v, seen, at.gap, at.q_full, self._turns)


def looked(library: Library, arguments: Sequence[Array]) -> Iterator[dict[str, Array] | None]:
    """Tool and energies of many states, row by row; None where they must not be trusted."""
    tools, good = library.soon("tool").batch(arguments)
    energies, well = library.soon("energy").batch(arguments)
    for k, trusted in enumerate(good & well):
        yield {name: x[k] for name, x in {**tools, **energies}.items()} if trusted else None


def _observation(
    q: Array, v: Array, parts: dict[str, Array], gap: tuple[float, float], q_full: Array, turns: bool
) -> Observation:
    """What to record of a state; `parts` are of the functions for tool and energies."""
    kinetic, potential = float(parts["kinetic"][0]), float(parts["potential"][0])
    twist, turned = parts["twist"], np.array(quaternion_of(parts["rotation"])) if turns else None
    return Observation(
        q, v, parts["position"], twist[:3], kinetic, potential, gap, q_full, turned, twist[3:] if turns else None
    )


@door
def compiled_plant(robot: Compiled) -> CompiledChainPlant | CompiledPaperPlant:
    """A compiled robot as a plant.

    Raises:
        CutjointError: it has no tool, or cannot be compiled.
    """
    return CompiledPaperPlant(robot) if isinstance(robot, CompiledPaper) else CompiledChainPlant(robot)
