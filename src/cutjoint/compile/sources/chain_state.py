"""One state of a closed chain in expressions: what its tree and loops say there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from cutjoint import tolerances
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
from cutjoint.compile.equations.elimination import Elimination
from cutjoint.compile.equations.led import Led, LedLoops
from cutjoint.compile.equations.reduction import MassFactor, Reduction
from cutjoint.compile.equations.weightless import WholeMotion
from cutjoint.compile.expressions import functions, vectors
from cutjoint.compile.expressions.derivative import tangent as along
from cutjoint.compile.expressions.functions import absolute, maximum
from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.sources.chain_plan import ChainPlan
from cutjoint.compile.sources.interface import TracedTool


class TracedStep(NamedTuple):
    """A step of Newton's method on loops and task.

    Attributes:
        q_next: the position variables after it.
        residual: what the loops are open by before it, at most, [m] and [rad].
        led: the task before it.
        size: largest change of a position variable, dimensionless.
        gap: what is left before it at most, of loops and task, dimensionless.
        determinant, strain: of the elimination.
    """

    q_next: list[Number]
    residual: list[Number]
    led: Led
    size: Number
    gap: Number
    determinant: Number
    strain: Number


# long: a method a quantity that a traced state gives
class ChainState:
    """A `TracedState` of a closed chain, and what only chains have."""

    def __init__(
        self, source: ChainPlan, graph: Graph, q: Sequence[Expression], parameters: Sequence[Expression]
    ) -> None:
        self.source, self.graph, self.q, self.parameters = source, graph, list(q), list(parameters)
        self.pose = pose = source.pose(q, parameters)
        self.whole = Reduction(pose, source.loops, source.plan)
        idle = source.plan.idle
        self.reduction = self.whole if idle is None else Carried(self.whole, idle, source.rate_scale)
        self.physics = source.physics.at(pose)
        self.strain: Number = self.reduction.strain
        if self.physics.acting:
            self.strain = maximum(self.strain, self.physics.strain)

    @property
    def actuated(self) -> list[Number]:
        return [self.q[i] for i in self.source.actuated]

    def position_rate(self, v: Sequence[Number]) -> list[Number]:
        return configuration_rate(self.pose, self.reduction.rates(v))

    def full_velocity(self, v: Sequence[Number]) -> list[Number]:
        return from_rates(self.pose, self.reduction.rates(v))

    def mass(self) -> list[list[Number]]:
        return self.reduction.mass()

    def gravity(self) -> list[Number]:
        return self.reduction.gravity()

    def coriolis(self, v: Sequence[Number]) -> list[Number]:
        u, motion, drift = self.moving(v)
        return self.reduction.effort(u, motion, drift, weight=False)

    def springs(self) -> list[Number]:
        return self.reduction.reduced(self.physics.springs())

    def friction(self, v: Sequence[Number]) -> list[Number]:
        return self.reduction.reduced(self.physics.friction(self.reduction.rates(v)))

    def bias(self, v: Sequence[Number]) -> list[Number]:
        u, motion, drift = self.moving(v)
        return self._with_passive(self.reduction.effort(u, motion, drift), u)

    def inverse(self, v: Sequence[Number], a: Sequence[Number]) -> list[Number]:
        u, motion, drift = self.moving(v)
        du = [x + y for x, y in zip(self.reduction.rates(a), drift, strict=True)]
        return self._with_passive(self.reduction.effort(u, motion, du), u)

    def _passive(self, u: list[Number]) -> list[Number]:
        """Effort along the rates of the tree that overcomes springs and friction."""
        return [x + y for x, y in zip(self.physics.springs(), self.physics.friction(u), strict=True)]

    def _with_passive(self, effort: Sequence[Number], u: list[Number]) -> list[Number]:
        """An effort in the independent rates, and what springs and friction need there."""
        return [x + y for x, y in zip(effort, self.reduction.reduced(self._passive(u)), strict=True)]

    def moving(self, v: Sequence[Number]) -> tuple[list[Number], Motion, list[Number]]:
        """Rates, velocities and drift."""
        u = self.reduction.rates(v)
        motion = velocities(self.pose, u)
        return u, motion, self.reduction.drift(u, motion)

    def potential(self) -> Number:
        return potential_energy(self.pose, self.source.origin) + self.physics.potential()

    def tool(self, v: Sequence[Number]) -> TracedTool:
        step, own, lever = self.pose.frame("tool", self.source.tool_frame)
        arm = self.pose.lever(step, lever)
        position = vectors.add(self.source.origin, vectors.add(self.pose.origin(step), arm))
        rotation = vectors.product(self.pose.rotation[step], own)
        tangent = self.reduction.tangent
        jacobian: list[list[Number]] = [[0.0] * self.reduction.n for _ in range(6)]
        for rate, velocity, angular in self.pose.columns(step, lever):
            for row, value in zip(jacobian, (*velocity, *angular), strict=True):
                for k in range(self.reduction.n):
                    row[k] = row[k] + value * tangent[rate][k]
        u, motion, drift = self.moving(v)
        bias = accelerations(self.pose, u, motion, drift)
        w = motion.angular[step]
        pull = vectors.add(bias.at(step, arm), vectors.cross(w, vectors.cross(w, arm)))
        twist = [*motion.at(step, arm), *w]
        return TracedTool(
            list(position), [list(row) for row in rotation], jacobian, [*pull, *bias.angular[step]], twist
        )

    def settled(self, target: Sequence[Number] | None) -> tuple[list[Number], list[Number]]:
        """See `TracedState`; with a target the independent coordinates must be turns and slides."""
        change: list[Number] = [0.0] * self.reduction.n
        if target is not None:
            change = [x - y for x, y in zip(target, self.actuated, strict=True)]
        return moved(self.pose, self.reduction.correction(change)), self.reduction.residuals

    def directions_of_parameters(self) -> list[dict[int, Number]]:
        """Seeds that move along each parameter: the loops stay closed, actuators and idle rates are held."""
        found = []
        for parameter in self.parameters:
            seed: dict[int, Number] = {abs(parameter.ref): 1.0}
            u = self.whole.held_closed(along(self.graph, self.whole.residuals, seed))
            rate = configuration_rate(self.pose, u)
            found.append(seed | {abs(x.ref): dx for x, dx in zip(self.q, rate, strict=True)})
        return found

    def towards(self, goal: Sequence[Number]) -> TracedStep:
        """One Newton step to closed loops and the tool at `goal` (place (3) in the model, rotation (9)), the idle rates
        held."""
        source, length = self.source, self.source.chain.length
        loops = LedLoops(source.loops, source.tool_frame, source.chain.task, goal)
        led, rows = loops.led(self.pose), source.loops.rows(self.pose)
        elimination = Elimination([*rows, *led.rows], source.led_plan, source.nv)
        q_next = moved(self.pose, elimination.correction([0.0] * len(source.led_plan.independent)))
        lengths = _largest(row.residual for row in rows if row.is_length)
        angles = _largest(row.residual for row in rows if not row.is_length)
        far = _largest(x for x, row in zip(led.missed, led.rows, strict=True) if row.is_length)
        turned = _largest(x for x, row in zip(led.missed, led.rows, strict=True) if not row.is_length)
        return TracedStep(
            q_next,
            [lengths, angles],
            led,
            _largest((x - y) / float(one) for x, y, one in zip(q_next, self.q, source.position_scale, strict=True)),
            _largest([maximum(lengths, far) / length, angles, turned]),
            elimination.determinant,
            maximum(elimination.strain, led.strain),
        )

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
            turned = turning_axes(self.pose, u, motion)
            drift = self.reduction.undriven(u, motion, drift, turned, self._passive(u))
        return from_rate_derivatives(self.pose, u, motion, drift)

    def full_rate(self, v_full: Sequence[Number]) -> list[Number]:
        """Rates of the position variables."""
        return configuration_rate(self.pose, to_rates(self.pose, v_full))

    def full_dissipation(self, v_full: Sequence[Number]) -> Number:
        """Power that dampers and friction take."""
        u = to_rates(self.pose, v_full)
        return vectors.dot(self.physics.friction(u), u)

    def full_forward(self, v_full: Sequence[Number], effort_full: Sequence[Number]) -> tuple[list[Number], Number]:
        """Acceleration of all joints for a velocity that respects the loops and forces on all joints; and the
        strain."""
        u = to_rates(self.pose, v_full)
        motion = velocities(self.pose, u)
        whole, order = self.whole, self.source.order
        drift = whole.drift(u, motion)
        acting = to_rates(self.pose, effort_full), whole.forces(u, motion, drift), self._passive(u)
        forces = [push - held - rest for push, held, rest in zip(*acting, strict=True)]
        if order.light:
            solved = WholeMotion(whole, order, self.source.rate_scale)
            du = solved.accelerations(drift, forces, turning_axes(self.pose, u, motion))
            terms: list[Number] = [sum(map(absolute, some), 0.0) for some in zip(*acting, strict=True)]
            strain = maximum(solved.strain, solved.pushed(forces, terms, self._rounding(u, terms)))
            return from_rate_derivatives(self.pose, u, motion, du), strain
        factor = MassFactor(whole.mass(), whole.strain)
        a = factor.solve(whole.reduced(forces))
        du = [x + y for x, y in zip(whole.rates(a), drift, strict=True)]
        return from_rate_derivatives(self.pose, u, motion, du), factor.strain

    def _rounding(self, u: Sequence[Number], terms: Sequence[Number]) -> Number:
        """What rounding leaves of forces along rates, as an energy [J]: of the forces, the weight and the motion."""
        length, scale = self.source.chain.length, self.source.rate_scale.tolist()
        fast = vectors.dot(*[[x / one for x, one in zip(u, scale, strict=True)]] * 2)
        energy = self.pose.mass * length * (length * fast + functions.sqrt(vectors.dot(*[self.pose.gravity] * 2)))
        return tolerances.ROUNDED.value * (energy + vectors.dot(terms, scale))


def _largest(values: Iterable[Number]) -> Number:
    """Largest size among values; 0 where there are none."""
    largest: Number = 0.0
    for value in values:
        largest = maximum(largest, absolute(value))
    return largest
