"""The published models as sources of expressions: their own equations, run on symbols.

No equation stands here twice.  `cutjoint.papers.*.equations` are written for floats, arrays and symbols alike; this
module only hands them expressions.  The branch (elbow signs, assembly mode) is a constant of the traced function, so
the angles inside vanish: the cosine of atan2(w, u) + acos(k) is algebra.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import fields
from functools import cached_property
from typing import Any, cast

from cutjoint.compile.expressions import functions
from cutjoint.compile.expressions.functions import maximum
from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.errors import UnknownNameError
from cutjoint.papers.cpm import CpmModel
from cutjoint.papers.cpm import equations as cpm
from cutjoint.papers.omega3 import Omega3Model
from cutjoint.papers.omega3 import equations as omega3
from cutjoint.papers.scalars import Functions, inverse, symmetric, times

PAYLOAD = "payload"
FUNCTIONS = cast(Functions, functions)
_CARRIES = {"cpm": "m4", "omega3": "m_payload"}
"""The parameter that a payload adds to."""

PaperModel = CpmModel | Omega3Model


class PaperSource:
    """A published model on one branch, to be traced.

    Args:
        model: the model.
        parameters: names that stay arguments: `payload` [kg] or any field of the model's parameters.

    Raises:
        UnknownNameError: no such parameter.
    """

    has_tool = True
    n = positions = 3

    def __init__(self, model: PaperModel, parameters: Sequence[str] = (), branch: Any = None) -> None:
        self.model, self.parameters = model, tuple(parameters)
        self.name = model.name
        self.kind = "cpm" if isinstance(model, CpmModel) else "omega3"
        self.branch: Any = model.branch(model.home) if branch is None else branch
        known = [PAYLOAD, *(field.name for field in fields(model.parameters))]
        for name in self.parameters:
            if name not in known:
                raise UnknownNameError("parameter", name, known)

    def __reduce__(self) -> Any:
        return PaperSource, (self.model, self.parameters, self.branch)

    @property
    def length(self) -> float:
        """A length [m] that tells how large the robot is."""
        own: Any = self.model.parameters
        return float(own.L1 if self.kind == "cpm" else own.L_B)

    @cached_property
    def content(self) -> str:
        """Everything that the expressions depend on."""
        model = self.model
        values = {field.name: getattr(model.parameters, field.name) for field in fields(model.parameters)}
        coefficients = list(self._coefficients(model.parameters))
        return json.dumps([self.kind, values, coefficients, self.branch, self.parameters])

    def _coefficients(self, parameters: Any) -> Any:
        own = getattr(self.model, "coefficients", None)
        return parameters.coefficients if own is None else own(parameters)

    def with_expressions(self, given: Mapping[str, Number]) -> Any:
        """The model's parameters with expressions in place of some numbers; derived ones follow by themselves."""
        made = object.__new__(type(self.model.parameters))
        values = {field.name: getattr(self.model.parameters, field.name) for field in fields(self.model.parameters)}
        values.update({name: value for name, value in given.items() if name != PAYLOAD})
        if PAYLOAD in given:
            values[_CARRIES[self.kind]] = values[_CARRIES[self.kind]] + given[PAYLOAD]
        for name, value in values.items():
            object.__setattr__(made, name, value)
        return made

    def state(self, graph: Graph, q: Sequence[Expression], parameters: Sequence[Expression]) -> CpmState | Omega3State:
        """The state at the actuated coordinates `q`."""
        p = self.with_expressions(dict(zip(self.parameters, parameters, strict=True)))
        kind = CpmState if self.kind == "cpm" else Omega3State
        return kind(graph, q, p, self._coefficients(p), self.branch)

    def inverse_kinematics(self, tool: Sequence[Expression], parameters: Sequence[Expression]) -> list[Number]:
        """Actuated coordinates for the tool position; not a number where it cannot be reached."""
        if self.kind == "cpm":
            return list(tool)
        p = self.with_expressions(dict(zip(self.parameters, parameters, strict=True)))
        return list(omega3.arm_angles(p, (tool[0], tool[1], tool[2]), self.branch.signs, FUNCTIONS))


