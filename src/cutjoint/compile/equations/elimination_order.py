"""Which rows of the constraints are independent, and in which order to eliminate the passive rates.

A compiled robot eliminates with one fixed order, so the order must be good everywhere it is used, not only at one
posture.  It is chosen on a cloud of closed postures around home: a pivot is taken only if it is large against its
column on all of them, and among those the one that fills the fewest zeros (Markowitz).  Rows that vanish on the whole
cloud once the others are eliminated are redundant.  Because the closure is analytic, they then vanish as long as the
robot moves without passing a singularity.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.equations.cloud import Survey
from cutjoint.errors import CompileError

THRESHOLD = 0.1
"""Smallest pivot, against the largest entry of its column, on any posture of the cloud."""
REDUNDANT = 1e-8
"""Rows whose dimensionless entries all stay below this are redundant, and columns below it hold no pivot."""


@dataclass(frozen=True)
class Idle:
    """Idle freedoms (see `cutjoint.compile.equations.carried`), counted from 0 in the order of the idle rates.

    Attributes:
        support: of every idle freedom, the rates that it moves; all others rest.
        heavy: idle freedoms in the order in which their mass matrix is eliminated.
        sizes: usual pivots of that elimination, against which a posture's pivots are judged.
        weightless: those that move no mass once the heavy ones are eliminated.
    """

    support: tuple[frozenset[int], ...]
    heavy: tuple[int, ...]
    sizes: tuple[float, ...]
    weightless: tuple[int, ...]


@dataclass(frozen=True)
class Plan:
    """A fixed elimination.

    Attributes:
        pivots: (row, rate) in order.
        sizes: the largest entry of each pivot column on a typical posture of the cloud, against which a posture's
            pivots are judged.
        independent: rates that remain, in the order of the reduced coordinates.
        redundant: rows that are left out.
        idle: what is known of the last of `independent`, where those are idle freedoms; None where there are none.
    """

    pivots: tuple[tuple[int, int], ...]
    sizes: tuple[float, ...]
    independent: tuple[int, ...]
    redundant: tuple[int, ...]
    idle: Idle | None = None


def choose(survey: Survey, cloud: Array, keep: Sequence[int]) -> Plan:
    """The elimination for a robot whose rates `keep` shall remain.

    Where the loops leave more freedom than that, further rates remain after them; where they leave less, the last of
    `keep` are eliminated too.

    Raises:
        CompileError: no order of elimination is good on the whole cloud.
    """
    jacobians = np.array([survey.system(q)[0] for q in cloud])
    rows, rates = survey.shape
    present = [set(pattern) for pattern in survey.pattern]
    constant = [{k for k in pattern if survey.is_constant(i, k)} for i, pattern in enumerate(survey.pattern)]
    active = jacobians.copy()
    left_rows, left_rates = set(range(rows)), set(range(rates))
    tiers = [set(range(rates)) - set(keep), *({k} for k in reversed(keep))]
    pivots: list[tuple[int, int]] = []
    sizes: list[float] = []
    for tier in tiers:
        while True:
            pick = _best(active, present, constant, left_rows, left_rates, tier & left_rates)
            if pick is None:
                break
            row, rate = pick
            pivots.append(pick)
            size = np.abs(active[:, sorted(left_rows), rate]).max(axis=1)
            scale = survey.row_scale[row] * survey.rate_scale[rate]
            sizes.append(float(np.median(size) / scale))
            left_rows.discard(row)
            left_rates.discard(rate)
            for other in left_rows:
                if rate in present[other]:
                    factor = active[:, other, rate] / active[:, row, rate]
                    # what changes: all that is added, or where pivot and entry are constants, what of it changes
                    still = constant[row] if rate in constant[row] and rate in constant[other] else set()
                    constant[other] -= present[row] - still
                    active[:, other] -= factor[:, None] * active[:, row]
                    active[:, other, rate] = 0.0
                    present[other] = (present[other] | present[row]) - {rate}
    rest = np.abs(active[:, sorted(left_rows)][:, :, sorted(left_rates)]) if left_rows else np.zeros(0)
    if rest.size and rest.max() > REDUNDANT:
        raise CompileError(
            f"no fixed order of elimination is good around this posture: after {len(pivots)} pivots rows of size "
            f"{rest.max():.2g} are left; choose another home posture"
        )
    first = [k for k in keep if k in left_rates]
    return Plan(tuple(pivots), tuple(sizes), (*first, *sorted(left_rates - set(first))), tuple(sorted(left_rows)))


def _best(
    active: Array,
    present: list[set[int]],
    constant: list[set[int]],
    rows: set[int],
    rates: set[int],
    wanted: set[int],
) -> tuple[int, int] | None:
    """The next pivot: large on the whole cloud, few zeros filled, constants first."""
    if not rows or not wanted:
        return None
    order = sorted(rows)
    best: tuple[float, ...] | None = None
    pick: tuple[int, int] | None = None
    counts = {rate: sum(rate in present[row] for row in order) for rate in wanted}
    for rate in sorted(wanted):
        column = np.abs(active[:, order, rate])
        largest = column.max(axis=1)
        if largest.min() < REDUNDANT:
            continue
        ratio = (column / largest[:, None]).min(axis=0)
        for index, row in enumerate(order):
            if rate not in present[row] or ratio[index] < THRESHOLD:
                continue
            fill = (len(present[row] & rates) - 1) * (counts[rate] - 1)
            # what is equal must not be told apart by rounding, or the order would depend on the machine; of equal
            # rates the outermost goes first
            size = round(float(ratio[index]), 1)
            merit = (float(fill), 0.0 if rate in constant[row] else 1.0, -size, -float(rate))
            if best is None or merit < best:
                best, pick = merit, (row, rate)
    return pick
