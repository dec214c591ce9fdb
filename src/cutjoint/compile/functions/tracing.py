"""How each compiled function is traced: results and strain as expressions of its arguments."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from cutjoint.compile.equations.reduction import MassFactor
from cutjoint.compile.expressions.derivative import tangent as along
from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.expressions.vectors import ZERO, Vector, add, cross, dot, scale
from cutjoint.compile.sources.chain_state import ChainState
from cutjoint.compile.sources.interface import Source, TracedState, size
from cutjoint.compile.sources.paper import PaperSource

Symbols: TypeAlias = list[Expression]
Results: TypeAlias = dict[str, list[Number]]
Traced: TypeAlias = tuple[Results, Number]

ARGUMENTS = {
    "q": "positions",
    "v": "n",
    "a": "n",
    "effort": "n",
    "target": "n",
    "p": "3",
    "goal": "12",
    "v_full": "nv",
    "effort_full": "nv",
    "wrench": "6",
    "parameters": "parameters",
}
"""Every argument that a compiled function may have, and its size: position variables; actuated velocity, acceleration,
effort and coordinates; tool position; place of the tool in the model, and its rotation; velocity of and force on all
joints; force and moment on the tool; what else is an argument."""


class Call:
    """One function while it is traced: its arguments as symbols, by name.

    Args:
        source: the model.
        names: of the arguments: positions first, parameters last.
    """

    state: TracedState
    """The model's state at the position variables, where those are an argument."""

    def __init__(self, source: Source, names: Sequence[str]) -> None:
        self.source, self.graph = source, Graph()
        first, *others, last = names
        made = {name: self.graph.symbols(size(source, ARGUMENTS[name])) for name in (first, last)}
        if first == "q":
            self.state = source.state(self.graph, made[first], made[last])
        made.update({name: self.graph.symbols(size(source, ARGUMENTS[name])) for name in others})
        self.arguments = {name: made[name] for name in names}

    def __getitem__(self, name: str) -> Symbols:
        return self.arguments[name]

    @property
    def joints(self) -> ChainState:
        """The state of a chain, of which all joints can be asked."""
        assert isinstance(self.state, ChainState)
        return self.state


def accelerations(state: TracedState, v: Symbols, effort: Sequence[Number]) -> tuple[list[Number], MassFactor]:
    """Forward dynamics of a traced state: acceleration, and the factored mass matrix."""
    factor = MassFactor(state.mass(), state.strain)
    return factor.solve([x - y for x, y in zip(effort, state.bias(v), strict=True)]), factor


def _flat(matrix: Sequence[Sequence[Number]]) -> list[Number]:
    return [x for row in matrix for x in row]


def _transposed(columns: Sequence[Sequence[Number]]) -> list[Number]:
    """Columns as a flat matrix, row by row."""
    return [x for row in zip(*columns, strict=True) for x in row]


def forward(call: Call) -> Traced:
    """M a = effort - bias, solved."""
    a, factor = accelerations(call.state, call["v"], call["effort"])
    return {"a": a}, factor.strain


def motion(call: Call) -> Traced:
    """Rates of positions, velocities and works."""
    v, effort, state = call["v"], call["effort"], call.state
    a, factor = accelerations(state, v, effort)
    powers: Results = {"power": [dot(effort, v)], "lost": [dot(state.friction(v), v)]}
    return {"q_rate": state.position_rate(v), "a": a, **powers, "v_full": state.full_velocity(v)}, factor.strain


def full_motion(call: Call) -> Traced:
    """Rates of positions, velocities of all joints, and works."""
    v, effort, joints = call["v_full"], call["effort_full"], call.joints
    a, strain = joints.full_forward(v, effort)
    powers: Results = {"power": [dot(effort, v)], "lost": [joints.full_dissipation(v)]}
    return {"q_rate": joints.full_rate(v), "a_full": a, **powers, "residual": joints.whole.residuals}, strain


def inverse(call: Call) -> Traced:
    """M a + bias."""
    return {"effort": call.state.inverse(call["v"], call["a"])}, call.state.strain


def _of_wrench(call: Call) -> tuple[list[Number], list[list[Number]]]:
    """J' w of a wrench at the tool, and J' as rows of (6)."""
    jacobian = call.state.tool([0.0] * call.source.n).jacobian
    transposed = [list(row) for row in zip(*jacobian, strict=True)]
    return [dot(row, call["wrench"]) for row in transposed], transposed


def forward_loaded(call: Call) -> Traced:
    """M a = effort + J' wrench - bias, solved; the derivative by the wrench is that of a linear system."""
    push, transposed = _of_wrench(call)
    a, factor = accelerations(call.state, call["v"], [x + y for x, y in zip(call["effort"], push, strict=True)])
    by_wrench = [factor.solve(list(column)) for column in zip(*transposed, strict=True)]
    return {"a": a, "by_wrench": _transposed(by_wrench)}, factor.strain


def inverse_loaded(call: Call) -> Traced:
    """M a + bias - J' wrench."""
    push, transposed = _of_wrench(call)
    effort = [x - y for x, y in zip(call.state.inverse(call["v"], call["a"]), push, strict=True)]
    return {"effort": effort, "by_wrench": [-x for row in transposed for x in row]}, call.state.strain


def terms(call: Call) -> Traced:
    """M, Coriolis vector, gravity, springs, friction."""
    state = call.state
    coriolis = state.coriolis(call["v"])
    results: Results = {"mass": _flat(state.mass()), "coriolis": coriolis, "gravity": state.gravity()}
    return {**results, "springs": state.springs(), "friction": state.friction(call["v"])}, state.strain


