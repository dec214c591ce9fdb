"""Robots with idle freedoms in actuated coordinates: the idle rates are carried along, no actuator drives them.

An idle freedom is a motion with all actuators locked that leaves the tool where it is, such as the spin of a rod
between two balls.  With T the tangent of the actuated rates, U that of the idle ones and M the mass matrix of the tree,

    T~ = T - U (U' M U)^+ U' M T

is the motion of the actuators that gives the idle freedoms no momentum; of all motions with the same actuated rates it
has the least kinetic energy (Kelvin).  Since U' M T~ = 0, neither mass, Coriolis vector nor gravity in actuated
coordinates depends on how the idle freedoms accelerate.  Where that is asked, no force drives them: U' (M a + h) = 0.

An idle freedom may move no mass (a rod without inertia about its axis).  Which ones do is found on the cloud; U' M U is
then eliminated for the others only, and what is left of the weightless ones is the least motion instead, in
dimensionless rates.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile import space
from cutjoint.compile.cloud import run
from cutjoint.compile.graph import Expression, Graph, Number, is_zero, maximum
from cutjoint.compile.pivots import Idle, Plan
from cutjoint.compile.program import assemble
from cutjoint.compile.reduction import MassFactor, Reduction
from cutjoint.compile.tree import Motion, Pose, mass_matrix, velocities

NO_MASS = 1e-12
"""An idle freedom whose inertia is below this part of that of the joints it moves, each alone, moves no mass."""
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


def weighed(trace: Sequence[Array], support: tuple[frozenset[int], ...]) -> Idle:
    """In which order to eliminate the mass matrix of the idle freedoms, and which of them have none.

    Args:
        trace: of every posture of the cloud, U' M U and below it one row of what each freedom's joints would weigh
            alone, shape (k + 1, k).
        support: rates that each freedom moves.
    """
    work = np.array([one[:-1] for one in trace])
    alone = np.array([one[-1] for one in trace])
    left, heavy, sizes = list(range(work.shape[1])), [], []
    while left:
        diagonal = work[:, left, left]
        share = np.divide(diagonal, alone[:, left], out=np.zeros_like(diagonal), where=alone[:, left] > 0.0).min(axis=0)
        best = int(np.argmax(share))
        if share[best] <= NO_MASS:
            break
        pick = left.pop(best)
        heavy.append(pick)
        sizes.append(float(np.median(work[:, pick, pick])))
        factor = work[:, :, pick] / work[:, pick, pick][:, None]
        work = work - factor[:, :, None] * work[:, pick][:, None, :]
    return Idle(support, tuple(heavy), tuple(sizes), tuple(left))


def idle_masses(pose: Pose, reduction: Reduction, graph: Graph, q: Sequence[Expression], n: int, cloud: Array) -> list[Array]:
    """What `weighed` asks, from the expressions, on every posture of a cloud."""
    nv = pose.tree.nv
    columns = [[row[k] for row in reduction.tangent] for k in range(n, reduction.n)]
    mass = mass_matrix(pose, [velocities(pose, column) for column in columns])
    moved = sorted({rate for column in columns for rate in range(nv) if not is_zero(column[rate])})
    units = [velocities(pose, [1.0 if i == rate else 0.0 for i in range(nv)]) for rate in moved]
    own = {rate: mass_matrix(pose, [unit])[0][0] for rate, unit in zip(moved, units, strict=True)}
    alone = [space.dot([x * x for x in column], [own.get(i, 0.0) for i in range(nv)]) for column in columns]
    program = assemble(graph, "idle", {"q": q}, {"mass": [x for row in [*mass, alone] for x in row]})
    return [run(program, one).reshape(len(columns) + 1, len(columns)) for one in cloud]


class Carried(Reduction):
    """A reduction whose last rates are idle, in its first `n` rates alone.

    Attributes:
        whole: the reduction in all independent rates.
    """

    def __init__(self, whole: Reduction, idle: Idle, scale: Sequence[float]) -> None:
        self.__dict__.update(whole.__dict__)
        self.whole, self.idle = whole, idle
        self.n = n = whole.n - len(idle.support)
        self._scale = [1.0 / (x * x) for x in scale]
        columns = [[row[k] for row in whole.tangent] for k in range(whole.n)]
        driven, self._idle = columns[:n], columns[n:]
        heavy = [self._idle[k] for k in idle.heavy]
        mass = mass_matrix(self.pose, [velocities(self.pose, column) for column in [*heavy, *driven]])
        count = len(heavy)
        self._factor_heavy = MassFactor([row[:count] for row in mass[:count]], self.strain, idle.sizes)
        self.strain = self._factor_heavy.strain
        self._light = [self._without_momentum(self._idle[k], self._momentum(self._idle[k])) for k in idle.weightless]
        gram = [[self._product(x, y) for y in self._light] for x in self._light]
        self._factor_light = MassFactor(gram, self.strain)
        self.strain = self._factor_light.strain
        settled = [
            self._least(self._without_momentum(column, [mass[i][count + k] for i in range(count)]))
            for k, column in enumerate(driven)
        ]
        self.tangent = [[column[i] for column in settled] for i in range(self.pose.tree.nv)]

    def _momentum(self, column: Sequence[Number]) -> list[Number]:
        """Momentum that a motion gives the heavy idle freedoms."""
        motions = [velocities(self.pose, one) for one in [*(self._idle[k] for k in self.idle.heavy), column]]
        return [row[-1] for row in mass_matrix(self.pose, motions)[:-1]]

    def _without_momentum(self, column: Sequence[Number], momentum: Sequence[Number]) -> list[Number]:
        """A motion and as much of the heavy idle ones as cancels the momentum."""
        shares = self._factor_heavy.solve([-x for x in momentum])
        return self._with(column, [self._idle[k] for k in self.idle.heavy], shares)

    def _least(self, column: Sequence[Number], offset: Sequence[Number] | None = None) -> list[Number]:
        """A motion and as much of the weightless ones as makes it, plus an offset, least in dimensionless rates."""
        size = column if offset is None else [x + y for x, y in zip(column, offset, strict=True)]
        shares = self._factor_light.solve([-self._product(one, size) for one in self._light])
        return self._with(column, self._light, shares)

    @staticmethod
    def _with(column: Sequence[Number], motions: Sequence[Sequence[Number]], shares: Sequence[Number]) -> list[Number]:
        total = list(column)
        for motion, share in zip(motions, shares, strict=True):
            total = [x if is_zero(y) else x + share * y for x, y in zip(total, motion, strict=True)]
        return total

    def _product(self, x: Sequence[Number], y: Sequence[Number]) -> Number:
        return space.dot([w * a for w, a in zip(self._scale, x, strict=True)], y)

    def undriven(self, u: Sequence[Number], motion: Motion, drift: Sequence[Number], offset: Sequence[Number]) -> list[Number]:
        """Derivatives of the rates at constant actuated rates, where no force drives the idle freedoms.

        Args:
            u, motion: rates and velocities.
            drift: some derivatives that the loops allow.
            offset: what the dimensionless accelerations are beside the derivatives of the rates.
        """
        forces = self.whole.effort(u, motion, drift)[self.n :]
        pushed = self._without_momentum(drift, [forces[k] for k in self.idle.heavy])
        return self._least(pushed, offset)

    def correction(self, change: Sequence[Number]) -> list[Number]:
        """Newton's step with the idle rates held, length nv."""
        return super().correction([*change, *[0.0] * len(self.idle.support)])
