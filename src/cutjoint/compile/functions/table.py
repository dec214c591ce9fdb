"""The functions that are compiled from a model: what goes in, what comes out.

Every one of them takes the position variables `q` first and the inertial parameters last, and gives its `strain` last.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

from cutjoint.compile.equations.reduction import MassFactor
from cutjoint.compile.expressions.derivative import tangent
from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.expressions.program import Program
from cutjoint.compile.expressions.straight_line import assemble
from cutjoint.compile.machine.schedule import scheduled
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.compile.sources.chain_state import ChainState
from cutjoint.compile.sources.interface import Source, TracedState
from cutjoint.compile.sources.paper import PaperSource
from cutjoint.errors import CompileError, InputError

Symbols: TypeAlias = list[Expression]
Results: TypeAlias = dict[str, list[Number]]


class _Call:
    """One function while it is traced: its arguments, made on demand in order."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.graph = Graph()
        self.arguments: dict[str, Symbols] = {"q": self.graph.symbols(source.positions)}
        self.parameters = self.graph.symbols(len(source.parameters))
        self.state = source.state(self.graph, self.arguments["q"], self.parameters)

    def argument(self, name: str, size: int) -> Symbols:
        """A further argument."""
        self.arguments[name] = self.graph.symbols(size)
        return self.arguments[name]

    def program(self, what: str, results: Mapping[str, Sequence[Number]], strain: Number, fused: bool) -> Program:
        """The finished function."""
        arguments = {**self.arguments, "parameters": self.parameters}
        line = assemble(self.graph, what, arguments, {**results, "strain": [strain]}, fused=fused)
        return scheduled(line)


def accelerations(state: TracedState, v: Symbols, effort: Sequence[Number]) -> tuple[list[Number], MassFactor]:
    """Forward dynamics of a traced state: acceleration, and the factored mass matrix."""
    factor = MassFactor(state.mass(), state.strain)
    return factor.solve([x - y for x, y in zip(effort, state.bias(v), strict=True)]), factor


def _flat(matrix: Sequence[Sequence[Number]]) -> list[Number]:
    return [x for row in matrix for x in row]


def _transposed(columns: Sequence[Sequence[Number]]) -> list[Number]:
    """Columns as a flat matrix, row by row."""
    return [x for row in zip(*columns, strict=True) for x in row]


def _forward(call: _Call) -> tuple[Results, Number]:
    n = call.source.n
    a, factor = accelerations(call.state, call.argument("v", n), call.argument("effort", n))
    return {"a": a}, factor.strain


def _inverse(call: _Call) -> tuple[Results, Number]:
    n = call.source.n
    effort = call.state.inverse(call.argument("v", n), call.argument("a", n))
    return {"effort": effort}, call.state.strain


def _terms(call: _Call) -> tuple[Results, Number]:
    state = call.state
    coriolis = state.coriolis(call.argument("v", call.source.n))
    return {"mass": _flat(state.mass()), "coriolis": coriolis, "gravity": state.gravity()}, state.strain


def _tool(call: _Call) -> tuple[Results, Number]:
    position, jacobian, drift = call.state.tool(call.argument("v", call.source.n))
    return {"position": position, "jacobian": _flat(jacobian), "drift": drift}, call.state.strain


def _energy(call: _Call) -> tuple[Results, Number]:
    v = call.argument("v", call.source.n)
    kinetic: Number = 0.0
    for x, row in zip(v, call.state.mass(), strict=True):
        for y, entry in zip(v, row, strict=True):
            kinetic = kinetic + 0.5 * x * entry * y
    return {"kinetic": [kinetic], "potential": [call.state.potential()]}, call.state.strain


def _step(call: _Call) -> tuple[Results, Number]:
    q, residual = call.state.settled(call.argument("target", call.source.n))
    return {"q_next": q, "residual": residual}, call.state.strain


def _directions(call: _Call, still: Sequence[Number]) -> list[dict[int, Number]]:
    """Seeds that move along each independent coordinate, loops closed, with the values `still` held."""
    state, n = call.state, call.source.n
    found = []
    for k in range(n):
        rate = state.position_rate([1.0 if i == k else 0.0 for i in range(n)])
        seed: dict[int, Number] = {abs(call.graph.reference(value)): 0.0 for value in still}
        seed.update({abs(x.ref): value for x, value in zip(state.q, rate, strict=True)})
        found.append(seed)
    return found


