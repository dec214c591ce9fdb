"""A closed chain as a source of expressions: its Pinocchio tree and its cuts, traced."""

from __future__ import annotations

import json
import threading
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.compile.equations.carried import idle_masses, supports, weighed
from cutjoint.compile.equations.cloud import Survey, null_space, rate_scale
from cutjoint.compile.equations.cut_rows import Loops
from cutjoint.compile.equations.elimination_order import Idle, Plan, choose
from cutjoint.compile.equations.inertia import BodyInertia, PointMass
from cutjoint.compile.equations.pose import Pose
from cutjoint.compile.functions.chain_numbers import Projection
from cutjoint.compile.equations.reduction import Reduction
from cutjoint.compile.equations.tree import JointTree, motion_subspace
from cutjoint.compile.expressions import vectors
from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.once import once
from cutjoint.compile.sources.chain_state import ChainState
from cutjoint.description.model import Inertial
from cutjoint.errors import ActuationError, CompileError, CutjointError, InputError, UnknownNameError
from cutjoint.mechanism import Posture

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain
    from cutjoint.chain.closure import Closure

PAYLOAD = "payload"
STARTS = 12
"""How often a regular posture is looked for around a singular home."""


class ChainSource:
    """A closed chain to be traced.

    The chain's local model stands near its origin, however far away its base is: `origin` (3,) [m] is where, and is
    added to tool positions and to the height of the masses, not carried through the arithmetic.

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
        self._lock = threading.RLock()
        self.model: pin.Model = chain.local_model
        self.origin = vectors.constant_vector(chain.origin)
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

    def __reduce__(self) -> Any:
        return ChainSource, (self.chain, self.parameters)

    @once
    def n(self) -> int:
        """Number of independent coordinates: that of the actuators where they determine the motion."""
        return self.chain.n if self.determined else len(self.plan.independent)

    @property
    def determined(self) -> bool:
        """Whether the independent coordinates are the actuated ones; idle freedoms do not count."""
        return self.idle is not None

    @once
    def idle(self) -> int | None:
        """Number of idle freedoms, or None where the actuators do not determine the rest of the motion.

        It is asked at home, and where home may be singular on a regular posture near by.
        """
        if self.chain.n == 0:
            return None
        at_home = self._idle_at(self.chain.home)
        if at_home is not None or not self.loops.count:
            return at_home
        try:
            cloud = self.cloud
        except CompileError:
            return None
        moved = not np.array_equal(cloud[0], self.chain.home.q_full)
        return self._idle_at(self._posture(cloud[0])) if moved else None

    def _idle_at(self, at: Posture) -> int | None:
        report = self.chain.mobility(at)
        return report.idle_mobility if report.determined else None

    @once
    def numbers(self) -> Projection:
        """The same chain in numbers, to compare with."""
        self._need_all_rows()
        return Projection(self)

    def _need_all_rows(self) -> None:
        if self.nv == 0:
            raise CompileError(f"{self.name} has no joint that moves: there is nothing to compile")
        if len(self.chain.constraint_jacobian(self.chain.home.q_full)) != len(self.row_is_length):
            raise CompileError(
                f"{self.name} cannot be compiled: its loops close only when some of their rows are left out, and what "
                "those are open by differs from posture to posture. Give its frames more digits"
            )

    @property
    def row_is_length(self) -> tuple[bool, ...]:
        """Whether a row of the constraints is a length (else an angle)."""
        return tuple(bool(x) for x in self._closure.is_length)

    @once
    def tree(self) -> JointTree:
        """The tree without the links whose masses are arguments."""
        varied = [name for name in self.parameters if name != PAYLOAD]
        return JointTree(self._without(varied) if varied else self.model)

    def _without(self, links: Sequence[str]) -> pin.Model:
        """The model without the inertias of some links."""
        model = pin.Model(self.model)
        frames = {
            link.name: model.frames[model.getFrameId(link.name, pin.FrameType.BODY)]
            for link in self.chain.description.links
        }
        for joint in {int(frames[name].parentJoint) for name in links}:
            total = pin.Inertia.Zero()
            for link in self.chain.description.links:
                inertial, frame = link.inertial, frames[link.name]
                if inertial is not None and link.name not in links and int(frame.parentJoint) == joint:
                    own = pin.Inertia(inertial.mass, np.array(inertial.com), np.array(inertial.inertia))
                    total = total + frame.placement.act(own)
            model.inertias[joint] = total
        return model

    @once
    def loops(self) -> Loops:
        """Its cuts and couplings."""
        return Loops(self.tree, self._closure.cuts, self._closure.ratios)

    @once
    def _closure(self) -> Closure:
        from cutjoint.chain.closure import Closure

        return Closure(self.model, self.chain.description)

    @once
    def cloud(self) -> Array:
        """Closed configurations around home that are not near a singularity, shape (k, nq); home first if it is one.

        Raises:
            CompileError: there is none.
        """
        survey, home = self._survey, np.array(self.chain.home.q_full)
        found = survey.regular(survey.cloud(home), self.actuated_rates)
        stuck = len(found) < 2 and null_space(survey.system(home)[0]).shape[1] > 0
        if len(found) and np.array_equal(found[0], home) and not stuck:
            return found
        # home is singular: branches meet there, and a walk along the tangent need not lead onto the one that is meant
        chance, best = np.random.default_rng(0), found
        for attempt in range(STARTS):
            if len(best) > 1 and self._idle_at(self._posture(best[0])) is not None:
                break
            aside = survey.moved(home, (1.0 + attempt) / STARTS * chance.normal(size=self.nv))
            try:
                start = np.array(self.chain.assemble(aside, keep_actuators=False).q_full)
            except CutjointError:
                continue
            around = survey.regular(survey.cloud(start), self.actuated_rates)
            best = around if len(around) > 1 else best
        if len(best) < 2:
            raise CompileError(
                f"{self.name} cannot be compiled: it is singular at home, or cannot move there, and no posture around "
                "home was found that is not; choose another home"
            )
        return best

    def _posture(self, q_full: Array) -> Posture:
        return Posture(self.chain.actuated(q_full), q_full)

    @once
    def plan(self) -> Plan:
        """Order of elimination.

        Raises:
            CompileError: none is good around home.
        """
        plan = choose(self._survey, self.cloud, self.actuated_rates)
        if self.idle is None:
            return plan
        n = self.chain.n
        if plan.independent[:n] != self.actuated_rates or len(plan.independent) != n + self.idle:
            raise CompileError(
                f"no fixed order of elimination keeps the actuators of {self.name} around its home posture: it is "
                "too near to a singularity. Choose another home"
            )
        return self._with_idle(plan) if self.idle else plan

    def _with_idle(self, plan: Plan) -> Plan:
        """A plan with what the cloud tells of its idle freedoms."""
        jacobians = np.array([self._survey.system(q)[0] for q in self.cloud])
        moves = supports(jacobians, plan, self.chain.n)
        rough = replace(plan, idle=Idle(moves, (), (), ()))
        graph = Graph()
        q = graph.symbols(self.positions)
        pose = self.pose(q, [0.0 if name == PAYLOAD else self._mass(name) for name in self.parameters])
        reduction = Reduction(pose, self.loops, rough)
        masses = idle_masses(pose, reduction, graph, q, self.rate_scale, self.cloud)
        return replace(plan, idle=weighed(masses, moves))

    def _mass(self, link: str) -> float:
        inertial = self.chain.description.link(link).inertial
        return 0.0 if inertial is None else float(inertial.mass)

    @property
    def weightless(self) -> bool:
        """Whether some idle freedoms move no mass: which force moves them how, the joints' masses do not say."""
        return bool(self.idle) and self.plan.idle is not None and bool(self.plan.idle.weightless)

    @once
    def rate_scale(self) -> tuple[float, ...]:
        """Factor per rate that makes it dimensionless, length nv."""
        return tuple(rate_scale(self.tree, self.chain.length).tolist())

    @once
    def _survey(self) -> Survey:
        self._need_all_rows()
        return Survey(self.tree, self.loops, self.chain.length)

    def need_actuated(self) -> None:
        """Check that there is anything in actuated coordinates.

        Raises:
            ActuationError: the actuators do not determine the motion.
        """
        if self.determined:
            return
        report = self.chain.mobility(self.chain.home)
        moving = ", ".join(report.free)
        raise ActuationError(
            f"the {self.chain.n} actuators of {self.name} do not determine its motion, of mobility {report.mobility}; "
            f"{f'with all of them locked these joints still move: {moving}' if moving else 'some depend on others'}. "
            "Only full_forward can be compiled",
            mobility=report.mobility,
            actuators=self.chain.n,
            free=report.free,
        )

    @once
    def position_scale(self) -> tuple[float, ...]:
        """Robot's length for configuration coordinates that are lengths, 1 for the others, length nq."""
        scale = [1.0] * self.positions
        for step in self.tree.steps[1:]:
            scale[step.q : step.q + step.kind.lengths] = [float(self.chain.length)] * step.kind.lengths
        return tuple(scale)

    @once
    def content(self) -> str:
        """Everything that the expressions depend on."""
        model, description = self.model, self.chain.description
        closure = self._closure
        parts: dict[str, object] = {
            "joints": [
                [model.joints[i].shortname(), int(model.parents[i]), _numbers(model.jointPlacements[i].homogeneous)]
                for i in range(1, model.njoints)
            ],
            "subspaces": [_numbers(step) for step in self._axes()],
            "inertias": [_numbers(model.inertias[i].matrix()) for i in range(1, model.njoints)],
            "gravity": _numbers(model.gravity.vector),
            "origin": list(self.origin),
            "cuts": [
                [cut.type.value, cut.joint_a, cut.joint_b, *map(_placement, (cut.placement_a, cut.placement_b))]
                for cut in closure.cuts
            ],
            "couplings": [
                [r.q_joint, r.q_driver, r.v_joint, r.v_driver, r.ratio, r.offset, r.is_length] for r in closure.ratios
            ],
            "actuators": self.actuated_rates,
            "tool": None if description.tool is None else [description.tool.link, _numbers(description.tool.placement)],
            "home": _numbers(self.chain.home.q_full),
            "parameters": [[name, None if name == PAYLOAD else self._link(name)] for name in self.parameters],
        }
        return json.dumps(parts)

    def _axes(self) -> list[Array]:
        return [motion_subspace(self.model, joint) for joint in range(1, self.model.njoints)]

    def _link(self, name: str) -> list[object]:
        inertial = self.chain.description.link(name).inertial
        assert inertial is not None
        frame = self.model.frames[self.model.getFrameId(name, pin.FrameType.BODY)]
        return [
            inertial.mass,
            _numbers(inertial.com),
            _numbers(inertial.inertia),
            _numbers(frame.placement.homogeneous),
        ]

    def state(self, graph: Graph, q: Sequence[Expression], parameters: Sequence[Expression]) -> ChainState:
        """The state at the configuration `q` (Pinocchio's layout)."""
        return ChainState(self, graph, q, self.pose(q, parameters))

    def pose(self, q: Sequence[Number], parameters: Sequence[Number]) -> Pose:
        """The tree at the configuration `q`, with the values of the inertial parameters."""
        points: list[PointMass] = []
        bodies: list[BodyInertia] = []
        for name, value in zip(self.parameters, parameters, strict=True):
            if name == PAYLOAD:
                step, lever = self.tool_point
                points.append(PointMass(step, value, lever))
            else:
                bodies.append(self._body(name, value))
        return Pose(self.tree, q, bodies, points)

    @once
    def tool_point(self) -> tuple[int, vectors.Vector]:
        """Step and lever of the tool point."""
        from cutjoint.chain.closure import bind_frame

        tool = self.chain.description.tool
        if tool is None:
            raise InputError(f"{self.name} has no tool frame; name one under [tool] in its loops.toml")
        joint, placement = bind_frame(self.model, tool)
        return self.tree.point(joint, np.asarray(placement.translation))

    def _body(self, name: str, mass: Number) -> BodyInertia:
        """A link whose mass is an argument."""
        inertial = self.chain.description.link(name).inertial
        assert inertial is not None
        frame = self.model.frames[self.model.getFrameId(name, pin.FrameType.BODY)]
        rotation, at = np.asarray(frame.placement.rotation), np.asarray(frame.placement.translation)
        centre = rotation @ inertial.com + at
        inertia = rotation @ inertial.inertia @ rotation.T / inertial.mass
        inertia = inertia + centre @ centre * np.eye(3) - np.outer(centre, centre)
        return self.tree.scaled_body(frame.parentJoint, mass, centre, inertia)


def _numbers(values: Array) -> list[float]:
    return [float(x) for x in np.asarray(values).ravel()]


def _placement(placement: pin.SE3) -> list[float]:
    return _numbers(placement.homogeneous)
