"""Robots with idle freedoms in actuated coordinates: the idle rates are carried along, no actuator drives them.

An idle freedom is a motion with all actuators locked that leaves the tool where it is, such as the spin of a rod
between two balls.  With T the tangent of the actuated rates, U that of the idle ones and M the mass matrix of the tree,

    T~ = T - U (U' M U)^+ U' M T

is the motion of the actuators that gives the idle freedoms no momentum; of all motions with the same actuated rates it
has the least kinetic energy (Kelvin).  Since U' M T~ = 0, neither mass, Coriolis vector nor gravity in actuated
coordinates depends on how the idle freedoms accelerate.  Where that is asked, no force drives them: U' (M a + h) = 0.

An idle freedom may move no mass (a rod without inertia about its axis).  Which ones do is found on the cloud; U' M U is
then eliminated for the others only, and what is left of the weightless ones is the least motion instead
(`cutjoint.compile.equations.weightless`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.equations.cloud import run
from cutjoint.compile.equations.dynamics import Motion, inertia_between
from cutjoint.compile.equations.elimination_order import Idle, Plan
from cutjoint.compile.equations.reduction import MassFactor, Reduction
from cutjoint.compile.equations.weightless import Least, Order, combined
from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.expressions.straight_line import assemble

NO_MASS = 1e-12
"""An idle freedom whose inertia is below this part of that of the joints it moves, about any axis, moves no mass."""
NOTHING = 1e-20
"""Inertia below this part of the robot's largest is none."""
RESTS = 1e-9
"""Dimensionless rates below this on the whole cloud are none."""


def supports(jacobians: Array, plan: Plan, n: int) -> tuple[frozenset[int], ...]:
    """Of every independent rate after the first `n`, the rates that it moves.

    Args:
        jacobians: dimensionless, on the whole cloud, shape (postures, rows, nv).
        plan: the elimination.
    """
    rows = [row for row, _ in plan.pivots]
    dependent = [rate for _, rate in plan.pivots]
    idle = list(plan.independent[n:])
    square = jacobians[:, rows][:, :, dependent]
    moved = np.abs(np.linalg.solve(square, jacobians[:, rows][:, :, idle])).max(axis=0, initial=0.0)
    return tuple(
        frozenset({rate, *(dependent[i] for i in np.flatnonzero(moved[:, k] > RESTS).tolist())})
        for k, rate in enumerate(idle)
    )


def weighed(masses: Sequence[tuple[Array, Array]]) -> tuple[Order, tuple[float, ...]]:
    """In which order to eliminate the mass matrix of some freedoms, which of them have none, and usual pivots.

    Args:
        masses: of every posture of the cloud, U' M U (k, k) and what the joints that each freedom moves weigh, (k,).
    """
    work, alone = (np.array(parts) for parts in zip(*masses, strict=True))
    left, heavy, sizes = list(range(work.shape[1])), [], []
    while left:
        diagonal, own = work[:, left, left], alone[:, left]
        share = np.divide(diagonal, own, out=np.zeros_like(diagonal), where=own > 0.0).min(axis=0)
        best = int(np.argmax(share))
        if share[best] <= NO_MASS:
            break
        pick = left.pop(best)
        heavy.append(pick)
        sizes.append(float(np.median(work[:, pick, pick])))
        factor = work[:, :, pick] / work[:, pick, pick][:, None]
        work = work - factor[:, :, None] * work[:, pick][:, None, :]
    return Order(tuple(heavy), tuple(left)), tuple(sizes)