def tool(call: Call) -> Traced:
    """Kinematics of the tool."""
    position, rotation, jacobian, frame_drift, twist = call.state.tool(call["v"])
    results: Results = {"position": position, "rotation": _flat(rotation), "frame_jacobian": _flat(jacobian)}
    return {**results, "frame_drift": frame_drift, "twist": twist}, call.state.strain


def energy(call: Call) -> Traced:
    """v' M v / 2, and the potential."""
    v = call["v"]
    kinetic: Number = 0.0
    for x, row in zip(v, call.state.mass(), strict=True):
        for y, entry in zip(v, row, strict=True):
            kinetic = kinetic + 0.5 * x * entry * y
    return {"kinetic": [kinetic], "potential": [call.state.potential()]}, call.state.strain


def step(call: Call) -> Traced:
    """One Newton step."""
    q, residual = call.state.settled(call["target"])
    return {"q_next": q, "residual": residual}, call.state.strain


def _directions(call: Call, still: Sequence[Number]) -> list[dict[int, Number]]:
    """Seeds that move along each independent coordinate, loops closed, with the values `still` held."""
    state, n = call.state, call.source.n
    found = []
    for k in range(n):
        rate = state.position_rate([1.0 if i == k else 0.0 for i in range(n)])
        seed: dict[int, Number] = {abs(call.graph.reference(value)): 0.0 for value in still}
        seed.update({abs(x.ref): value for x, value in zip(state.q, rate, strict=True)})
        found.append(seed)
    return found


def inverse_derivatives(call: Call) -> Traced:
    """The expressions of the inverse dynamics, differentiated."""
    graph, v = call.graph, call["v"]
    effort = call.state.inverse(v, call["a"])
    by_q = [along(graph, effort, seed) for seed in _directions(call, [])]
    by_v = [along(graph, effort, {abs(x.ref): 1.0}) for x in v]
    results: Results = {"effort": effort, "by_q": _transposed(by_q), "by_v": _transposed(by_v)}
    return {**results, "by_a": _flat(call.state.mass())}, call.state.strain


def forward_derivatives(call: Call) -> Traced:
    """With a held, M da = -d(inverse dynamics): the derivative of a costs no derivative of the solution."""
    n, graph, v = call.source.n, call.graph, call["v"]
    a, factor = accelerations(call.state, v, call["effort"])
    effort = call.state.inverse(v, a)
    held: dict[int, Number] = {abs(graph.reference(x)): 0.0 for x in a}
    by_q = [factor.solve([-x for x in along(graph, effort, seed)]) for seed in _directions(call, a)]
    by_v = [factor.solve([-x for x in along(graph, effort, {**held, abs(x.ref): 1.0})]) for x in v]
    unit = [[1.0 if i == k else 0.0 for i in range(n)] for k in range(n)]
    by_effort = [factor.solve(list(column)) for column in unit]
    results: Results = {"a": a, "by_q": _transposed(by_q), "by_v": _transposed(by_v)}
    return {**results, "by_effort": _transposed(by_effort)}, factor.strain


def residual(call: Call) -> Traced:
    """What the loops are open by."""
    return {"residual": call.joints.whole.residuals}, 1.0


def tool_by_parameters(call: Call) -> Traced:
    """The tool's place and axes, differentiated; what turns the axes is half the sum of e x de."""
    state = call.joints
    traced = state.tool([0.0] * call.source.n)
    axes = [list(axis) for axis in zip(*traced.rotation, strict=True)]
    columns = []
    for seed in state.directions_of_parameters():
        changed = along(call.graph, [*traced.position, *(x for axis in axes for x in axis)], seed)
        turned: Vector = ZERO
        for k, (x, y, z) in enumerate(axes):
            dx, dy, dz = changed[3 + 3 * k : 6 + 3 * k]
            turned = add(turned, scale(0.5, cross((x, y, z), (dx, dy, dz))))
        columns.append([*changed[:3], *turned])
    return {"by_parameters": _transposed(columns)}, call.state.strain


def inverse_by_parameters(call: Call) -> Traced:
    """The expressions of the inverse dynamics, differentiated."""
    effort = call.state.inverse(call["v"], call["a"])
    columns = [along(call.graph, effort, seed) for seed in call.joints.directions_of_parameters()]
    return {"by_parameters": _transposed(columns)}, call.state.strain


def tangent(call: Call) -> Traced:
    """T of all joints."""
    return {"tangent": _flat(call.joints.full_tangent())}, call.state.strain


def drift(call: Call) -> Traced:
    """d of all joints."""
    return {"drift": call.joints.full_drift(call["v"])}, call.state.strain


def full_forward(call: Call) -> Traced:
    """Forward dynamics of all joints."""
    a, strain = call.joints.full_forward(call["v_full"], call["effort_full"])
    return {"a_full": a}, strain


def reach_step(call: Call) -> Traced:
    """One Newton step on loops and task."""
    q, residual, led, size, gap, determinant, strain = call.joints.towards(call["goal"])
    results: Results = {"q_next": q, "place": list(led.position), "rotation": _flat(led.rotation), "residual": residual}
    return {**results, "size": [size], "gap": [gap], "determinant": [determinant]}, strain


def reach(call: Call) -> Traced:
    """Inverse kinematics in closed form; the strain is that of the posture, not a number where there is none."""
    assert isinstance(call.source, PaperSource)
    found = call.source.inverse_kinematics(call["p"], call["parameters"])
    return {"q_reached": found}, call.source.strain_at(call.graph, found, call["parameters"])
