"""Elimination of dependent rates from rows of constraints, in a fixed order, as expressions.

`strain` tells how far a pose is from those the order was chosen on: the largest ratio of a pivot's size then to its
size now.  1 is as good as home; beyond STRAIN_LIMIT, or where it is not a number, the caller must not use the result.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from cutjoint.compile.equations.cut_rows import ConstraintRow
from cutjoint.compile.equations.elimination_order import Plan
from cutjoint.compile.expressions.functions import is_zero, maximum
from cutjoint.compile.expressions.graph import Expression, Number
from cutjoint.compile.expressions.vectors import dot

STRAIN_LIMIT = 1e3
"""Largest strain that is accepted: pivots a thousandth of what they were cost three digits."""


class Elimination:
    """Sparse elimination of the rows at one pose, in the order of a plan.

    Attributes:
        strain: see the module.
    """

    def __init__(self, rows: Sequence[ConstraintRow], plan: Plan, nv: int) -> None:
        self._rows, self.plan, self._nv = rows, plan, nv
        self._factor()

    def _factor(self) -> None:
        """Remembers the multipliers."""
        dependent = {rate for _, rate in self.plan.pivots}
        work = [{k: c for k, c in row.coefficients.items() if k in dependent} for row in self._rows]
        left = [row for row, _ in self.plan.pivots]
        self.strain: Number = 1.0
        self._inverse: list[Number] = []
        self._multipliers: list[list[tuple[int, Number]]] = []
        for (row, rate), size in zip(self.plan.pivots, self.plan.sizes, strict=True):
            left.remove(row)
            pivot = work[row][rate]
            inverse = 1.0 / pivot
            self._inverse.append(inverse)
            if isinstance(inverse, Expression) and inverse.constant is None:
                self.strain = maximum(self.strain, abs(inverse) * size)
            multipliers: list[tuple[int, Number]] = []
            for other in left:
                entry = work[other].pop(rate, 0.0)
                if is_zero(entry):
                    continue
                factor = entry * inverse
                multipliers.append((other, factor))
                for k, value in work[row].items():
                    if k != rate:
                        work[other][k] = work[other].get(k, 0.0) - factor * value
            self._multipliers.append(multipliers)
        self._work = work

    def _solve(self, right: Sequence[Number], moves: Collection[int] | None = None) -> list[tuple[int, Number]]:
        """(rate, value) of the dependent rates for a right-hand side of all rows; rates not in `moves` are known to
        rest."""
        values = list(right)
        for (row, _), multipliers in zip(self.plan.pivots, self._multipliers, strict=True):
            if not is_zero(values[row]):
                for other, factor in multipliers:
                    values[other] = values[other] - factor * values[row]
        found: dict[int, Number] = {}
        for (row, rate), inverse in zip(reversed(self.plan.pivots), reversed(self._inverse), strict=True):
            if moves is not None and rate not in moves:
                found[rate] = 0.0
                continue
            total = values[row]
            for k, value in self._work[row].items():
                if k != rate:
                    total = total - value * found[k]
            found[rate] = total * inverse
        return list(found.items())

    def correction(self, change: Sequence[Number]) -> list[Number]:
        """Newton's step, length nv: closes the loops while the independent coordinates change by `change`."""
        right = [
            row.residual + dot([row.coefficients.get(k, 0.0) for k in self.plan.independent], change)
            for row in self._rows
        ]
        result = self.held_closed(right)
        for rate, value in zip(self.plan.independent, change, strict=True):
            result[rate] = value
        return result

    def held_closed(self, opening: Sequence[Number]) -> list[Number]:
        """Rates that make good what opens the rows, the independent ones at rest, length nv."""
        result: list[Number] = [0.0] * self._nv
        for rate, value in self._solve(opening):
            result[rate] = -value
        return result

    @property
    def residuals(self) -> list[Number]:
        """What every row is open by, redundant rows included."""
        return [row.residual for row in self._rows]

    @property
    def determinant(self) -> Number:
        """Of the rows and rates that are eliminated, against its usual size; it changes its sign at a singular pose."""
        inverse: Number = 1.0
        for one, size in zip(self._inverse, self.plan.sizes, strict=True):
            inverse = inverse * (one * size)
        return 1.0 / inverse
