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
from cutjoint.compile.equations.inertia import PointMass
from cutjoint.compile.equations.led import LedLoops
from cutjoint.compile.equations.physics import TreePhysics
from cutjoint.compile.equations.pose import Arguments, TreePose
from cutjoint.compile.equations.reduction import Reduction
from cutjoint.compile.equations.tree import JointTree
from cutjoint.compile.expressions import vectors
from cutjoint.compile.expressions.graph import Graph, Number
from cutjoint.compile.once import once
from cutjoint.compile.sources.interface import PAYLOAD
from cutjoint.compile.sources.parameters import Parameters, Ranges, RobotScale
from cutjoint.compile.sources.varied import Varied
from cutjoint.description.paths import PLACE
from cutjoint.errors import CompileError, CutjointError

STARTS = 12
"""How often a regular posture is looked for around a singular home."""


class ChainTree:
    """The tree of a chain; its local model stands near its origin, however far away its base is.

    Args:
        chain: any closed chain.
        parameters, ranges: see `ChainSource`.

    Attributes:
        origin: where the local model stands (3,) [m]; it is added to tool positions and to the height of the masses,
            not carried through the arithmetic.
        positions, nv: sizes of configuration and velocity.
        rate_scale: factor per rate that makes it dimensionless, shape (nv,).
        actuated, actuated_rates: where the actuated coordinates stand in them.
        arguments: what stays an argument of the compiled functions; `parameters` are their names.
        nominal, low, high: the chain's own values of them, and the range that they are compiled for, (parameters,).
        varied: what of the tree they touch.
    """

    def __init__(self, chain: ClosedChain, parameters: Sequence[str] = (), ranges: Ranges | None = None) -> None:
        self.chain = chain
        self._lock = threading.RLock()
        self.model: pin.Model = chain.local_model
        self.origin = vectors.constant_vector(chain.origin)
        self.name = chain.name
        self.positions, self.nv = chain.nq, chain.nv
        self.rate_scale = velocity_scale(self.model, chain.length)
        self.actuated = tuple(int(i) for i in chain.actuated(np.arange(float(chain.nq))))
        self.actuated_rates = tuple(int(i) for i in chain.actuated_velocity(np.arange(float(chain.nv))))
        self.arguments = Parameters(chain.description, parameters)
        self.parameters, self.nominal = self.arguments.names, self.arguments.nominal
        self.low, self.high = self.arguments.bounds(ranges or {}, self.scale)
        self.varied = Varied(self.model, self.arguments)

    @property
    def placing(self) -> list[int]:
        """Which parameters are places of joints and cuts, or couplings."""
        return [self.parameters.index(name) for name in self.arguments.placing]

    def displaced(self, values: Array) -> bool:
        """Whether such a parameter differs from the chain's own, at values of all, shape (parameters,) or (N,
        parameters)."""
        return bool((values[..., self.placing] != self.nominal[self.placing]).any())

    def keeps_task(self, values: Array) -> bool:
        """Whether the task is the chain's own at values of the parameters, shape (parameters,) or (N, parameters): some
        rotations alone are led from how the tool is at home, which may depend on them."""
        turning = {f"tool.{angle}" for angle in PLACE[3:]}
        tool = [k for k, name in enumerate(self.parameters) if name in turning]
        moved = self.displaced(values) or bool((values[..., tool] != self.nominal[tool]).any())
        return not moved or sum(row >= 3 for row in self.chain.task.rows) in (0, 3)

    @property
    def scale(self) -> RobotScale:
        """How heavy, large and quick the robot is."""
        mass = sum(float(inertia.mass) for inertia in list(self.model.inertias)[1:])
        gravity = float(np.linalg.norm(self.model.gravity.linear))
        return RobotScale(mass, self.chain.length, float(np.sqrt(self.chain.length / gravity)) if gravity else 1.0)

    @once
    def tree(self) -> JointTree:
        """The tree without the links whose inertias are expressions."""
        apart = self.varied.links
        return JointTree(self._without(apart) if apart else self.model, self.varied.loose)

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
        """The tree at the configuration `q`, with the values of the parameters."""
        if not self.parameters:
            return TreePose(self.tree, q, Arguments(rotors=self.physics.rotors({})))
        values, tree, varied = dict(zip(self.parameters, parameters, strict=True)), self.tree, self.varied
        numbers = self.arguments.numbers(values)
        frames = varied.frames(tree, numbers)
        bodies = tuple(varied.body(tree, name, numbers, values.get(name)) for name in varied.links)
        points: tuple[PointMass, ...] = ()
        if PAYLOAD in values:
            step, _, lever = frames.get("tool", self.tool_frame)
            points = (PointMass(step, values[PAYLOAD], lever),)
        placed, rotors = varied.placed(tree, numbers), self.physics.rotors(numbers)
        return TreePose(tree, q, Arguments(numbers, bodies, points, placed, frames, rotors))

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

    @once
    def limits(self) -> tuple[Array, Array]:
        """Least and largest value of every configuration coordinate, shape (nq,) each; infinite for what has none."""
        single = np.zeros(self.positions, dtype=bool)
        single[[int(self.model.idx_qs[i]) for i in range(1, self.model.njoints) if self.model.nqs[i] == 1]] = True
        lower, upper = self.model.lowerPositionLimit, self.model.upperPositionLimit
        return readonly(np.where(single, lower, -np.inf)), readonly(np.where(single, upper, np.inf))

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
        found = survey.regular(self._cloud_around(home), self.actuated_rates)
        stuck = len(found) < 2 and null_space(survey.system(self._whole(home))[0]).shape[1] > 0
        if len(found) and np.array_equal(found[0], self._whole(home)) and not stuck:
            return found[:, : self.positions]
        # home is singular: branches meet there, and a walk along the tangent need not lead onto the one that is meant
        chance, best = np.random.default_rng(0), found[:, : self.positions]
        for attempt in range(STARTS):
            if len(best) > 1 and self._idle_at(best[0]) is not None:
                break
            step = (1.0 + attempt) / STARTS * chance.normal(size=self.nv)
            aside = survey.moved(self._whole(home), step)[: self.positions]
            try:
                start = np.array(self.chain.assemble(aside, keep_actuators=False).q_full)
            except CutjointError:
                continue
            around = survey.regular(self._cloud_around(start), self.actuated_rates)
            best = around[:, : self.positions] if len(around) > 1 else best
        if len(best) < 2:
            raise CompileError(
                f"{self.name} cannot be compiled: it is singular at home, or cannot move there, and no posture around "
                "home was found that is not; choose another home"
            )
        return best

    def _cloud_around(self, q: Array) -> Array:
        return self._survey.cloud(self._whole(q))

    def _whole(self, q: Array) -> Array:
        """A configuration as a survey has it, the parameters as the description has them."""
        return np.concatenate([q, self.nominal])

    @once
    def wide_cloud(self) -> Array:
        """The cloud with the parameters behind each configuration, and the same closed at others of their range, shape
        (k, nq + parameters).

        Raises:
            CompileError: the loops do not close at other values of the parameters.
        """
        own = np.array([self._whole(q) for q in self.cloud])
        if not self.parameters:
            return own
        survey, chance = self._survey, np.random.default_rng(1)
        found = [one for x in own if (one := survey.at_values(x, self._drawn(chance))) is not None]
        if 2 * len(found) < len(own):
            raise CompileError(
                f"the loops of {self.name} close at {len(found)} of {len(own)} random values of its parameters"
                f"{self._culprits(own[0])}. Give ranges that it can be built with, leave out what its loops fix, or "
                "join what they keep equal ('PATH = PATH')"
            )
        return survey.regular(np.concatenate([own, found]), self.actuated_rates)

    def _drawn(self, chance: np.random.Generator) -> Array:
        """Random values of the parameters: within their ranges, and half of them at an end."""
        share = chance.uniform(size=len(self.parameters))
        share = np.where(chance.uniform(size=len(share)) < 0.5, np.round(share), share)
        return np.asarray(self.low + share * (self.high - self.low))

    def _culprits(self, x: Array) -> str:
        """Which parameters alone keep the loops open, in words."""
        open_at: list[str] = []
        for name in self.arguments.placing:
            k = self.parameters.index(name)
            ends = [np.where(np.arange(len(self.nominal)) == k, end, self.nominal) for end in (self.low, self.high)]
            if all(self._survey.at_values(x, values) is None for values in ends):
                open_at.append(name)
        return f"; they stay open for any change of {', '.join(open_at)} alone" if open_at else ""

    @once
    def plan(self) -> Plan:
        """Order of elimination.

        Raises:
            CompileError: none is good around home.
        """
        plan = choose(self._survey, self.wide_cloud, self.actuated_rates)
        if self.idle is None:
            return plan
        n = self.n
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
        plan = choose(survey, survey.regular(self.wide_cloud, idle), idle)
        if plan.independent != idle:
            raise CompileError(f"no fixed order of elimination leads the task of {self.name} around its home posture")
        return plan

    @once
    def led_survey(self) -> Survey:
        """Loops and task in numbers, at the tool's own pose."""
        lengths = [row < 3 for row in self.chain.task.rows]
        scale = np.concatenate([self.row_scale, np.where(lengths, 1.0 / self.chain.length, 1.0)])
        return Survey(self, LedLoops(self.loops, self.tool_frame, self.chain.task), scale, self.rate_scale)

    def _with_idle(self, plan: Plan) -> Plan:
        """A plan with what the cloud tells of its idle freedoms."""
        jacobians = np.array([self._survey.system(x)[0] for x in self.wide_cloud])
        moves = supports(jacobians, plan, self.n)
        rough = replace(plan, idle=Idle(moves, (), (), ()))
        graph = Graph()
        q, p = graph.symbols(self.positions), graph.symbols(len(self.parameters))
        pose = self.pose(q, p)
        reduction = Reduction(pose, self.loops, rough)
        masses = idle_masses(pose, reduction, graph, [*q, *p], self.rate_scale, self.wide_cloud)
        return replace(plan, idle=weighed(masses, moves))

    @once
    def _survey(self) -> Survey:
        self.need_all_rows()
        return Survey(self, self.loops, self.row_scale, self.rate_scale)

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
