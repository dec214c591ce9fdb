"""Freedoms that move no mass, such as the spin of a massless rod between two balls: no equation tells how they move.

They get the least motion, in dimensionless rates.  Which they are, and in which order to eliminate the mass matrix of
the others, is found on the cloud (`cutjoint.compile.equations.carried.weighed`).  A force along one has no answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.compile.equations.reduction import MassFactor, Reduction
from cutjoint.compile.expressions.functions import absolute, is_zero, maximum
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import dot

Column = Sequence[Number]
"""Rates of all joints, or their derivatives, length nv."""


@dataclass(frozen=True)
class Order:
    """The independent rates, counted in their order: `heavy` in the order in which their mass matrix is eliminated,
    `light` those that move no mass then."""

    heavy: tuple[int, ...]
    light: tuple[int, ...] = ()


class Least:
    """Motions to which some others may be added so that they become the least ones, in dimensionless rates.

    Args:
        light: the others.
        scale: makes rates dimensionless, shape (nv,).
        strain: of what they were made from.

    Attributes:
        strain: with what is lost here.
    """

    def __init__(self, light: Sequence[Column], scale: Array, strain: Number) -> None:
        self._light, self._scale = light, (1.0 / (scale * scale)).tolist()
        self._factor = MassFactor([[self._product(x, y) for y in light] for x in light], strain)
        self.strain = self._factor.strain

    def of(self, column: Column, offset: Column | None = None) -> list[Number]:
        """A motion and as much of the light ones as makes it, plus an offset, the least one."""
        size = column if offset is None else [x + y for x, y in zip(column, offset, strict=True)]
        shares = self._factor.solve([-self._product(one, size) for one in self._light])
        return combined(column, self._light, shares)

    def _product(self, x: Column, y: Column) -> Number:
        return dot([w * a for w, a in zip(self._scale, x, strict=True)], y)


def combined(column: Column, motions: Sequence[Column], shares: Sequence[Number]) -> list[Number]:
    """A motion and shares of others."""
    total = list(column)
    for motion, share in zip(motions, shares, strict=True):
        total = [x if is_zero(y) else x + share * y for x, y in zip(total, motion, strict=True)]
    return total


class WholeMotion:
    """All independent rates of a robot under forces on all joints, where some of them move no mass.

    Attributes:
        strain: of what is solved.
    """

    def __init__(self, whole: Reduction, order: Order, scale: Array) -> None:
        self._whole, self._order, self._scale = whole, order, scale
        mass, heavy = whole.mass(), order.heavy
        self._factor = MassFactor([[mass[i][j] for j in heavy] for i in heavy], whole.strain)
        self._light = [self._with([-mass[i][k] for i in heavy], k) for k in order.light]
        self._least = Least(self._light, scale, self._factor.strain)
        self.strain = self._least.strain

    def accelerations(self, drift: Column, forces: Column, offset: Column) -> list[Number]:
        """Derivatives of all rates under what is left of the forces at some that the loops allow, (nv,) each.

        Args:
            offset: what the dimensionless accelerations are beside the derivatives of the rates.
        """
        reduced = self._whole.reduced(forces)
        moved = self._with([reduced[i] for i in self._order.heavy])
        return self._least.of([x + y for x, y in zip(moved, drift, strict=True)], offset)

    def pushed(self, forces: Column, terms: Column, floor: Number) -> Number:
        """A strain that is beyond the limit where forces push what moves no mass.

        Args:
            forces, terms: the forces (nv,), and the size of what they were added up from.
            floor: what is rounding, an energy [J].
        """
        worst: Number = 0.0
        for one, k in zip(self._light, self._order.light, strict=True):
            load = dot(one, forces)
            if is_zero(load):
                continue
            unit = float(self._scale[self._whole.plan.independent[k]])
            size = tolerances.DYNAMICS.value * dot([absolute(x) for x in one], terms) + floor / unit
            worst = maximum(worst, absolute(load) / size)
        return STRAIN_LIMIT * worst

    def _with(self, loads: Sequence[Number], light: int | None = None) -> list[Number]:
        """Rates of all joints that loads on the heavy independent ones make, beside one light one."""
        rates: list[Number] = [0.0] * self._whole.n
        for i, value in zip(self._order.heavy, self._factor.solve(loads), strict=True):
            rates[i] = value
        if light is not None:
            rates[light] = 1.0
        return self._whole.rates(rates)
