"""The published models as sources of expressions: their own equations, run on symbols.

No equation stands here twice, and no robot is named.  A paper's equations are written for floats, arrays and symbols
alike; a `ClosedFormModel` gives its state on any of them.  The branch (elbow signs, assembly mode) is a constant of the
traced function, so the angles inside vanish: the cosine of atan2(w, u) + acos(k) is algebra.
"""

from __future__ import annotations

import json
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import fields
from functools import cached_property, reduce
from operator import add, mul
from typing import Any, TypeAlias, cast

from cutjoint.compile.expressions import functions
from cutjoint.compile.expressions.functions import maximum
from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.expressions.vectors import IDENTITY, dot
from cutjoint.compile.sources.interface import PAYLOAD, Need, TracedTool
from cutjoint.errors import CutjointError, InputError, UnknownNameError
from cutjoint.mechanism.physics import JointPhysics
from cutjoint.papers import motors
from cutjoint.papers.reduced_model import ClosedFormModel, EquationState, PaperParameters
from cutjoint.papers.scalars import Functions

FUNCTIONS = cast(Functions, functions)
BOUNDS = cast(motors.Bounds, functions)

PaperModel: TypeAlias = ClosedFormModel[Any, Any]


class PaperSource:
    """A published model on one branch, to be traced.

    Args:
        model: the model.
        parameters: names that stay arguments: `payload` [kg] or any field of the model's parameters.
        branch: default that of home.

    Raises:
        UnknownNameError: no such parameter.
    """

    rows = 0

    def __init__(self, model: PaperModel, parameters: Sequence[str] = (), branch: Hashable = None) -> None:
        self.model, self.parameters = model, tuple(parameters)
        self.name = model.name
        self.n = self.nv = self.positions = model.n
        self.branch: Hashable = model.branch(model.home) if branch is None else branch
        known = [PAYLOAD, *(field.name for field in fields(model.parameters))]
        for name in self.parameters:
            if name not in known:
                raise UnknownNameError("parameter", name, known)

    def __reduce__(self) -> tuple[type[PaperSource], tuple[PaperModel, tuple[str, ...], Hashable]]:
        return PaperSource, (self.model, self.parameters, self.branch)

    def lacks(self, need: Need) -> CutjointError | None:
        if need is Need.JOINTS:
            return InputError(f"{self.name} is a reduced model; it has no joints beside the actuated ones")
        return None

    @cached_property
    def content(self) -> str:
        """Everything that the expressions depend on."""
        kind = type(self.model)
        parts = [kind.__module__, kind.__qualname__, self._values(), self.branch, self.parameters]
        return json.dumps([*parts, [vars(one) for one in self.model.motors]] if self.model.motors else parts)

    def _values(self) -> dict[str, Number]:
        own: PaperParameters = self.model.parameters
        return {field.name: getattr(own, field.name) for field in fields(own)}

    def with_expressions(self, given: Mapping[str, Number]) -> PaperParameters:
        """The model's parameters with expressions in place of some numbers; derived ones follow by themselves."""
        made: PaperParameters = object.__new__(type(self.model.parameters))
        values = self._values() | {name: value for name, value in given.items() if name != PAYLOAD}
        if PAYLOAD in given:
            values[self.model.payload] = values[self.model.payload] + given[PAYLOAD]
        for name, value in values.items():
            object.__setattr__(made, name, value)
        return made

    def state(self, graph: Graph, q: Sequence[Expression], parameters: Sequence[Expression]) -> PaperState:
        """The state at the actuated coordinates `q`."""
        p = self.with_expressions(dict(zip(self.parameters, parameters, strict=True)))
        return PaperState(graph, q, self.model.state_at(p, tuple(q), self.branch, FUNCTIONS), self.model.motors)

    def inverse_kinematics(self, tool: Sequence[Expression], parameters: Sequence[Expression]) -> list[Number]:
        """Actuated coordinates for the tool position; not a number where it cannot be reached."""
        p = self.with_expressions(dict(zip(self.parameters, parameters, strict=True)))
        return list(self.model.inverse_kinematics(p, (tool[0], tool[1], tool[2]), self.branch, FUNCTIONS))

    def strain_at(self, graph: Graph, q: Sequence[Number], parameters: Sequence[Expression]) -> Number:
        """What the strains at actuated coordinates come to; not a number where one of them is none, which the largest
        of them would hide."""
        p = self.with_expressions(dict(zip(self.parameters, parameters, strict=True)))
        own: EquationState = self.model.state_at(p, tuple(q), self.branch, FUNCTIONS)
        strains: list[Number] = [abs(one) for one in own.strains()]
        return reduce(add, strains)


class PaperState:
    """A `TracedState` of a published model: the positions are the actuated coordinates."""

    def __init__(
        self, graph: Graph, q: Sequence[Expression], own: EquationState, physics: Sequence[JointPhysics] = ()
    ) -> None:
        self.graph, self.q, self._own, self._motors = graph, list(q), own, tuple(physics)
        self.strain: Number = reduce(maximum, map(abs, own.strains()))

    @property
    def actuated(self) -> list[Number]:
        return list(self.q)

    def position_rate(self, v: Sequence[Number]) -> list[Number]:
        return list(v)

    def full_velocity(self, v: Sequence[Number]) -> list[Number]:
        return list(v)

    def settled(self, target: Sequence[Number] | None) -> tuple[list[Number], list[Number]]:
        """Closed by construction."""
        return list(self.q if target is None else target), []

    def mass(self) -> list[list[Number]]:
        found = [list(row) for row in self._own.mass()]
        for k, one in enumerate(self._motors):
            found[k][k] = found[k][k] + one.armature
        return found

    def gravity(self) -> list[Number]:
        return list(self._own.gravity())

    def coriolis(self, v: Sequence[Number]) -> list[Number]:
        return list(self._own.coriolis(tuple(v)))

    def springs(self) -> list[Number]:
        return list(motors.springs(self._motors, tuple(self.q))) if self._motors else [0.0] * len(self.q)

    def friction(self, v: Sequence[Number]) -> list[Number]:
        return list(motors.friction(self._motors, tuple(v), BOUNDS)) if self._motors else [0.0] * len(self.q)

    def bias(self, v: Sequence[Number]) -> list[Number]:
        parts = (self.coriolis(v), self.gravity(), self.springs(), self.friction(v))
        return [reduce(add, four) for four in zip(*parts, strict=True)]

    def inverse(self, v: Sequence[Number], a: Sequence[Number]) -> list[Number]:
        pushed = [reduce(add, map(mul, row, a)) for row in self.mass()]
        return [f + h for f, h in zip(pushed, self.bias(v), strict=True)]

    def potential(self) -> Number:
        value: Number = self._own.potential_energy()
        return value + motors.spring_energy(self._motors, tuple(self.q)) if self._motors else value

    def tool(self, v: Sequence[Number]) -> TracedTool:
        position, jacobian, drift = self._own.tool(tuple(v))
        still = (0.0,) * len(v)
        unturned = IDENTITY, (still, still, still), (0.0, 0.0, 0.0)
        rotation, turns, turned = self._own.turning(tuple(v)) or unturned
        rows = [list(row) for row in (*jacobian, *turns)]
        speed = [dot(row, v) for row in rows]
        return TracedTool(list(position), [list(row) for row in rotation], rows, [*drift, *turned], speed)
