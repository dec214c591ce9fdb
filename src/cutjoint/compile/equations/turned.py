"""A reduction in Pinocchio's velocities, where the independent ones are those of bodies that turn freely.

Rates of a ball, and of what flies, are in world axes; Pinocchio's velocities are in the axes of the moving body
(`cutjoint.compile.equations.coordinates`).  With w the independent rates and v the velocities,

    w = E v,   dw = E a - t

E turns the axes, and t is what accelerations are beside the derivatives of the rates.
"""

from __future__ import annotations

from collections.abc import Sequence

from cutjoint.compile.equations.coordinates import to_rates, turning_axes
from cutjoint.compile.equations.dynamics import Motion
from cutjoint.compile.equations.reduction import Reduction
from cutjoint.compile.expressions.functions import is_zero
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import dot


class Turned(Reduction):
    """A reduction in the velocities of whole joints.

    Args:
        inner: in their rates.
        index: of these, in the order of its independent ones.
    """

    def __init__(self, inner: Reduction, index: Sequence[int]) -> None:
        self.__dict__.update(inner.__dict__)
        self.inner, self._index = inner, tuple(index)
        nv = self.pose.tree.nv
        columns = [to_rates(self.pose, [1.0 if i == own else 0.0 for i in range(nv)]) for own in self._index]
        self._axes: list[list[Number]] = [[column[own] for column in columns] for own in self._index]
        across = [list(column) for column in zip(*self._axes, strict=True)]
        self.tangent = [[dot(row, column) for column in across] for row in inner.tangent]

    def drift(self, u: Sequence[Number], motion: Motion) -> list[Number]:
        turning = turning_axes(self.pose, u, motion)
        back = [-turning[own] for own in self._index]
        led = (
            x if is_zero(y) else x + y for x, y in zip(self.inner.drift(u, motion), self.inner.rates(back), strict=True)
        )
        return list(led)

    def correction(self, change: Sequence[Number]) -> list[Number]:
        return self.inner.correction([dot(row, change) for row in self._axes])
