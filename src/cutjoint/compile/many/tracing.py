"""What all programs of one closed loop are traced from, and the loop under continuous control."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from cutjoint.arrays import Array
from cutjoint.compile.compiler import Compiled
from cutjoint.compile.expressions.functions import absolute, maximum
from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.expressions.program import Program
from cutjoint.compile.expressions.straight_line import assemble
from cutjoint.compile.machine.backends import backend
from cutjoint.compile.machine.schedule import scheduled
from cutjoint.compile.mechanism import CompiledMechanism
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.compile.sources.interface import TracedState
from cutjoint.compile.sources.law import TracedAnswer, TracedDesired, clipped, trace_law
from cutjoint.compile.sources.paper import PaperSource
from cutjoint.control import Law
from cutjoint.mechanism import Mechanism
from cutjoint.papers.reduced_model import ClosedFormModel


class Tracing:
    """Symbols of one closed loop.

    Attributes:
        q, v: position variables and actuated velocities.
        gains, parameters, hardware: what each run has of its own.
        traced: the plant's state.
        desired: the reference.
    """

    def __init__(
        self,
        plant: Compiled,
        law: Law,
        mechanism: Mechanism,
        gains: tuple[str, ...],
        varying: tuple[str, ...] = (),
    ) -> None:
        self.plant, self.law = plant, law
        n, graph = plant.n, Graph()
        self.graph = graph
        self.q, self.v = graph.symbols(plant.source.positions), graph.symbols(n)
        self.gains = {name: graph.symbols(n) for name in gains}
        self.parameters = graph.symbols(len(plant.options.parameters))
        self.hardware = {name: graph.symbols(n) for name in varying}
        self.traced = plant.source.state(graph, self.q, self.parameters)
        self.desired = TracedDesired(graph, n, mechanism)

    @property
    def given(self) -> list[Expression]:
        """The arguments that are each run's own."""
        own = (*self.gains.values(), self.parameters, *self.hardware.values())
        return [x for xs in own for x in xs]

    def answer(
        self, q: Sequence[Number], v: Sequence[Number], memory: Sequence[Expression], limits: Array | None
    ) -> TracedAnswer:
        """What the law answers to measured coordinates and velocities."""

        def seen_by(model: Mechanism) -> TracedState | None:
            return measured_state(model, self.plant, self.traced, self.graph, q)

        return trace_law(self.law, self.desired, q, v, memory, self.gains, clipped(limits), seen_by)

    def program(
        self,
        name: str,
        results: Mapping[str, Sequence[Number]],
        behind: Sequence[Expression],
        memory: Sequence[Expression] = (),
        noise: Sequence[Expression] = (),
    ) -> Program:
        """The program of some results; `behind` is the state behind positions and velocities."""
        arguments = {
            "state": [*self.q, *self.v, *behind],
            "row": self.desired.symbols,
            "given": self.given,
            "memory": memory,
            "noise": noise,
        }
        fused = backend(self.plant.options.backend).fused()
        return scheduled(assemble(self.graph, name, arguments, results, fused=fused))

    def settle(self, behind: Sequence[Expression]) -> Program | None:
        """The Newton step onto the loops."""
        source = self.plant.source
        settled, residuals = self.traced.settled(None)
        if not isinstance(source, ChainSource) or not residuals:
            return None
        gaps: dict[bool, Number] = {True: 0.0, False: 0.0}
        for residual, is_length in zip(residuals, source.closure.is_length.tolist(), strict=True):
            gaps[is_length] = maximum(absolute(residual), gaps[is_length])
        open_by = maximum(gaps[True] * (1.0 / source.chain.length), gaps[False])
        results = {"state": settled, "residual": [open_by], "strain": [self.traced.strain]}
        return self.program("settle", results, behind)


class Actuation(NamedTuple):
    """What moves the plant.

    Attributes:
        effort: at the joints, length n.
        behind, rates: the state behind positions and velocities, and its rate.
    """

    effort: list[Number]
    behind: list[Expression]
    rates: list[Number]


def continuous(one: Tracing, limits: Array | None) -> Actuation:
    """A law that acts at every instant; its memory stands behind the velocities."""
    memory = one.graph.symbols(one.law.memory(one.plant.n))
    answer = one.answer(one.traced.actuated, one.v, memory, limits)
    return Actuation(answer.given, memory, answer.memory_rate)


def measured_state(
    model: Mechanism, plant: Compiled, state: TracedState, graph: Graph, q: Sequence[Number]
) -> TracedState | None:
    """The plant's `state` as a law's model sees it that is shown the actuated coordinates `q`, or None where that needs
    more than these.  What varies in the plant, the model does not know: it keeps its own parameters."""
    own = model.plain if isinstance(model, CompiledMechanism) else model
    exact = all(graph.reference(x) == graph.reference(y) for x, y in zip(q, state.actuated, strict=True))
    if isinstance(own, ClosedFormModel) and not (own is plant.model and exact and not plant.options.parameters):
        return PaperSource(own).state(graph, [x for x in q if isinstance(x, Expression)], [])
    moved = isinstance(plant.source, ChainSource) and bool(plant.source.placing)
    if own is not plant.model or not exact or moved:
        return None
    if not plant.options.parameters:
        return state
    values = [Expression(graph, graph.constant(value)) for value in plant.nominal.values()]
    return plant.source.state(graph, state.q, values)