class _PaperState:
    """What both have in common: the positions are the actuated coordinates."""

    strain: Number

    def __init__(self, graph: Graph, q: Sequence[Expression]) -> None:
        self.graph, self.q = graph, list(q)

    @property
    def actuated(self) -> list[Number]:
        """See `TracedState`."""
        return list(self.q)

    def position_rate(self, v: Sequence[Number]) -> list[Number]:
        """See `TracedState`."""
        return list(v)

    def settled(self, target: Sequence[Number] | None) -> tuple[list[Number], list[Number]]:
        """Closed by construction."""
        return list(self.q if target is None else target), []

    def mass(self) -> list[list[Number]]:
        """See `TracedState`."""
        raise AssertionError

    def gravity(self) -> list[Number]:
        """See `TracedState`."""
        raise AssertionError

    def coriolis(self, v: Sequence[Number]) -> list[Number]:
        """See `TracedState`."""
        raise AssertionError

    def bias(self, v: Sequence[Number]) -> list[Number]:
        """See `TracedState`."""
        return [x + y for x, y in zip(self.coriolis(v), self.gravity(), strict=True)]

    def inverse(self, v: Sequence[Number], a: Sequence[Number]) -> list[Number]:
        """See `TracedState`."""
        x, y, z = a
        m = self.mass()
        pushed = times(
            ((m[0][0], m[0][1], m[0][2]), (m[1][0], m[1][1], m[1][2]), (m[2][0], m[2][1], m[2][2])), (x, y, z)
        )
        return [f + h for f, h in zip(pushed, self.bias(v), strict=True)]


class CpmState(_PaperState):
    """A `TracedState` of the CPM's Lagrange model."""

    def __init__(self, graph: Graph, q: Sequence[Expression], p: Any, k: Any, signs: Sequence[int]) -> None:
        super().__init__(graph, q)
        self._p, self._k = p, k
        tool, (one, two, three) = (q[0], q[1], q[2]), signs
        angles = cpm.limb_angles(p, tool, (one, two, three), FUNCTIONS)
        self._limbs = cpm.limbs(p, tool, angles, FUNCTIONS)
        self._gamma = cpm.gamma(self._limbs)
        self.strain = 1.0
        for limb in self._limbs:
            self.strain = maximum(self.strain, abs(p.L1 * p.L2 / limb.denominator))

    def mass(self) -> list[list[Number]]:
        """See `TracedState`."""
        return [list(row) for row in symmetric(cpm.mass(self._k, self._gamma))]

    def gravity(self) -> list[Number]:
        """See `TracedState`."""
        return list(cpm.gravity(self._k, self._limbs, self._gamma))

    def coriolis(self, v: Sequence[Number]) -> list[Number]:
        """See `TracedState`."""
        velocity = (v[0], v[1], v[2])
        rates = cpm.gamma_dot(self._p, self._limbs, velocity)
        return list(cpm.coriolis(self._k, self._gamma, rates, velocity))

    def potential(self) -> Number:
        """See `TracedState`."""
        value: Number = cpm.potential_energy(self._k, self._limbs)
        return value

    def tool(self, v: Sequence[Number]) -> tuple[list[Number], list[list[Number]], list[Number]]:
        """See `TracedState`."""
        identity: list[list[Number]] = [[1.0 if i == k else 0.0 for k in range(3)] for i in range(3)]
        return list(self.q), identity, [0.0, 0.0, 0.0]


class Omega3State(_PaperState):
    """A `TracedState` of the Omega-3's virtual-work model."""

    def __init__(self, graph: Graph, q: Sequence[Expression], p: Any, k: Any, branch: Any) -> None:
        super().__init__(graph, q)
        self._p, self._k = p, k
        self._arms = omega3.arms(p, (q[0], q[1], q[2]), FUNCTIONS)
        self._tool = omega3.tool_position(omega3.spheres(p, self._arms), branch[1], FUNCTIONS)
        self._rods = omega3.rods(self._arms, self._tool)
        self._inverse = inverse(self._rods.u)
        self._jacobian = omega3.jacobian(self._rods, self._inverse)
        self.strain = abs(p.L_B * p.L_B * p.L_B / self._rods.volume)

    def _drift(self, v: Sequence[Number]) -> Any:
        return omega3.drift(self._arms, self._rods, self._inverse, self._jacobian, (v[0], v[1], v[2]))

    def mass(self) -> list[list[Number]]:
        """See `TracedState`."""
        return [list(row) for row in symmetric(omega3.mass(self._k, self._jacobian))]

    def gravity(self) -> list[Number]:
        """See `TracedState`."""
        return list(omega3.gravity(self._k, self._arms, self._jacobian))

    def coriolis(self, v: Sequence[Number]) -> list[Number]:
        """See `TracedState`."""
        return list(omega3.coriolis(self._k, self._jacobian, self._drift(v)))

    def potential(self) -> Number:
        """See `TracedState`."""
        value: Number = omega3.potential_energy(self._p, self._k, self._arms, self._tool)
        return value

    def tool(self, v: Sequence[Number]) -> tuple[list[Number], list[list[Number]], list[Number]]:
        """See `TracedState`."""
        return list(self._tool), [list(row) for row in self._jacobian], list(self._drift(v))