def _inverse_derivatives(call: _Call) -> tuple[Results, Number]:
    n, graph = call.source.n, call.graph
    v, a = call.argument("v", n), call.argument("a", n)
    effort = call.state.inverse(v, a)
    by_q = [tangent(graph, effort, seed) for seed in _directions(call, [])]
    by_v = [tangent(graph, effort, {abs(x.ref): 1.0}) for x in v]
    results: Results = {"effort": effort, "by_q": _transposed(by_q), "by_v": _transposed(by_v)}
    return {**results, "by_a": _flat(call.state.mass())}, call.state.strain


def _forward_derivatives(call: _Call) -> tuple[Results, Number]:
    # With a held, M da = -d(inverse dynamics): the derivative of a costs no derivative of the solution.
    n, graph = call.source.n, call.graph
    v, given = call.argument("v", n), call.argument("effort", n)
    a, factor = accelerations(call.state, v, given)
    effort = call.state.inverse(v, a)
    held: dict[int, Number] = {abs(graph.reference(x)): 0.0 for x in a}
    by_q = [factor.solve([-x for x in tangent(graph, effort, seed)]) for seed in _directions(call, a)]
    by_v = [factor.solve([-x for x in tangent(graph, effort, {**held, abs(x.ref): 1.0})]) for x in v]
    unit = [[1.0 if i == k else 0.0 for i in range(n)] for k in range(n)]
    by_effort = [factor.solve(list(column)) for column in unit]
    results: Results = {"a": a, "by_q": _transposed(by_q), "by_v": _transposed(by_v)}
    return {**results, "by_effort": _transposed(by_effort)}, factor.strain


def _chain(call: _Call) -> ChainState:
    if not isinstance(call.state, ChainState):
        raise InputError(f"{call.source.name} is a reduced model; it has no joints beside the actuated ones")
    return call.state


def _tangent(call: _Call) -> tuple[Results, Number]:
    state = _chain(call)
    return {"tangent": _flat(state.full_tangent())}, state.strain


def _drift(call: _Call) -> tuple[Results, Number]:
    state = _chain(call)
    return {"drift": state.full_drift(call.argument("v", call.source.n))}, state.strain


def _full_forward(call: _Call) -> tuple[Results, Number]:
    state = _chain(call)
    if state.source.weightless:
        raise CompileError(
            f"{state.source.name} has idle freedoms that move no mass, such as the spin of a rod without inertia about "
            "its axis; its forward dynamics in full coordinates cannot be compiled"
        )
    nv = state.source.nv
    a, strain = state.full_forward(call.argument("v_full", nv), call.argument("effort_full", nv))
    return {"a_full": a}, strain


def _reach(call: _Call) -> tuple[Results, Number]:
    source = call.source
    if not isinstance(source, PaperSource) or source.n != 3:
        raise InputError(f"{source.name} has no inverse kinematics in closed form")
    q = source.inverse_kinematics(call.arguments["q"], call.parameters)
    return {"q_reached": q}, 1.0


BUILDERS: dict[str, Callable[[_Call], tuple[Results, Number]]] = {
    "forward": _forward,
    "inverse": _inverse,
    "terms": _terms,
    "tool": _tool,
    "energy": _energy,
    "step": _step,
    "inverse_derivatives": _inverse_derivatives,
    "forward_derivatives": _forward_derivatives,
    "tangent": _tangent,
    "drift": _drift,
    "full_forward": _full_forward,
    "reach": _reach,
}
"""Everything that can be compiled, by name."""

CHAIN_ONLY = ("tangent", "drift", "full_forward")
"""Those that need the joints of a chain."""
PAPER_ONLY = ("reach",)
"""Those that need equations in closed form; its argument `q` is the tool position."""


def trace(source: Source, what: str, *, fused: bool) -> Program:
    """Trace one function of a model.

    Raises:
        InputError: the model does not have it.
        ActuationError: it is in actuated coordinates, which do not determine the motion.
        CompileError: no order of elimination is good, or a motion moves no mass.
    """
    if isinstance(source, ChainSource) and what not in ("full_forward", *PAPER_ONLY):
        source.need_actuated()
    call = _Call(source)
    results, strain = BUILDERS[what](call)
    return call.program(what, results, strain, fused)
