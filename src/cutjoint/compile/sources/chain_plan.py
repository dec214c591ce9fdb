"""The tree of a closed chain, and what is decided of it once and for all, on a cloud of postures around home.

Which freedoms are idle, which postures are regular, and in which order to eliminate.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array, readonly
from cutjoint.chain import ClosedChain
from cutjoint.chain.build import bind_frame
from cutjoint.chain.closure import Closure
from cutjoint.chain.joints import velocity_scale
from cutjoint.chain.rank import null_space
from cutjoint.compile.equations.carried import idle_masses, supports, weighed
from cutjoint.compile.equations.cloud import Survey
from cutjoint.compile.equations.cut_rows import Loops
from cutjoint.compile.equations.elimination_order import Idle, Plan, choose
from cutjoint.compile.equations.inertia import BodyInertia, PointMass
from cutjoint.compile.equations.led import LedLoops
from cutjoint.compile.equations.physics import TreePhysics
from cutjoint.compile.equations.pose import Arguments, TreePose
from cutjoint.compile.equations.reduction import Reduction
from cutjoint.compile.equations.tree import JointTree
from cutjoint.compile.expressions import vectors
from cutjoint.compile.expressions.graph import Graph, Number
from cutjoint.compile.once import once
from cutjoint.compile.sources.interface import PAYLOAD
from cutjoint.description.model import Inertial
from cutjoint.errors import CompileError, CutjointError, InputError, UnknownNameError

STARTS = 12
"""How often a regular posture is looked for around a singular home."""


class ChainTree:
    """The tree of a chain; its local model stands near its origin, however far away its base is.

    Args:
        chain: any closed chain.
        parameters: see `ChainSource`.

    Attributes:
        origin: where the local model stands (3,) [m]; it is added to tool positions and to the height of the masses,
            not carried through the arithmetic.
        positions, nv: sizes of configuration and velocity.
        rate_scale: factor per rate that makes it dimensionless, shape (nv,).
        actuated, actuated_rates: where the actuated coordinates stand in them.
    """

    def __init__(self, chain: ClosedChain, parameters: Sequence[str] = ()) -> None:
        self.chain = chain
        self._lock = threading.RLock()
        self.model: pin.Model = chain.local_model
        self.origin = vectors.constant_vector(chain.origin)
        self.name, self.parameters = chain.name, tuple(parameters)
        self.positions, self.nv = chain.nq, chain.nv
        self.rate_scale = velocity_scale(self.model, chain.length)
        self.actuated = tuple(int(i) for i in chain.actuated(np.arange(float(chain.nq))))
        self.actuated_rates = tuple(int(i) for i in chain.actuated_velocity(np.arange(float(chain.nv))))
        known = [link.name for link in chain.description.links]
        for name in self.parameters:
            if name == PAYLOAD:
                if chain.description.tool is None:
                    raise InputError(f"{chain.name} has no tool frame to carry a payload")
            elif name not in known:
                raise UnknownNameError("inertial parameter", name, [PAYLOAD, *known])
            elif (chain.description.link(name).inertial or Inertial(0.0)).mass <= 0.0:
                raise InputError(f"link '{name}' of {chain.name} has no mass to vary")

    @once
    def tree(self) -> JointTree:
        """The tree without the links whose masses are arguments."""
        varied = [name for name in self.parameters if name != PAYLOAD]
        return JointTree(self._without(varied) if varied else self.model)

    def _without(self, links: Sequence[str]) -> pin.Model:
        """The model without the inertias of some links."""
        model = pin.Model(self.model)
        frames = {link.name: self.frame(link.name) for link in self.chain.description.links}
        for joint in {int(frames[name].parentJoint) for name in links}:
            total = pin.Inertia.Zero()
            for link in self.chain.description.links:
                inertial, frame = link.inertial, frames[link.name]
                if inertial is not None and link.name not in links and int(frame.parentJoint) == joint:
                    own = pin.Inertia(inertial.mass, np.array(inertial.com), np.array(inertial.inertia))
                    total = total + frame.placement.act(own)
            model.inertias[joint] = total
        return model

    def pose(self, q: Sequence[Number], parameters: Sequence[Number]) -> TreePose:
        """The tree at the configuration `q`, with the values of the inertial parameters."""
        points: list[PointMass] = []
        bodies: list[BodyInertia] = []
        for name, value in zip(self.parameters, parameters, strict=True):
            if name == PAYLOAD:
                step, _, lever = self.tool_frame
                points.append(PointMass(step, value, lever))
            else:
                bodies.append(self._body(name, value))
        rotors = self.physics.rotors({})
        return TreePose(self.tree, q, Arguments(bodies=tuple(bodies), points=tuple(points), rotors=rotors))

    @once
    def physics(self) -> TreePhysics:
        """What its joints and cuts do by themselves."""
        return TreePhysics(self.tree, self.model, self.chain.description)

    @once
    def tool_frame(self) -> tuple[int, vectors.Matrix, vectors.Vector]:
        """Step, rotation and lever of the tool."""
        tool = self.chain.description.tool
        assert tool is not None, "see `lacks`"
        return self.tree.frame(*bind_frame(self.model, tool))

    def frame(self, link: str) -> pin.Frame:
        """Where a link is in the model."""
        return self.model.frames[self.model.getFrameId(link, pin.FrameType.BODY)]

    def _body(self, name: str, mass: Number) -> BodyInertia:
        """A link whose mass is an argument."""
        inertial = self.chain.description.link(name).inertial
        assert inertial is not None
        frame = self.frame(name)
        rotation, at = np.asarray(frame.placement.rotation), np.asarray(frame.placement.translation)
        centre = rotation @ inertial.com + at
        inertia = rotation @ inertial.inertia @ rotation.T / inertial.mass
        inertia = inertia + centre @ centre * np.eye(3) - np.outer(centre, centre)
        return self.tree.scaled_body(frame.parentJoint, mass, centre, inertia)

    def nominal(self, parameter: str) -> float:
        """The chain's own value of an inertial parameter [kg]."""
        inertial = None if parameter == PAYLOAD else self.chain.description.link(parameter).inertial
        return 0.0 if inertial is None else float(inertial.mass)

    @once
    def position_scale(self) -> Array:
        """Robot's length for configuration coordinates that are lengths, 1 for the others, shape (nq,)."""
        scale = np.ones(self.positions)
        for step in self.tree.steps[1:]:
            scale[step.q : step.q + step.kind.lengths] = self.chain.length
        return readonly(scale)


