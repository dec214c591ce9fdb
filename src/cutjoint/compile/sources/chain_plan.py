"""What is decided of a closed chain once and for all, on a cloud of postures around home.

Which freedoms are idle, which postures are regular, and in which order to eliminate.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.closure import Closure
from cutjoint.chain.dynamics import Motions
from cutjoint.chain.rank import null_space
from cutjoint.chain.tree import TreeModel
from cutjoint.compile.equations.carried import masses_of, supports, weighed
from cutjoint.compile.equations.cloud import Survey
from cutjoint.compile.equations.cut_rows import Loops
from cutjoint.compile.equations.elimination_order import Idle, Plan, choose
from cutjoint.compile.equations.led import LedLoops
from cutjoint.compile.equations.reduction import Reduction
from cutjoint.compile.equations.weightless import Order
from cutjoint.compile.expressions.graph import Graph
from cutjoint.compile.once import once
from cutjoint.compile.sources.chain_tree import ChainTree
from cutjoint.errors import CompileError, CutjointError

STARTS = 12
"""How often a regular posture is looked for around a singular home."""


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
            stuck = ", ".join(self.fixed_by_loops())
            raise CompileError(
                f"the loops of {self.name} close, and leave its freedoms, at {len(found)} of {len(own)} random values "
                f"of its parameters{f'; not for the whole range of {stuck} alone' if stuck else ''}. Give ranges that "
                "it can be built with, leave out what its loops fix, or join what they keep equal ('PATH = PATH')"
            )
        return survey.regular(np.concatenate([own, found]), self.actuated_rates)

    def _drawn(self, chance: np.random.Generator) -> Array:
        """Random values of the parameters: within their ranges, and half of them at an end."""
        share = chance.uniform(size=len(self.parameters))
        share = np.where(chance.uniform(size=len(share)) < 0.5, np.round(share), share)
        return np.asarray(self.low + share * (self.high - self.low))

    def fixed_by_loops(self) -> tuple[str, ...]:
        """Parameters that alone cannot go to both ends of their range around home: there the loops stay open, or take
        freedoms away."""
        survey, x = self._survey, self._whole(self.cloud[0])
        found: list[str] = []
        for k in self.placing:
            ends = [np.where(np.arange(len(self.nominal)) == k, end, self.nominal) for end in (self.low, self.high)]
            if any(survey.at_values(x, values) is None for values in ends):
                found.append(self.parameters[k])
        return tuple(found)

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
                f"too near to a singularity. Choose another home{' or other ranges' if self.parameters else ''}"
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
        order, sizes = weighed(self._masses(rough, len(moves)))
        return replace(plan, idle=Idle(moves, order.heavy, sizes, order.light))

    def _masses(self, plan: Plan, count: int) -> list[tuple[Array, Array]]:
        """What the last `count` independent rates move, on the cloud."""
        graph = Graph()
        q, p = graph.symbols(self.positions), graph.symbols(len(self.parameters))
        reduction = Reduction(self.pose(q, p), self.loops, plan)
        return masses_of(reduction, count, graph, [*q, *p], self.rate_scale, self.wide_cloud)

    @once
    def order(self) -> Order:
        """In which order to eliminate the mass matrix of all independent rates, and which of them move no mass."""
        plan, count = self.plan, len(self.plan.independent)
        every = tuple(range(count))
        if plan.idle is not None:
            heavy, light = (tuple(self.n + k for k in some) for some in (plan.idle.heavy, plan.idle.weightless))
            return Order((*range(self.n), *heavy), light)
        # only a tree some of whose motions move no mass can have loops that leave such motions
        if self.idle is not None or not self._massless_tree():
            return Order(every)
        found, _ = weighed(self._masses(plan, count))
        return found if found.light else Order(every)

    def _massless_tree(self) -> bool:
        """Whether some motion of the open tree moves no mass."""
        tree, scale, every = TreeModel(self.model), self.rate_scale, np.eye(self.nv)
        masses = (scale[:, None] * tree.mass_matrix(q) * scale for q in self.cloud[:2])
        return any(Motions.of(every, mass).massless.size for mass in masses)

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
