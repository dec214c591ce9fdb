"""A state of a closed chain as expressions: what `TracedState` asks, and what only chains have."""

from __future__ import annotations

from collections.abc import Sequence

from cutjoint.compile.equations.carried import Carried
from cutjoint.compile.equations.coordinates import (
    configuration_rate,
    from_rate_derivatives,
    from_rates,
    moved,
    to_rates,
    turning_axes,
)
from cutjoint.compile.equations.dynamics import Motion, accelerations, potential_energy, velocities
from cutjoint.compile.equations.pose import Pose
from cutjoint.compile.equations.reduction import MassFactor, Reduction
from cutjoint.compile.expressions import vectors
from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.sources.chain_plan import ChainPlan


class ChainState:
    """A `TracedState` of a closed chain."""

    def __init__(self, source: ChainPlan, graph: Graph, q: Sequence[Expression], pose: Pose) -> None:
        self.source, self.graph, self.q = source, graph, list(q)
        self.pose = pose
        self.whole = Reduction(pose, source.loops, source.plan)
        idle = source.plan.idle
        self.reduction = self.whole if idle is None else Carried(self.whole, idle, source.rate_scale)
        self.strain: Number = self.reduction.strain

    @property
    def actuated(self) -> list[Number]:
        return [self.q[i] for i in self.source.actuated]

    def position_rate(self, v: Sequence[Number]) -> list[Number]:
        return configuration_rate(self.pose, self.reduction.rates(v))

    def mass(self) -> list[list[Number]]:
        return self.reduction.mass()

    def gravity(self) -> list[Number]:
        return self.reduction.gravity()

    def coriolis(self, v: Sequence[Number]) -> list[Number]:
        u, motion, drift = self.moving(v)
        return self.reduction.effort(u, motion, drift, weight=False)

    def bias(self, v: Sequence[Number]) -> list[Number]:
        u, motion, drift = self.moving(v)
        return self.reduction.effort(u, motion, drift)

    def inverse(self, v: Sequence[Number], a: Sequence[Number]) -> list[Number]:
        u, motion, drift = self.moving(v)
        du = [x + y for x, y in zip(self.reduction.rates(a), drift, strict=True)]
        return self.reduction.effort(u, motion, du)

    def moving(self, v: Sequence[Number]) -> tuple[list[Number], Motion, list[Number]]:
        """Rates, velocities and drift."""
        u = self.reduction.rates(v)
        motion = velocities(self.pose, u)
        return u, motion, self.reduction.drift(u, motion)

    def potential(self) -> Number:
        return potential_energy(self.pose, self.source.origin)

    def tool(self, v: Sequence[Number]) -> tuple[list[Number], list[list[Number]], list[Number]]:
        step, lever = self.source.tool_point
        arm = self.pose.lever(step, lever)
        position = vectors.add(self.source.origin, vectors.add(self.pose.origin(step), arm))
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
        pull = vectors.add(bias.at(step, arm), vectors.cross(w, vectors.cross(w, arm)))
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
        if isinstance(self.reduction, Carried):
            drift = self.reduction.undriven(u, motion, drift, turning_axes(self.pose, u, motion))
        return from_rate_derivatives(self.pose, u, motion, drift)

    def full_forward(self, v_full: Sequence[Number], effort_full: Sequence[Number]) -> tuple[list[Number], Number]:
        """Acceleration of all joints for a velocity that respects the loops and forces on all joints; and the
        strain."""
        u = to_rates(self.pose, v_full)
        motion = velocities(self.pose, u)
        whole = self.whole
        drift = whole.drift(u, motion)
        push = whole.reduced(to_rates(self.pose, effort_full))
        held = whole.effort(u, motion, drift)
        factor = MassFactor(whole.mass(), whole.strain)
        a = factor.solve([x - y for x, y in zip(push, held, strict=True)])
        du = [x + y for x, y in zip(whole.rates(a), drift, strict=True)]
        return from_rate_derivatives(self.pose, u, motion, du), factor.strain
