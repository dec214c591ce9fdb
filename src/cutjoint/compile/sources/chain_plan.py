"""What is decided once and for all of a closed chain before it is traced, on a cloud of postures around home.

Which freedoms are idle, which postures are regular, and in which order to eliminate.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.closure import Closure
from cutjoint.chain.rank import null_space
from cutjoint.compile.equations.carried import idle_masses, supports, weighed
from cutjoint.compile.equations.cloud import Survey
from cutjoint.compile.equations.cut_rows import Loops
from cutjoint.compile.equations.elimination_order import Idle, Plan, choose
from cutjoint.compile.equations.reduction import Reduction
from cutjoint.compile.expressions.graph import Graph
from cutjoint.compile.once import once
from cutjoint.compile.sources.chain_tree import ChainTree
from cutjoint.errors import CompileError, CutjointError
from cutjoint.mechanism import Posture

STARTS = 12
"""How often a regular posture is looked for around a singular home."""


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
        if len(self.chain.constraint_jacobian(self.chain.home.q_full)) != self.rows:
            raise CompileError(
                f"{self.name} cannot be compiled: its loops close only when some of their rows are left out, and what "
                "those are open by differs from posture to posture. Give its frames more digits"
            )
