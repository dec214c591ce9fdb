"""The compiled functions, a row each: what goes in, what comes out, how it is traced, and what it must be.

A new function is a row here.  Everything else reads the row: the library that makes functions, the check before they
are used, `cutjoint compile`, and the table in docs/compile.md.

Arguments are those of `ARGUMENTS`: position variables (or the tool's position) first, inertial parameters last.  After
the parts of its result every function gives its `strain`.
"""

# long: a row a function

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.expressions.program import Program
from cutjoint.compile.expressions.straight_line import assemble
from cutjoint.compile.functions import tracing
from cutjoint.compile.functions.sample import RobotSample, acceleration_by, effort_for, slopes
from cutjoint.compile.functions.tracing import ARGUMENTS, Call, Traced
from cutjoint.compile.machine.schedule import scheduled
from cutjoint.compile.sources.interface import Need, Source, size
from cutjoint.errors import UnknownNameError

AGREEMENT = 1e-9
"""Largest relative difference between a compiled function and its model; 1e-13 is typical."""
SLOPE = 1e-5
"""Same for derivatives against central differences."""


@dataclass(frozen=True)
class ResultPart:
    """One part of the result of a compiled function.

    Attributes:
        name: of it.
        shape: sizes separated by commas: numbers, or `n`, `nv`, `positions`, `rows` (of the loops) or
            `parameters` of the model.
        units: an axis each, in which it is compared: `q`, `v` of an actuated coordinate and velocity, `1/q`, `1/v` of
            what is conjugate to them, `u` of a joint's rate, `x` of a position variable, `m` length, `t` of the tool's
            twist, `J` energy, `r` of the loops' equations, `1/p` of what is per parameter, `1` none.
        size: of the terms it is the sum of, in those units; it is compared against that or its own, what is larger.
        tolerance: relative.
        periodic: whether whole turns of angles make no difference.
    """

    name: str
    shape: str
    units: str = ""
    size: Callable[[RobotSample], float] = lambda _: 0.0
    tolerance: float = AGREEMENT
    periodic: bool = False


@dataclass(frozen=True)
class Function:
    """A row of the table.

    Attributes:
        name: of the function.
        about: what it gives, in one line.
        arguments: names, in order.
        parts: of its result, in order; the strain comes after them.
        trace: makes the expressions.
        known: right values of parts, by another way than the compiled one; what is not among them is not compared.
        needs: what a model must have.
    """

    name: str
    about: str
    arguments: tuple[str, ...]
    parts: tuple[ResultPart, ...]
    trace: Callable[[Call], Traced]
    known: Callable[[RobotSample], Mapping[str, Array]]
    needs: tuple[Need, ...] = (Need.ACTUATED,)

    def lengths(self, source: Source) -> tuple[tuple[tuple[str, int], ...], tuple[tuple[str, int], ...]]:
        """Name and length of every argument, and of every part of the result with the strain, as in a `Program`."""
        given = tuple((name, size(source, ARGUMENTS[name])) for name in self.arguments)
        sizes = [[size(source, symbol) for symbol in part.shape.split(",")] for part in self.parts]
        parts = tuple((part.name, int(np.prod(one))) for part, one in zip(self.parts, sizes, strict=True))
        return given, (*parts, ("strain", 1))

    def program(self, source: Source, *, fused: bool) -> Program:
        """The function of a model, traced.

        Raises:
            InputError: the model does not have it.
            ActuationError: it is in actuated coordinates, which do not determine the motion.
            CompileError: no order of elimination is good, or a motion moves no mass.
        """
        for need in self.needs:
            if (lack := source.lacks(need)) is not None:
                raise lack
        call = Call(source, self.arguments)
        results, strain = self.trace(call)
        line = assemble(call.graph, self.name, call.arguments, {**results, "strain": [strain]}, fused=fused)
        return scheduled(line)


_EFFORT = ResultPart("effort", "n", "1/q", lambda s: s.energy)
_A = ResultPart("a", "n", "q", lambda s: s.acceleration)
_RIGID = ("q", "v", "parameters")
_DYNAMICS = (Need.ACTUATED, Need.SMOOTH)

