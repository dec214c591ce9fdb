"""A closed chain as a source of expressions: its Pinocchio tree and its cuts, traced, and one of its states."""

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
from cutjoint.compile.sources.interface import Need
from cutjoint.errors import ActuationError, CompileError, CutjointError, InputError
from cutjoint.mechanism.physics import NO_PHYSICS


class ChainSource(ChainPlan):
    """A closed chain to be traced.

    Args:
        chain: any closed chain; it need not be determined by its actuators.
        parameters: what stays an argument of the compiled functions, see `cutjoint.compile.sources.parameters`.
        ranges: of parameters, for which the order of elimination shall be good; default a neighbourhood of the chain's
            own values.

    Raises:
        InputError: a payload without a tool, a link without mass, or a range that is none.
        UnknownNameError: no such path or link.
    """

    def __reduce__(self) -> tuple[object, ...]:
        ranges = dict(zip(self.parameters, zip(self.low.tolist(), self.high.tolist(), strict=True), strict=True))
        return ChainSource, (self.chain, self.parameters, ranges)

    def lacks(self, need: Need) -> CutjointError | None:
        if need is Need.ACTUATED and not self.determined:
            return self._not_determined()
        if need is Need.TOOL and self.chain.description.tool is None:
            return InputError(f"{self.name} has no tool frame; name one under [tool] in its loops.toml")
        if need is Need.TASK and self.determined:
            return self._lacks_task()
        if need is Need.PARAMETERS and not self.parameters:
            return InputError(f"no number of {self.name} is an argument; name some: compiled(..., parameters=[...])")
        if need is Need.CLOSED_FORM:
            return InputError(f"{self.name} has no inverse kinematics in closed form")
        if need is Need.SMOOTH and (names := self.physics.sticking(dict.fromkeys(self.parameters, np.nan))):
            return CompileError(
                f"the friction of {', '.join(names)} holds what rests (friction_speed = 0), and {self.name} jumps "
                "there: its dynamics cannot be compiled. Give a friction_speed above 0, or run the chain itself"
            )
        return None

    def state(self, graph: Graph, q: Sequence[Expression], parameters: Sequence[Expression]) -> ChainState:
        """The state at the configuration `q` (Pinocchio's layout)."""
        return ChainState(self, graph, q, parameters)

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
                    cut.length,
                ]
                for cut in self.closure.cuts
            ],
            "couplings": [
                [*one.q_index, *one.v_index, *(curve.pieces for curve in one.curves), one.offset, one.is_length]
                for one in self.closure.couplings
            ],
            "actuators": self.actuated_rates,
            "tool": None if description.tool is None else [description.tool.link, _numbers(description.tool.placement)],
            "task": self._task(),
            "home": _numbers(self.chain.home.q_full),
            "parameters": self.parameters,
        }
        if self.parameters:
            parts["numbers"] = self.arguments.everything()
            parts["ranges"] = [_numbers(self.low), _numbers(self.high)]
        apart = {"passive": self._passive_numbers(), "held up": self._held_up()}
        return json.dumps(parts | {key: numbers for key, numbers in apart.items() if numbers})

    def _held_up(self) -> list[object]:
        """Of every body whose weight is compensated, how much of it and where; of those with arguments the share."""
        shares = [(name, self.chain.description.link(name).gravity_compensation) for name in self.varied.links]
        constant = ([one.step, one.mass, *one.moment] for one in self.held_up)
        return [*constant, *([name, share] for name, share in shares if share)]

    def _passive_numbers(self) -> list[object]:
        """Of every joint and cut that does something by itself, what it does, and between which stops."""
        description = self.chain.description
        found: list[object] = [
            [one.name, vars(one.physics), one.limits.lower, one.limits.upper]
            for one in description.joints
            if one.physics != NO_PHYSICS
        ]
        for cut in description.cuts:
            if cut.bushing is not None or cut.physics != NO_PHYSICS:
                ends = [[frame.link, _numbers(frame.placement)] for frame in (cut.a, cut.b)]
                bushing = None if cut.bushing is None else vars(cut.bushing)
                found.append([cut.name, cut.type, *ends, vars(cut.physics), bushing])
        return found

    def _task(self) -> list[object] | None:
        try:
            task = self.chain.task
        except InputError:
            return None
        return [task.names, task.axes, _numbers(task.home.matrix)]

    def _lacks_task(self) -> CutjointError | None:
        try:
            task = self.chain.task
        except InputError as error:
            return error
        if len(task.rows) < self.chain.n:
            return InputError(f"the task of {self.name}, {task}, does not say where its {self.chain.n} actuators are")
        try:
            _ = self.led_plan
        except CompileError as error:
            return error
        return None

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