# long: a property a part of the plan
class ChainPlan(ChainTree):
    """A chain's tree and loops, with what is decided of them."""

    @once
    def closure(self) -> Closure:
        """The loops of the local model."""
        return Closure(self.model, self.chain.description)

    @once
    def loops(self) -> Loops:
        """Its cuts and couplings."""
        return Loops(self.tree, self.closure.cuts, self.closure.couplings)

    @property
    def row_scale(self) -> Array:
        """Factor per row of the constraints that makes it dimensionless, shape (rows,)."""
        return np.where(self.closure.is_length, 1.0 / self.chain.length, 1.0)

    def scaled_jacobian(self, q: Array) -> Array:
        """Dimensionless constraint Jacobian in numbers, by the chain itself, shape (rows, nv)."""
        given = np.reshape(self.chain.constraint_jacobian(q), (self.rows, self.nv))
        return np.asarray(self.row_scale[:, None] * given * self.rate_scale)

    @property
    def rows(self) -> int:
        """Number of equations of the loops."""
        return self.closure.rows

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
        at_home = self._idle_at(self.chain.home.q_full)
        if at_home is not None or not self.loops.count:
            return at_home
        try:
            cloud = self.cloud
        except CompileError:
            return None
        moved = not np.array_equal(cloud[0], self.chain.home.q_full)
        return self._idle_at(cloud[0]) if moved else None

    def _idle_at(self, q: Array) -> int | None:
        report = self.chain.mobility(self.chain.posture(q))
        return report.idle_mobility if report.determined else None

    @property
    def weightless(self) -> bool:
        """Whether some idle freedoms move no mass: which force moves them how, the joints' masses do not say."""
        return bool(self.idle) and self.plan.idle is not None and bool(self.plan.idle.weightless)

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
            if len(best) > 1 and self._idle_at(best[0]) is not None:
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

    @once
    def led_plan(self) -> Plan:
        """Order of elimination of loops and task together, for `LedLoops`; the idle freedoms remain.

        Raises:
            CompileError: none is good around home.
        """
        survey = self.led_survey
        idle = self.plan.independent[self.chain.n :]
        plan = choose(survey, survey.regular(self.cloud, idle), idle)
        if plan.independent != idle:
            raise CompileError(f"no fixed order of elimination leads the task of {self.name} around its home posture")
        return plan

    @once
    def led_survey(self) -> Survey:
        """Loops and task in numbers, at the tool's own pose."""
        lengths = [row < 3 for row in self.chain.task.rows]
        scale = np.concatenate([self.row_scale, np.where(lengths, 1.0 / self.chain.length, 1.0)])
        return Survey(self.tree, LedLoops(self.loops, self.tool_frame, self.chain.task), scale, self.rate_scale)

    def _with_idle(self, plan: Plan) -> Plan:
        """A plan with what the cloud tells of its idle freedoms."""
        jacobians = np.array([self._survey.system(q)[0] for q in self.cloud])
        moves = supports(jacobians, plan, self.chain.n)
        rough = replace(plan, idle=Idle(moves, (), (), ()))
        graph = Graph()
        q = graph.symbols(self.positions)
        pose = self.pose(q, [self.nominal(name) for name in self.parameters])
        reduction = Reduction(pose, self.loops, rough)
        masses = idle_masses(pose, reduction, graph, q, self.rate_scale, self.cloud)
        return replace(plan, idle=weighed(masses, moves))

    @once
    def _survey(self) -> Survey:
        self.need_all_rows()
        return Survey(self.tree, self.loops, self.row_scale, self.rate_scale)

    def need_all_rows(self) -> None:
        """Check that there is something to compile.

        Raises:
            CompileError: nothing moves, or the loops close only without some of their rows.
        """
        if self.nv == 0:
            raise CompileError(f"{self.name} has no joint that moves: there is nothing to compile")
        if len(self.chain.constraint_jacobian(self.chain.home)) != self.rows:
            raise CompileError(
                f"{self.name} cannot be compiled: its loops close only when some of their rows are left out, and what "
                "those are open by differs from posture to posture. Give its frames more digits"
            )
