"""One closed loop, plant and law and integrator, as programs: what many runs of it compute at every step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.compile.compiler import Compiled
from cutjoint.compile.expressions.functions import absolute, maximum
from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.expressions.program import Program
from cutjoint.compile.expressions.straight_line import assemble
from cutjoint.compile.functions.tracing import accelerations
from cutjoint.compile.machine.backends import backend
from cutjoint.compile.machine.kernel import Event, LoopParts, Sizes, Stages
from cutjoint.compile.machine.schedule import scheduled
from cutjoint.compile.mechanism import CompiledMechanism
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.compile.sources.interface import Need, TracedState
from cutjoint.compile.sources.law import TracedDesired, trace_law
from cutjoint.compile.sources.paper import PaperSource
from cutjoint.control import Law
from cutjoint.mechanism import Mechanism
from cutjoint.papers.reduced_model import ClosedFormModel
from cutjoint.simulation import ReducedPlant

STAGES: Mapping[str, Stages] = {
    "rk4": Stages((0.5, 0.5, 1.0), (1, 2, 2, 1), 6),
    "midpoint": Stages((0.5,), (0, 1), 1),
}
"""The methods of `cutjoint.simulation.integrators.FIXED_STEP` that can be compiled."""


@dataclass(frozen=True, eq=False)
class TracedLoop:
    """A closed loop as programs.

    Attributes:
        plant, law, limits: what it is made of.
        rate: of the controller [Hz]; None acts at every stage.
        method: name of the integrator.
        gains: names of the law's gains that are arguments.
        memory: states of the law; continuous ones stand behind the velocities in the state.
        desired: what is read of the reference.
        parts: the programs, and the sizes of what they read and write.
    """

    plant: Compiled
    law: Law
    gains: tuple[str, ...]
    limits: Array | None
    rate: float | None
    method: str
    memory: int
    desired: TracedDesired
    parts: LoopParts


class _Tracing:
    """What all programs of one loop are traced from.

    Attributes:
        state: position variables, velocities, and without events the law's memory.
        memory: what only events change.
    """

    def __init__(
        self, plant: Compiled, law: Law, mechanism: Mechanism, gains: tuple[str, ...], sampled: bool, noise: int
    ) -> None:
        self.plant, self.law = plant, law
        n, p, own = plant.n, plant.source.positions, law.memory(plant.n)
        graph = self.graph = Graph()
        self.state = graph.symbols(p + n + (0 if sampled else own))
        self.gains = {name: graph.symbols(n) for name in gains}
        self.parameters = graph.symbols(len(plant.options.parameters))
        self.memory = graph.symbols(n + own if sampled else 0)
        self.noise = graph.symbols(noise)
        self.v = self.state[p : p + n]
        self.traced = plant.source.state(graph, self.state[:p], self.parameters)
        self.desired = TracedDesired(graph, n, mechanism)

    @property
    def given(self) -> list[Expression]:
        """The arguments that are each run's own."""
        return [*(x for xs in self.gains.values() for x in xs), *self.parameters]

    def controlled(self, memory: list[Expression], top: Array | None) -> tuple[list[Number], list[Number]]:
        """Effort and rate of the law's memory."""

        def seen_by(model: Mechanism) -> TracedState | None:
            return measured_state(model, self.plant, self.traced, self.graph)

        return trace_law(self.law, self.desired, self.traced, self.v, memory, self.gains, top, seen_by)

    def program(self, name: str, results: Mapping[str, list[Number]], *, noise: bool = False) -> Program:
        """The program of some results."""
        arguments = {"state": self.state, "row": self.desired.symbols, "given": self.given, "memory": self.memory}
        if noise:
            arguments["noise"] = self.noise
        fused = backend(self.plant.options.backend).fused()
        return scheduled(assemble(self.graph, name, arguments, results, fused=fused))

    def settle(self) -> Program | None:
        """The Newton step onto the loops."""
        source = self.plant.source
        settled, residuals = self.traced.settled(None)
        if not isinstance(source, ChainSource) or not residuals:
            return None
        gaps: dict[bool, Number] = {True: 0.0, False: 0.0}
        for residual, is_length in zip(residuals, source.closure.is_length.tolist(), strict=True):
            gaps[is_length] = maximum(absolute(residual), gaps[is_length])
        open_by = maximum(gaps[True] * (1.0 / source.chain.length), gaps[False])
        return self.program("settle", {"state": settled, "residual": [open_by], "strain": [self.traced.strain]})


def traced_loop(
    plant: Compiled,
    law: Law,
    mechanism: Mechanism,
    gains: tuple[str, ...],
    limits: npt.ArrayLike | None,
    rate: float | None,
    method: str,
) -> TracedLoop:
    """Trace a closed loop; see `ClosedLoop` for arguments and errors."""
    source, n = plant.source, plant.n
    if (lack := source.lacks(Need.ACTUATED)) is not None:
        raise lack
    ReducedPlant(plant)  # raises: idle freedoms gain momentum, so these are not all coordinates of the motion
    top = None if limits is None else np.broadcast_to(np.asarray(limits, dtype=np.float64), (n,))
    one = _Tracing(plant, law, mechanism, gains, rate is not None, 0)
    own = law.memory(n)
    events: tuple[Event, ...] = ()
    if rate is None:
        effort, rates = one.controlled(one.state[source.positions + n :], top)
    else:
        held, law_rate = one.controlled(one.memory[n:], top)
        moved = [x + (1.0 / rate) * dx for x, dx in zip(one.memory[n:], law_rate, strict=True)]
        program = one.program("sample", {"held": held, "memory": moved}, noise=True)
        events = (Event(program, tuple(range(n + own))),)
        effort, rates = list[Number](one.memory[:n]), []
    a, factor = accelerations(one.traced, one.v, effort)
    errors = [x - y for x, y in zip(one.desired.q, one.traced.actuated, strict=True)]
    slopes = [*one.traced.position_rate(one.v), *a, *rates]
    rate_program = one.program("rate", {"rate": slopes, "watched": [*effort, *errors], "strain": [factor.strain]})
    settle = one.settle()
    sizes = Sizes(
        len(one.state),
        len(one.desired.symbols),
        len(one.given),
        2 * n,
        source.positions if settle else 0,
        len(one.memory),
        0,
        len(one.noise),
    )
    parts = LoopParts(rate_program, settle, STAGES[method], sizes, events)
    return TracedLoop(plant, law, gains, top, rate, method, own, one.desired, parts)


def measured_state(model: Mechanism, plant: Compiled, state: TracedState, graph: Graph) -> TracedState | None:
    """The plant's state as a law's model sees it, or None where that needs more than the actuated coordinates."""
    own = model.model if isinstance(model, CompiledMechanism) else model
    if own is plant.model:
        return state
    if isinstance(own, ClosedFormModel):
        return PaperSource(own).state(graph, [x for x in state.actuated if isinstance(x, Expression)], [])
    return None
