"""A closed chain as a source of expressions: its Pinocchio tree and its cuts, traced."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.compile import space
from cutjoint.compile.graph import Expression, Graph, Number
from cutjoint.compile.inertia import Body
from cutjoint.compile.loops import CutFrames, Gear, Loops
from cutjoint.compile.pivots import Plan, Survey, choose
from cutjoint.compile.reduction import MassFactor, Reduction
from cutjoint.compile.tree import (
    Motion,
    PointMass,
    Pose,
    Tree,
    accelerations,
    configuration_rate,
    from_rate_derivatives,
    from_rates,
    moved,
    potential_energy,
    to_rates,
    velocities,
)
from cutjoint.description.model import Inertial
from cutjoint.errors import CompileError, InputError, UnknownNameError

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain
    from cutjoint.chain.closure import Closure

PAYLOAD = "payload"


class ChainSource:
    """A closed chain to be traced.

    Args:
        chain: any closed chain; it need not be determined by its actuators.
        parameters: what stays an argument of the compiled functions: `payload` [kg], a point mass at the tool point, or
            names of links, whose mass [kg] is then the argument (centre and shape of the inertia stay).

    Raises:
        InputError: a payload without a tool, or a link without mass.
        UnknownNameError: no such link.
    """

    def __init__(self, chain: ClosedChain, parameters: Sequence[str] = ()) -> None:
        self.chain = chain
        self.name, self.parameters = chain.name, tuple(parameters)
        self.positions, self.nv = chain.nq, chain.nv
        self.has_tool = chain.description.tool is not None
        self.actuated = tuple(int(i) for i in chain.actuated(np.arange(float(chain.nq))))
        self.actuated_rates = tuple(int(i) for i in chain.actuated_velocity(np.arange(float(chain.nv))))
        known = [link.name for link in chain.description.links]
        for name in self.parameters:
            if name == PAYLOAD:
                if not self.has_tool:
                    raise InputError(f"{chain.name} has no tool frame to carry a payload")
            elif name not in known:
                raise UnknownNameError("inertial parameter", name, [PAYLOAD, *known])
            elif (chain.description.link(name).inertial or Inertial(0.0)).mass <= 0.0:
                raise InputError(f"link '{name}' of {chain.name} has no mass to vary")

    @cached_property
    def n(self) -> int:
        """Number of independent coordinates: that of the actuators where they determine the motion."""
        return self.chain.n if self.determined else len(self.plan.independent)

    @cached_property
    def determined(self) -> bool:
        """Whether the independent coordinates are the actuated ones."""
        return self.chain.mobility(self.chain.home).determined

    @cached_property
    def tree(self) -> Tree:
        """The tree without the links whose masses are arguments."""
        from cutjoint.chain.build import build_model

        description = self.chain.description
        for name in self.parameters:
            if name != PAYLOAD:
                description = description.with_inertial(name, Inertial(0.0))
        model = self.chain.model if description is self.chain.description else build_model(description)
        return Tree(model)

    @cached_property
    def loops(self) -> Loops:
        """Its cuts and couplings."""
        closure = self._closure
        cuts = [
            CutFrames(cut.name, cut.type, cut.joint_a, cut.placement_a, cut.joint_b, cut.placement_b)
            for cut in closure.cuts
        ]
        gears = [
            Gear(one.name, one.q_joint, one.q_driver, one.v_joint, one.v_driver, one.ratio, one.offset)
            for one in closure.ratios
        ]
        return Loops(self.tree, cuts, gears)

    @cached_property
    def _closure(self) -> Closure:
        from cutjoint.chain.closure import Closure

        return Closure(self.chain.model, self.chain.description)

    @cached_property
    def cloud(self) -> Array:
        """Closed configurations around home, shape (k, nq); home first."""
        return self._survey.cloud(np.array(self.chain.home.q_full))

    @cached_property
    def plan(self) -> Plan:
        """Order of elimination.

        Raises:
            CompileError: none is good around home.
        """
        plan = choose(self._survey, self.cloud, self.actuated_rates)
        if self.determined and plan.independent != self.actuated_rates:
            raise CompileError(
                f"no fixed order of elimination keeps the actuators of {self.name} around its home posture: it is "
                "too near "
                "to a singularity. Choose another home"
            )
        return plan

    @cached_property
    def _survey(self) -> Survey:
        return Survey(self.tree, self.loops, self.chain.length)

    @cached_property
    def content(self) -> str:
        """Everything that the expressions depend on."""
        model, description = self.chain.model, self.chain.description
        closure = self._closure
        parts: dict[str, object] = {
            "joints": [
                [model.joints[i].shortname(), int(model.parents[i]), _numbers(model.jointPlacements[i].homogeneous)]
                for i in range(1, model.njoints)
            ],
            "subspaces": [_numbers(step) for step in self._axes()],
            "inertias": [_numbers(model.inertias[i].matrix()) for i in range(1, model.njoints)],
            "gravity": _numbers(model.gravity.vector),
            "cuts": [
                [cut.type.value, cut.joint_a, cut.joint_b, *map(_placement, (cut.placement_a, cut.placement_b))]
                for cut in closure.cuts
            ],
            "couplings": [[r.q_joint, r.q_driver, r.v_joint, r.v_driver, r.ratio, r.offset] for r in closure.ratios],
            "actuators": self.actuated_rates,
            "tool": None if description.tool is None else [description.tool.link, _numbers(description.tool.placement)],
            "home": _numbers(self.chain.home.q_full),
            "parameters": [[name, None if name == PAYLOAD else self._link(name)] for name in self.parameters],
        }
        return json.dumps(parts)

    def _axes(self) -> list[Array]:
        data = self.chain.model.createData()
        return [np.array(pin.computeJointJacobians(self.chain.model, data, pin.neutral(self.chain.model)))]

    def _link(self, name: str) -> list[object]:
        inertial = self.chain.description.link(name).inertial
        assert inertial is not None
        frame = self.chain.model.frames[self.chain.model.getFrameId(name)]
        return [
            inertial.mass,
            _numbers(inertial.com),
            _numbers(inertial.inertia),
            _numbers(frame.placement.homogeneous),
        ]

    def state(self, graph: Graph, q: Sequence[Expression], parameters: Sequence[Expression]) -> ChainState:
        """The state at the configuration `q` (Pinocchio's layout)."""
        points: list[PointMass] = []
        bodies: list[Body] = []
        for name, value in zip(self.parameters, parameters, strict=True):
            if name == PAYLOAD:
                step, lever = self.tool_point
                points.append(PointMass(step, value, lever))
            else:
                bodies.append(self._body(name, value))
        return ChainState(self, graph, q, bodies, points)

    @cached_property
    def tool_point(self) -> tuple[int, space.Vector]:
        """Step and lever of the tool point."""
        from cutjoint.chain.closure import bind_frame

        tool = self.chain.description.tool
        if tool is None:
            raise InputError(f"{self.name} has no tool frame; name one under [tool] in its loops.toml")
        joint, placement = bind_frame(self.chain.model, tool)
        return self.tree.point(joint, np.asarray(placement.translation))

    def _body(self, name: str, mass: Number) -> Body:
        """A link whose mass is an argument."""
        inertial = self.chain.description.link(name).inertial
        assert inertial is not None
        frame = self.chain.model.frames[self.chain.model.getFrameId(name)]
        rotation, at = np.asarray(frame.placement.rotation), np.asarray(frame.placement.translation)
        centre = rotation @ inertial.com + at
        inertia = rotation @ inertial.inertia @ rotation.T / inertial.mass
        inertia = inertia + centre @ centre * np.eye(3) - np.outer(centre, centre)
        return self.tree.scaled_body(frame.parentJoint, mass, centre, inertia)


class ChainState:
    """A `TracedState` of a closed chain."""

    def __init__(
        self,
        source: ChainSource,
        graph: Graph,
        q: Sequence[Expression],
        bodies: Sequence[Body] = (),
        points: Sequence[PointMass] = (),
    ) -> None:
        self.source, self.graph, self.q = source, graph, list(q)
        self.pose = Pose(source.tree, q, bodies, points)
        self.reduction = Reduction(self.pose, source.loops, source.plan)
        self.strain: Number = self.reduction.strain

    @property
    def actuated(self) -> list[Number]:
        """See `TracedState`."""
        return [self.q[i] for i in self.source.actuated]

    def position_rate(self, v: Sequence[Number]) -> list[Number]:
        """See `TracedState`."""
        return configuration_rate(self.pose, self.reduction.rates(v))

    def mass(self) -> list[list[Number]]:
        """See `TracedState`."""
        return self.reduction.mass()

    def gravity(self) -> list[Number]:
        """See `TracedState`."""
        return self.reduction.gravity()

    def coriolis(self, v: Sequence[Number]) -> list[Number]:
        """See `TracedState`."""
        u, motion, drift = self.moving(v)
        return self.reduction.effort(u, motion, drift, weight=False)

    def bias(self, v: Sequence[Number]) -> list[Number]:
        """See `TracedState`."""
        u, motion, drift = self.moving(v)
        return self.reduction.effort(u, motion, drift)

    def inverse(self, v: Sequence[Number], a: Sequence[Number]) -> list[Number]:
        """See `TracedState`."""
        u, motion, drift = self.moving(v)
        du = [x + y for x, y in zip(self.reduction.rates(a), drift, strict=True)]
        return self.reduction.effort(u, motion, du)

    def moving(self, v: Sequence[Number]) -> tuple[list[Number], Motion, list[Number]]:
        """Rates, velocities and drift."""
        u = self.reduction.rates(v)
        motion = velocities(self.pose, u)
        return u, motion, self.reduction.drift(u, motion)

    def potential(self) -> Number:
        """See `TracedState`."""
        return potential_energy(self.pose)

    def tool(self, v: Sequence[Number]) -> tuple[list[Number], list[list[Number]], list[Number]]:
        """See `TracedState`."""
        step, lever = self.source.tool_point
        arm = self.pose.lever(step, lever)
        position = space.add(self.pose.origin(step), arm)
        columns = self.pose.columns(step, lever)
        tangent = self.reduction.tangent
        jacobian: list[list[Number]] = [[0.0] * self.reduction.n for _ in range(3)]
        for rate, velocity, _ in columns:
            for axis in range(3):
                for k in range(self.reduction.n):
                    jacobian[axis][k] = jacobian[axis][k] + velocity[axis] * tangent[rate][k]
        u, motion, drift = self.moving(v)
        bias = accelerations(self.pose, u, motion, drift)
        w = motion.angular[step]
        pull = space.add(bias.at(step, arm), space.cross(w, space.cross(w, arm)))
        return list(position), jacobian, list(pull)

    def settled(self, target: Sequence[Number] | None) -> tuple[list[Number], list[Number]]:
        """See `TracedState`; with a target the independent coordinates must be turns and slides."""
        change: list[Number] = [0.0] * self.reduction.n
        if target is not None:
            change = [x - y for x, y in zip(target, self.actuated, strict=True)]
        return moved(self.pose, self.reduction.correction(change)), self.reduction.residuals

    # -- full coordinates --------------------------------------------------------------------------------------------

    def full_tangent(self) -> list[list[Number]]:
        """T with v_full = T v in Pinocchio's velocities, shape (nv, n)."""
        n = self.reduction.n
        columns = [from_rates(self.pose, [row[k] for row in self.reduction.tangent]) for k in range(n)]
        return [[columns[k][i] for k in range(n)] for i in range(self.source.nv)]

    def full_drift(self, v: Sequence[Number]) -> list[Number]:
        """d with a_full = T a + d in Pinocchio's accelerations, length nv."""
        u, motion, drift = self.moving(v)
        return from_rate_derivatives(self.pose, u, motion, drift)

    def full_forward(self, v_full: Sequence[Number], effort_full: Sequence[Number]) -> tuple[list[Number], Number]:
        """Acceleration of all joints for a velocity that respects the loops and forces on all joints; and the "
        "strain."""
        u = to_rates(self.pose, v_full)
        motion = velocities(self.pose, u)
        drift = self.reduction.drift(u, motion)
        push = self.reduction.reduced(to_rates(self.pose, effort_full))
        held = self.reduction.effort(u, motion, drift)
        factor = MassFactor(self.mass(), self.strain)
        a = factor.solve([x - y for x, y in zip(push, held, strict=True)])
        du = [x + y for x, y in zip(self.reduction.rates(a), drift, strict=True)]
        return from_rate_derivatives(self.pose, u, motion, du), factor.strain


def _numbers(values: Array) -> list[float]:
    return [float(x) for x in np.asarray(values).ravel()]


def _placement(placement: pin.SE3) -> list[float]:
    return _numbers(placement.homogeneous)