def masses_of(
    reduction: Reduction, count: int, graph: Graph, q: Sequence[Expression], scale: Array, cloud: Array
) -> list[tuple[Array, Array]]:
    """What `weighed` asks of the last `count` independent rates, from the expressions, on every posture of a cloud;
    `scale` makes rates dimensionless."""
    pose = reduction.pose
    nv = pose.tree.nv
    columns = [[row[k] for row in reduction.tangent] for k in range(reduction.n - count, reduction.n)]
    mass = inertia_between(pose, columns)
    units = [[1.0 if i == rate else 0.0 for i in range(nv)] for rate in range(nv)]
    own = [inertia_between(pose, [unit])[0][0] for unit in units]
    results = {"mass": [x for row in mass for x in row], "idle": [x for column in columns for x in column], "own": own}
    program = assemble(graph, "idle", {"q": q}, results)
    groups = [list(range(step.u, step.u + step.kind.rates)) for step in pose.tree.steps[1:]]
    found = []
    for one in cloud:
        values = run(program, one)
        square = values[: count * count].reshape(count, count)
        motions = values[count * count : -nv].reshape(count, nv) / scale
        found.append((square, joint_inertia(motions, values[-nv:] * scale**2, groups)))
    return found


def joint_inertia(motions: Array, own: Array, joints: Sequence[Sequence[int]]) -> Array:
    """What the joints that dimensionless motions (k, nv) move weigh, about whichever of their axes weighs most, (k,).

    Args:
        own: of every dimensionless rate alone, shape (nv,).
        joints: rates of every joint.
    """
    heaviest = np.zeros(len(own))
    for rates in joints:
        heaviest[list(rates)] = own[list(rates)].max(initial=0.0)
    return np.asarray(motions**2 @ (heaviest + NOTHING / NO_MASS * own.max(initial=0.0)))


class Carried(Reduction):
    """A reduction whose last rates are idle, in its first `n` rates alone.

    Attributes:
        whole: the reduction in all independent rates.
    """

    def __init__(self, whole: Reduction, idle: Idle, scale: Array) -> None:
        self.__dict__.update(whole.__dict__)
        self.whole, self.idle = whole, idle
        self.n = n = whole.n - len(idle.support)
        columns = [[row[k] for row in whole.tangent] for k in range(whole.n)]
        driven, self._idle = columns[:n], columns[n:]
        heavy = [self._idle[k] for k in idle.heavy]
        mass = inertia_between(self.pose, [*heavy, *driven])
        count = len(heavy)
        self._factor_heavy = MassFactor([row[:count] for row in mass[:count]], self.strain, idle.sizes)
        self.strain = self._factor_heavy.strain
        light = [self._without_momentum(self._idle[k], self._momentum(self._idle[k])) for k in idle.weightless]
        self._least = Least(light, scale, self.strain)
        self.strain = self._least.strain
        settled = [
            self._least.of(self._without_momentum(column, [mass[i][count + k] for i in range(count)]))
            for k, column in enumerate(driven)
        ]
        self.tangent = [[column[i] for column in settled] for i in range(self.pose.tree.nv)]

    def _momentum(self, column: Sequence[Number]) -> list[Number]:
        """Momentum that a motion gives the heavy idle freedoms."""
        motions = [*(self._idle[k] for k in self.idle.heavy), column]
        return [row[-1] for row in inertia_between(self.pose, motions)[:-1]]

    def _without_momentum(self, column: Sequence[Number], momentum: Sequence[Number]) -> list[Number]:
        """A motion and as much of the heavy idle ones as cancels the momentum."""
        shares = self._factor_heavy.solve([-x for x in momentum])
        return combined(column, [self._idle[k] for k in self.idle.heavy], shares)

    def undriven(
        self,
        u: Sequence[Number],
        motion: Motion,
        drift: Sequence[Number],
        offset: Sequence[Number],
        passive: Sequence[Number],
    ) -> list[Number]:
        """Derivatives of the rates at constant actuated rates, where no motor drives the idle freedoms.

        Args:
            u, motion: rates and velocities.
            drift: some derivatives that the loops allow.
            offset: what the dimensionless accelerations are beside the derivatives of the rates.
            passive: forces that overcome springs and friction, (nv,).
        """
        held = self.whole.reduced(passive)
        forces = [x + y for x, y in zip(self.whole.effort(u, motion, drift), held, strict=True)][self.n :]
        pushed = self._without_momentum(drift, [forces[k] for k in self.idle.heavy])
        return self._least.of(pushed, offset)

    def correction(self, change: Sequence[Number]) -> list[Number]:
        """Newton's step with the idle rates held, length nv."""
        return super().correction([*change, *[0.0] * len(self.idle.support)])
