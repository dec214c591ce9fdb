"""A closed chain as a source of expressions: its Pinocchio tree and its cuts, traced."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.equations.tree import motion_subspace
from cutjoint.compile.expressions.graph import Expression, Graph
from cutjoint.compile.once import once
from cutjoint.compile.sources.chain_plan import ChainPlan
from cutjoint.compile.sources.chain_state import ChainState
from cutjoint.compile.sources.interface import PAYLOAD, Need
from cutjoint.errors import ActuationError, CompileError, CutjointError, InputError


class ChainSource(ChainPlan):
    """A closed chain to be traced.

    Args:
        chain: any closed chain; it need not be determined by its actuators.
        parameters: what stays an argument of the compiled functions: `payload` [kg], a point mass at the tool point, or
            names of links, whose mass [kg] is then the argument (centre and shape of the inertia stay).

    Raises:
        InputError: a payload without a tool, or a link without mass.
        UnknownNameError: no such link.
    """

    def __reduce__(self) -> tuple[object, ...]:
        return ChainSource, (self.chain, self.parameters)

    def lacks(self, need: Need) -> CutjointError | None:
        if need is Need.ACTUATED and not self.determined:
            return self._not_determined()
        if need is Need.TOOL and self.chain.description.tool is None:
            return InputError(f"{self.name} has no tool frame; name one under [tool] in its loops.toml")
        if need is Need.CLOSED_FORM:
            return InputError(f"{self.name} has no inverse kinematics in closed form")
        if need is Need.IDLE_MASS and self.weightless:
            return CompileError(
                f"{self.name} has idle freedoms that move no mass, such as the spin of a rod without inertia about its "
                "axis; its forward dynamics in full coordinates cannot be compiled"
            )
        return None

    def state(self, graph: Graph, q: Sequence[Expression], parameters: Sequence[Expression]) -> ChainState:
        """The state at the configuration `q` (Pinocchio's layout)."""
        return ChainState(self, graph, q, self.pose(q, parameters))

    @once
    def content(self) -> str:
        """Everything that the expressions depend on."""
        model, description = self.model, self.chain.description
        parts: dict[str, object] = {
            "joints": [
                [model.joints[i].shortname(), int(model.parents[i]), _numbers(model.jointPlacements[i].homogeneous)]
                for i in range(1, model.njoints)
            ],
            "subspaces": [_numbers(motion_subspace(model, i)) for i in range(1, model.njoints)],
            "inertias": [_numbers(model.inertias[i].matrix()) for i in range(1, model.njoints)],
            "gravity": _numbers(model.gravity.vector),
            "origin": list(self.origin),
            "cuts": [
                [
                    [[equation.kind.name, *equation.axes] for equation in cut.type.equations],
                    [cut.joint_a, _numbers(cut.placement_a.homogeneous)],
                    [cut.joint_b, _numbers(cut.placement_b.homogeneous)],
                ]
                for cut in self.closure.cuts
            ],
            "couplings": [
                [*one.q_index, *one.v_index, *one.weights, one.constant, one.is_length]
                for one in self.closure.couplings
            ],
            "actuators": self.actuated_rates,
            "tool": None if description.tool is None else [description.tool.link, _numbers(description.tool.placement)],
            "home": _numbers(self.chain.home.q_full),
            "parameters": [[name, None if name == PAYLOAD else self._link(name)] for name in self.parameters],
        }
        return json.dumps(parts)

    def _link(self, name: str) -> list[object]:
        inertial = self.chain.description.link(name).inertial
        assert inertial is not None
        parts = (inertial.com, inertial.inertia, self.frame(name).placement.homogeneous)
        return [inertial.mass, *map(_numbers, parts)]

    def _not_determined(self) -> ActuationError:
        report = self.chain.mobility(self.chain.home)
        moving = ", ".join(report.free)
        return ActuationError(
            f"the {self.chain.n} actuators of {self.name} do not determine its motion, of mobility {report.mobility}; "
            f"{f'with all of them locked these joints still move: {moving}' if moving else 'some depend on others'}. "
            "Only full_forward can be compiled",
            mobility=report.mobility,
            actuators=self.chain.n,
            free=report.free,
        )


def _numbers(values: Array) -> list[float]:
    return [float(x) for x in np.asarray(values).ravel()]