FUNCTIONS: dict[str, Function] = {
    row.name: row
    for row in (
        Function(
            "forward",
            "acceleration that an effort gives",
            ("q", "v", "effort", "parameters"),
            (_A,),
            tracing.forward,
            lambda s: {"a": s.a},
            _DYNAMICS,
        ),
        Function(
            "motion",
            "rates of position variables and velocities under an effort, its power and that of friction, which is what "
            "an integrator needs, and velocities of all joints",
            ("q", "v", "effort", "parameters"),
            (
                ResultPart("q_rate", "positions", "x", lambda s: s.speed, SLOPE),
                _A,
                ResultPart("power", "1", "J", lambda s: float(np.abs(s.effort * s.v).sum())),
                ResultPart("lost", "1", "J", lambda s: s.rubbed * s.speed),
                ResultPart("v_full", "nv", "u", lambda s: s.speed),
            ),
            tracing.motion,
            lambda s: {
                "q_rate": s.q_rate(s.tangent @ s.v),
                "a": s.a,
                "power": np.array([s.effort @ s.v]),
                "lost": np.array([s.terms.friction @ s.v]),
                "v_full": s.tangent @ s.v,
            },
            _DYNAMICS,
        ),
        Function(
            "inverse",
            "effort that gives an acceleration",
            ("q", "v", "a", "parameters"),
            (_EFFORT,),
            tracing.inverse,
            lambda s: {"effort": s.effort},
            _DYNAMICS,
        ),
        Function(
            "forward_loaded",
            "acceleration that an effort and a wrench at the tool give (world axes), and its derivative by the wrench",
            ("q", "v", "effort", "wrench", "parameters"),
            (_A, ResultPart("by_wrench", "n,6", "q,t")),
            tracing.forward_loaded,
            lambda s: {
                "a": acceleration_by(s.terms, s.effort + s.push),
                "by_wrench": np.linalg.inv(s.terms.mass) @ s.jacobian.T,
            },
            (*_DYNAMICS, Need.TOOL),
        ),
        Function(
            "inverse_loaded",
            "effort that gives an acceleration against a wrench at the tool (world axes), and its derivative by it",
            ("q", "v", "a", "wrench", "parameters"),
            (_EFFORT, ResultPart("by_wrench", "n,6", "1/q,t")),
            tracing.inverse_loaded,
            lambda s: {"effort": s.effort - s.push, "by_wrench": -s.jacobian.T},
            (*_DYNAMICS, Need.TOOL),
        ),
        Function(
            "terms",
            "mass matrix, Coriolis vector, gravity, springs, friction",
            _RIGID,
            (
                ResultPart("mass", "n,n", "1/q,1/q"),
                ResultPart("coriolis", "n", "1/q", lambda s: s.moving),
                ResultPart("gravity", "n", "1/q", lambda s: s.weight),
                ResultPart("springs", "n", "1/q", lambda s: s.held),
                ResultPart("friction", "n", "1/q", lambda s: s.rubbed),
            ),
            tracing.terms,
            lambda s: vars(s.terms),
            _DYNAMICS,
        ),
        Function(
            "tool",
            "pose of the tool, its frame Jacobian, J_dot v, and twist",
            _RIGID,
            (
                ResultPart("position", "3", "m", lambda s: s.far),
                ResultPart("rotation", "3,3", "1,1", lambda s: 1.0),
                ResultPart("frame_jacobian", "6,n", "t,1/q", lambda s: 1.0),
                ResultPart("frame_drift", "6", "t", lambda s: s.speed**2),
                ResultPart("twist", "6", "t", lambda s: s.speed),
            ),
            tracing.tool,
            lambda s: vars(s.tool),
            (Need.ACTUATED, Need.TOOL),
        ),
        Function(
            "energy",
            "kinetic and potential energy",
            _RIGID,
            (ResultPart("kinetic", "1", "J"), ResultPart("potential", "1", "J", lambda s: s.far * s.weight + s.held)),
            tracing.energy,
            lambda s: {
                "kinetic": np.array([0.5 * s.v @ s.terms.mass @ s.v]),
                "potential": np.array([s.model.potential_energy(s.at)]),
            },
        ),
        Function(
            "step",
            "position variables after one Newton step towards closed loops, and what they are open by",
            ("q", "target", "parameters"),
            (ResultPart("q_next", "positions", "x", lambda s: 1.0), ResultPart("residual", "rows")),
            tracing.step,
            lambda s: {"q_next": s.q},
        ),
        Function(
            "residual",
            "what the loops are open by",
            ("q", "parameters"),
            (ResultPart("residual", "rows", "r", lambda s: 1.0),),
            tracing.residual,
            lambda s: {"residual": np.zeros(len(s.axes["r"]))},
            (Need.JOINTS, Need.ACTUATED),
        ),
        Function(
            "reach_step",
            "position variables after one Newton step to closed loops and the tool's task at a pose; before it the "
            "tool in the model and what the loops are open by; sizes of the step and of what was left; determinant",
            ("q", "goal", "parameters"),
            (
                ResultPart("q_next", "positions", "x", lambda s: 1.0),
                ResultPart("place", "3", "m", lambda s: 1.0),
                ResultPart("rotation", "3,3", "1,1", lambda s: 1.0),
                ResultPart("residual", "2"),
                ResultPart("size", "1", "1", lambda s: 1.0),
                ResultPart("gap", "1", "1", lambda s: 1.0),
                ResultPart("determinant", "1"),
            ),
            tracing.reach_step,
            lambda s: s.towards,
            (Need.JOINTS, Need.ACTUATED, Need.TOOL, Need.TASK),
        ),
        Function(
            "inverse_derivatives",
            "effort and its derivatives in actuated coordinates",
            ("q", "v", "a", "parameters"),
            (
                _EFFORT,
                ResultPart("by_q", "n,n", "1/q,1/q", lambda s: s.energy, SLOPE),
                ResultPart("by_v", "n,n", "1/q,1/v", lambda s: s.energy, SLOPE),
                ResultPart("by_a", "n,n", "1/q,1/q", tolerance=SLOPE),
            ),
            tracing.inverse_derivatives,
            lambda s: {"effort": s.effort, **slopes(s, lambda now: effort_for(now, s.a)), "by_a": s.terms.mass},
            _DYNAMICS,
        ),
        Function(
            "forward_derivatives",
            "acceleration and its derivatives in actuated coordinates",
            ("q", "v", "effort", "parameters"),
            (
                _A,
                ResultPart("by_q", "n,n", "q,1/q", lambda s: s.acceleration, SLOPE),
                ResultPart("by_v", "n,n", "q,1/v", lambda s: s.acceleration, SLOPE),
                ResultPart("by_effort", "n,n", "q,q", tolerance=SLOPE),
            ),
            tracing.forward_derivatives,
            lambda s: {
                "a": s.a,
                **slopes(s, lambda now: acceleration_by(now, s.effort)),
                "by_effort": np.asarray(np.linalg.inv(s.terms.mass)),
            },
            _DYNAMICS,
        ),
        Function(
            "tool_by_parameters",
            "how the tool moves (place, then rotation vector) with every parameter, actuators held and loops closed",
            ("q", "parameters"),
            (ResultPart("by_parameters", "6,parameters", "t,1/p", lambda s: 1.0, SLOPE),),
            tracing.tool_by_parameters,
            lambda s: s.known_slopes("tool_by_parameters"),
            (Need.JOINTS, Need.ACTUATED, Need.TOOL, Need.PARAMETERS),
        ),
        Function(
            "inverse_by_parameters",
            "how the effort for an acceleration changes with every parameter, actuated coordinates held, loops closed",
            ("q", "v", "a", "parameters"),
            (ResultPart("by_parameters", "n,parameters", "1/q,1/p", lambda s: s.energy, SLOPE),),
            tracing.inverse_by_parameters,
            lambda s: s.known_slopes("inverse_by_parameters"),
            (Need.JOINTS, Need.ACTUATED, Need.PARAMETERS),
        ),
        Function(
            "tangent",
            "T with v_full = T v",
            ("q", "parameters"),
            (ResultPart("tangent", "nv,n", "u,1/q", lambda s: 1.0),),
            tracing.tangent,
            lambda s: {"tangent": s.tangent},
            (Need.JOINTS, Need.ACTUATED),
        ),
        Function(
            "drift",
            "d with a_full = T a + d",
            _RIGID,
            (ResultPart("drift", "nv", "u", lambda s: max(s.speed, s.spin) ** 2),),
            tracing.drift,
            lambda s: {"drift": s.drift},
            (Need.JOINTS, *_DYNAMICS),
        ),
        Function(
            "full_forward",
            "acceleration of all joints, for any actuation",
            ("q", "v_full", "effort_full", "parameters"),
            (ResultPart("a_full", "nv", "u", lambda s: s.units.rate**2),),
            tracing.full_forward,
            lambda s: {"a_full": s.a_full},
            (Need.JOINTS, Need.SMOOTH),
        ),
        Function(
            "full_motion",
            "rates of position variables and of the velocities of all joints under forces on them, their power and "
            "that of friction, and what the loops are open by",
            ("q", "v_full", "effort_full", "parameters"),
            (
                ResultPart("q_rate", "positions", "x", lambda s: s.units.rate, SLOPE),
                ResultPart("a_full", "nv", "u", lambda s: s.units.rate**2),
                ResultPart("power", "1", "J", lambda s: float(np.abs(s.effort_full * s.v_full).sum())),
                ResultPart("lost", "1", "J"),
                ResultPart("residual", "rows"),
            ),
            tracing.full_motion,
            lambda s: {
                "q_rate": s.q_rate(s.v_full),
                "a_full": s.a_full,
                "power": np.array([s.effort_full @ s.v_full]),
                "lost": s.lost_full,
            },
            (Need.JOINTS, Need.SMOOTH),
        ),
        Function(
            "reach",
            "actuated coordinates for a tool position, in closed form",
            ("p", "parameters"),
            (ResultPart("q_reached", "n", "q", lambda s: 1.0, periodic=True),),
            tracing.reach,
            lambda s: {"q_reached": s.target},
            (Need.CLOSED_FORM,),
        ),
    )
}
"""Everything that can be compiled, by name."""


def function(name: str) -> Function:
    """The row of that name.

    Raises:
        UnknownNameError: there is none.
    """
    if name not in FUNCTIONS:
        raise UnknownNameError("compiled function", name, list(FUNCTIONS))
    return FUNCTIONS[name]
