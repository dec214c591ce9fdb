"""One closed loop, plant and law and integrator, as programs: what many runs of it compute at every step."""

from __future__ import annotations

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
from cutjoint.compile.machine.kernel import Sizes
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


@dataclass(frozen=True)
class TimeGrid:
    """Steps of `step` [s] from time 0, and samples every `stride` of them and at the end."""

    step: float
    steps: int
    stride: int

    @property
    def chosen(self) -> list[int]:
        """The steps that are samples."""
        return [*range(0, self.steps, self.stride), self.steps]


@dataclass(frozen=True, eq=False)
class TracedLoop:
    """A closed loop as programs.

    Attributes:
        plant, law, limits: what it is made of.
        gains: names of the law's gains that are arguments.
        memory: states of the law.
        desired: what is read of the reference.
        rate: program of the rates of the state and of what is watched (efforts and errors).
        settle: program of the Newton step onto the loops, where the plant has any.
        sizes: of what the loop reads and writes.
    """

    plant: Compiled
    law: Law
    gains: tuple[str, ...]
    limits: Array | None
    memory: int
    desired: TracedDesired
    rate: Program
    settle: Program | None
    sizes: Sizes


def traced_loop(
    plant: Compiled, law: Law, mechanism: Mechanism, gains: tuple[str, ...], limits: npt.ArrayLike | None
) -> TracedLoop:
    """Trace a closed loop; see `ClosedLoop` for arguments and errors."""
    source, n = plant.source, plant.n
    if (lack := source.lacks(Need.ACTUATED)) is not None:
        raise lack
    ReducedPlant(plant)  # raises: idle freedoms gain momentum, so these are not all coordinates of the motion
    top = None if limits is None else np.broadcast_to(np.asarray(limits, dtype=np.float64), (n,))
    memory, positions, graph = law.memory(n), source.positions, Graph()
    state = graph.symbols(positions + n + memory)
    given = {name: graph.symbols(n) for name in gains}
    parameters = graph.symbols(len(plant.options.parameters))
    v = state[positions : positions + n]
    traced = source.state(graph, state[:positions], parameters)
    desired = TracedDesired(graph, n, mechanism)

    def seen_by(model: Mechanism) -> TracedState | None:
        return measured_state(model, plant, traced, graph)

    effort, memory_rate = trace_law(law, desired, traced, v, state[positions + n :], given, top, seen_by)
    a, factor = accelerations(traced, v, effort)
    errors = [x - y for x, y in zip(desired.q, traced.actuated, strict=True)]
    own = [*(x for xs in given.values() for x in xs), *parameters]
    arguments = {"state": state, "row": desired.symbols, "given": own}

    fused = backend(plant.options.backend).fused()

    def program(name: str, results: dict[str, list[Number]]) -> Program:
        return scheduled(assemble(graph, name, arguments, results, fused=fused))

    rates = [*traced.position_rate(v), *a, *memory_rate]
    watched = [*effort, *errors]
    rate = program("rate", {"rate": rates, "watched": watched, "strain": [factor.strain]})
    settled, residuals = traced.settled(None)
    settle = None
    if isinstance(source, ChainSource) and residuals:
        gaps: dict[bool, Number] = {True: 0.0, False: 0.0}
        for residual, is_length in zip(residuals, source.closure.is_length.tolist(), strict=True):
            gaps[is_length] = maximum(absolute(residual), gaps[is_length])
        open_by = maximum(gaps[True] * (1.0 / source.chain.length), gaps[False])
        settle = program("settle", {"state": settled, "residual": [open_by], "strain": [traced.strain]})
    sizes = Sizes(len(state), len(desired.symbols), len(own), 2 * n, positions if settle else 0)
    return TracedLoop(plant, law, gains, top, memory, desired, rate, settle, sizes)


def measured_state(model: Mechanism, plant: Compiled, state: TracedState, graph: Graph) -> TracedState | None:
    """The plant's state as a law's model sees it, or None where that needs more than the actuated coordinates."""
    own = model.model if isinstance(model, CompiledMechanism) else model
    if own is plant.model:
        return state
    if isinstance(own, ClosedFormModel):
        return PaperSource(own).state(graph, [x for x in state.actuated if isinstance(x, Expression)], [])
    return None
