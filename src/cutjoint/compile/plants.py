"""Compiled robots as plants: between two samples of a controller they are integrated in machine code.

Order 5 with the error of every step under control (`cutjoint.compile.machine.llvm.advance`), far below what a
controller or a sensor resolves.  Where a step cannot be trusted nothing is handed out, and whoever simulates goes on
with the equations of motion one evaluation at a time, which come from the model itself there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.compiled_chain import CompiledChain
from cutjoint.compile.compiled_paper import CompiledPaper
from cutjoint.compile.compiler import Compiled
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.compile.functions.library import Library
from cutjoint.compile.machine.backends import backend
from cutjoint.compile.machine.kernel import MotionPrograms
from cutjoint.mechanism import Posture
from cutjoint.mechanism.rotations import quaternion_of
from cutjoint.simulation import ConstrainedPlant, ReducedPlant
from cutjoint.simulation.plant import Advanced, Observation, State

RELATIVE, ABSOLUTE = 1e-10, 1e-12
"""Tolerance of a step."""
METHOD = f"Dormand-Prince 5(4) in machine code, tolerances {RELATIVE:g} and {ABSOLUTE:g}"


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
        self._advance = backend(options.backend).advance(self.motion, RELATIVE, ABSOLUTE, STRAIN_LIMIT)
        self._values = values

    def __call__(
        self, q: Array, v: Array, effort: Array, span: float, ahead: float
    ) -> tuple[Array, Array, tuple[float, float], Array, int, float] | None:
        """Positions and velocities after `span` [s], the work of efforts and what friction took [J], what the loops
        were open by before they were closed and are now, shape (2, rows), evaluations, and the step to go on with [s];
        None where that cannot be trusted."""
        n, rows = self.motion.positions, self.motion.rows
        state, given = np.concatenate((q, v, (0.0, 0.0))), np.concatenate((effort, self._values))
        residual, step = np.zeros((2, rows)), np.array([ahead])
        calls = self._advance(state, given, residual, step, span)
        # a sum is finite only if all its terms are
        if calls < 0 or not np.isfinite(np.add.reduce(state) + np.add.reduce(residual[1])):
            return None
        work, lost = state[-2:].tolist()
        return state[:n], state[n:-2], (work, lost), residual, calls, float(step[0])


class CompiledPlant(ReducedPlant):
    """A compiled robot in its actuated coordinates.

    Raises:
        CutjointError: its actuators do not determine its motion, it has no tool, or it cannot be compiled.
    """

    method = METHOD

    def __init__(self, robot: Compiled) -> None:
        self.robot = robot
        self._library = robot.library()
        values = np.array(list(robot.parameters.values()))
        self._values = values
        self._stretches = Stretches(self._library, "motion", values, settled=True)
        self._lengths = robot.source.closure.is_length if isinstance(robot, CompiledChain) else np.zeros(0, dtype=bool)
        super().__init__(robot)

    @property
    def name(self) -> str:
        """For messages and tables."""
        return self.robot.name

    def advance(self, state: State, effort: Array, span: float, ahead: float) -> Advanced | None:
        """See `Advancing.advance`."""
        at = state.posture
        if at is None or self.robot.library(at) is not self._library:
            return None
        found = self._stretches(self.robot.positions(at), state.v, effort, span, ahead)
        if found is None:
            return None
        q, v, works, residual, calls, ahead = found
        if isinstance(self.robot, CompiledChain):
            before, after = (self._gap(one) for one in residual)
            posture = Posture(q[list(self.robot.source.actuated)], q, after, at.layout)
        else:
            before, posture = (0.0, 0.0), self.robot.close(q, at, limits="ignore")
        return Advanced(State(posture.q, v, posture), *works, before[0], calls, ahead)

    def _gap(self, residual: Array) -> tuple[float, float]:
        size, lengths = np.abs(residual), self._lengths
        return float(size[lengths].max(initial=0.0)), float(size[~lengths].max(initial=0.0))

    def observe_all(self, states: Sequence[State]) -> list[Observation]:
        """See `Advancing.observe_all`."""
        postures = [state.posture for state in states]
        if not states or any(at is None or self.robot.library(at) is not self._library for at in postures):
            return [self.observe(state) for state in states]
        q = np.array([self.robot.positions(at) for at in postures if at is not None])
        v = np.array([state.v for state in states])
        tools, good = self._library.interpreted("tool").batch([q, v, self._values])
        energies, well = self._library.interpreted("energy").batch([q, v, self._values])
        trusted = good & well
        return [
            self._observation(state, {name: x[k] for name, x in {**tools, **energies}.items()})
            if trusted[k]
            else self.observe(state)
            for k, state in enumerate(states)
        ]

    def _observation(self, state: State, parts: dict[str, Array]) -> Observation:
        at, twist = state.posture, parts["twist"]
        assert at is not None, "see `observe_all`"
        turned = (quaternion_of(parts["rotation"]), twist[3:]) if self._turns else ()
        kinetic, potential = float(parts["kinetic"][0]), float(parts["potential"][0])
        return Observation(at.q, state.v, parts["position"], twist[:3], kinetic, potential, at.gap, at.q_full, *turned)


class CompiledConstrainedPlant(ConstrainedPlant):
    """A compiled chain in all joints of its tree, for any actuation.

    Raises:
        CutjointError: it has no tool, or cannot be compiled.
    """

    method = METHOD

    def __init__(self, robot: CompiledChain) -> None:
        super().__init__(robot.plain)
        self.robot = robot
        self._stretches = Stretches(
            robot.library(), "full_motion", np.array(list(robot.parameters.values())), settled=False
        )

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.robot,)

    @property
    def name(self) -> str:
        """For messages and tables."""
        return f"{self.robot.name}, constrained"

    def acceleration(self, state: State, effort: Array, push: Array | None = None) -> Array:
        """Of all joints, shape (nv,)."""
        full = self.chain.full_effort(effort)
        return self.robot.full_acceleration(state.q, state.v, full if push is None else full + push)

    def advance(self, state: State, effort: Array, span: float, ahead: float) -> Advanced | None:
        """See `Advancing.advance`."""
        found = self._stretches(state.q, state.v, self.chain.full_effort(effort), span, ahead)
        if found is None:
            return None
        q, v, works, _, calls, ahead = found
        settled, gap = self.settled(State(q, v))
        return Advanced(settled, *works, gap, calls, ahead)

    def observe_all(self, states: Sequence[State]) -> list[Observation]:
        """See `Advancing.observe_all`."""
        return [self.observe(state) for state in states]


def compiled_plant(robot: Compiled) -> CompiledPlant | CompiledConstrainedPlant:
    """A compiled robot as a plant: in its actuated coordinates where these tell its motion, else in all joints.

    Raises:
        CutjointError: it has no tool, or cannot be compiled.
    """
    if isinstance(robot, CompiledPaper) or (robot.source.determined and robot.idle_is_cyclic):
        return CompiledPlant(robot)
    return CompiledConstrainedPlant(robot)
