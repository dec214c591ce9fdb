"""The closed robot in its independent rates, as expressions.

    u = T v                  rates of the tree from the n independent ones, by sparse elimination in a fixed order
    du = T a + s             their derivatives; s is what the loops demand at constant v
    M = T' M_tree T          from the kinetic energy of every body, and of the rotors, in the columns of T
    effort = T' f            f from recursive Newton-Euler on the tree, and the rotors

To the strain of the elimination comes that of the mass matrix, for the digits that are lost in it.
"""

from __future__ import annotations

from collections.abc import Sequence

from cutjoint.compile.equations.coordinates import turning_axes
from cutjoint.compile.equations.cut_rows import Loops
from cutjoint.compile.equations.dynamics import Motion, accelerations, generalised_forces, inertia_between, velocities
from cutjoint.compile.equations.elimination import Elimination
from cutjoint.compile.equations.elimination_order import Plan
from cutjoint.compile.equations.pose import TreePose
from cutjoint.compile.expressions.functions import absolute, is_zero, maximum
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import ZERO, dot, scale
from cutjoint.errors import CompileError

MASS_SHARE = 1e-3
"""Part of the strain that a loss of digits in the mass matrix counts."""


class Reduction(Elimination):
    """The dependent rates at a pose by the independent ones.

    Attributes:
        tangent: T, a list of rows, shape (nv, n).
    """

    def __init__(self, pose: TreePose, loops: Loops, plan: Plan) -> None:
        nv = pose.tree.nv
        super().__init__(loops.rows(pose), plan, nv)
        self.pose, self.loops, self.n = pose, loops, len(plan.independent)
        self.tangent: list[list[Number]] = [[0.0] * self.n for _ in range(nv)]
        support = () if plan.idle is None else plan.idle.support
        everywhere = frozenset(range(nv))
        moves = [*[everywhere] * (self.n - len(support)), *support]
        for k, rate in enumerate(plan.independent):
            self.tangent[rate][k] = 1.0
            right = [row.coefficients.get(rate, 0.0) for row in self._rows]
            for dependent, value in self._solve(right, moves[k]):
                self.tangent[dependent][k] = -value

    # -- kinematics --------------------------------------------------------------------------------------------------

    def rates(self, v: Sequence[Number]) -> list[Number]:
        """u = T v, length nv."""
        return [dot(row, v) for row in self.tangent]

    def drift(self, u: Sequence[Number], motion: Motion) -> list[Number]:
        """s, length nv."""
        tree = self.pose.tree
        bias = accelerations(self.pose, u, motion, [0.0] * tree.nv)
        result: list[Number] = [0.0] * tree.nv
        for rate, value in self._solve([row.drift for row in self.loops.rows(self.pose, motion, bias)]):
            result[rate] = -value
        return result

    # -- dynamics ----------------------------------------------------------------------------------------------------

    def mass(self) -> list[list[Number]]:
        """T' M T, shape (n, n)."""
        nv = self.pose.tree.nv
        return inertia_between(self.pose, [[self.tangent[i][k] for i in range(nv)] for k in range(self.n)])

    def effort(self, u: Sequence[Number], motion: Motion, du: Sequence[Number], *, weight: bool = True) -> list[Number]:
        """Effort in the independent rates for the rates `u` and their derivatives `du`, length n."""
        return self.reduced(self.forces(u, motion, du, weight=weight))

    def forces(self, u: Sequence[Number], motion: Motion, du: Sequence[Number], *, weight: bool = True) -> list[Number]:
        """Forces along all rates of the tree for the same, length nv."""
        base = scale(-1.0, self.pose.gravity) if weight else ZERO
        held_up = self.pose.held_up if weight else ()
        forces = generalised_forces(self.pose, motion, accelerations(self.pose, u, motion, du, base), held_up)
        if self.pose.rotors:
            # a rotor's momentum is along the axes of its joint, as Pinocchio has them, and turns with these
            turned = turning_axes(self.pose, u, motion)
            for rate, inertia in self.pose.rotors.items():
                forces[rate] = forces[rate] + inertia * (du[rate] + turned[rate])
        return forces

    def gravity(self) -> list[Number]:
        """Effort that holds the robot at rest, length n."""
        still: list[Number] = [0.0] * self.pose.tree.nv
        return self.effort(still, velocities(self.pose, still), still)

    def reduced(self, forces: Sequence[Number]) -> list[Number]:
        """T' f, length n."""
        return [dot([row[k] for row in self.tangent], forces) for k in range(self.n)]


class MassFactor:
    """A symmetric positive definite matrix as L D L'.

    Args:
        mass: the matrix, shape (n, n).
        strain: of what it was made from.
        sizes: usual pivots; default none, where only the loss of digits counts.

    Attributes:
        strain: the strain that was given, with what is lost here.
    """

    def __init__(self, mass: Sequence[Sequence[Number]], strain: Number, sizes: Sequence[float] | None = None) -> None:
        n = len(mass)
        work = [list(row) for row in mass]
        self._inverse: list[Number] = []
        self._factors: list[dict[int, Number]] = []
        self._work = work
        self.strain = strain
        for j in range(n):
            if is_zero(work[j][j]):
                raise CompileError(
                    "the robot has a motion that moves no mass: a body at the end of a limb has none, or none that "
                    "its joint moves; give it an inertia"
                )
            inverse = 1.0 / work[j][j]
            self._inverse.append(inverse)
            if sizes is not None:
                self.strain = maximum(self.strain, sizes[j] * absolute(inverse))
            elif j > 0:
                self.strain = maximum(self.strain, MASS_SHARE * mass[j][j] * inverse)
            factors = {i: work[i][j] * inverse for i in range(j + 1, n) if not is_zero(work[i][j])}
            for i, factor in factors.items():
                for k in range(j + 1, i + 1):
                    work[i][k] = work[i][k] - factor * work[k][j]
            self._factors.append(factors)

    def solve(self, right: Sequence[Number]) -> list[Number]:
        """x with M x = right."""
        n = len(right)
        x = list(right)
        for j in range(n):
            for i, factor in self._factors[j].items():
                x[i] = x[i] - factor * x[j]
        x = [value * inverse for value, inverse in zip(x, self._inverse, strict=True)]
        for j in reversed(range(n)):
            for i, factor in self._factors[j].items():
                x[j] = x[j] - factor * x[i]
        return x
