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
from cutjoint.compile.graph import Graph
from cutjoint.compile.inertia import Kind
from cutjoint.compile.loops import Loops
from cutjoint.compile.program import Program, assemble, interpret
from cutjoint.compile.tree import Pose, Tree, moved
from cutjoint.errors import CompileError

CLOUD = 24
"""Postures in the cloud."""
STRIDE = 0.15
"""Length of the steps that make it [rad or robot lengths]."""
THRESHOLD = 0.1
"""Smallest pivot, against the largest entry of its column, on any posture of the cloud."""
REDUNDANT = 1e-8
"""Rows whose scaled entries all stay below this are redundant."""


@dataclass(frozen=True)
class Plan:
    """A fixed elimination.

    Attributes:
        pivots: (row, rate) in order.
        sizes: the largest entry of each pivot column on a typical posture of the cloud, against which a posture's
            pivots are judged.
        independent: rates that remain, in the order of the reduced coordinates.
        redundant: rows that are left out.
    """

    pivots: tuple[tuple[int, int], ...]
    sizes: tuple[float, ...]
    independent: tuple[int, ...]
    redundant: tuple[int, ...]


def rate_scale(tree: Tree, length: float) -> Array:
    """Factor per rate that makes it dimensionless, shape (nv,)."""
    scale = np.ones(tree.nv)
    for step in tree.steps[1:]:
        count = {Kind.SLIDE: 1, Kind.SHIFT: 3, Kind.FLAT: 2}.get(step.kind, 0)
        scale[step.u : step.u + count] = length
    return scale


class Survey:
    """Numeric Jacobian, residual and motion of a tree with loops, from their expressions."""

    def __init__(self, tree: Tree, loops: Loops, length: float) -> None:
        graph = Graph()
        q = graph.symbols(tree.nq)
        u = graph.symbols(tree.nv)
        pose = Pose(tree, q)
        rows = loops.rows(pose)
        self.pattern = [set(row.coefficients) for row in rows]
        self._constant = [
            {k for k, c in row.coefficients.items() if graph.constant_of(graph.reference(c)) is not None}
            for row in rows
        ]
        entries = [row.coefficients.get(k, 0.0) for row in rows for k in range(tree.nv)]
        self._system = assemble(
            graph, "rows", {"q": q}, {"jacobian": entries, "residual": [row.residual for row in rows]}
        )
        self._moved = assemble(graph, "moved", {"q": q, "u": u}, {"q": moved(pose, u)})
        self.shape = (len(rows), tree.nv)
        self.row_scale = np.array([1.0 / length if row.is_length else 1.0 for row in rows])
        self.rate_scale = rate_scale(tree, length)

    def is_constant(self, row: int, rate: int) -> bool:
        """Whether an entry of the Jacobian is the same in every posture."""
        return rate in self._constant[row]

    def system(self, q: Array) -> tuple[Array, Array]:
        """Scaled Jacobian (rows, nv) and residual (rows,)."""
        values = _run(self._system, q)
        rows, rates = self.shape
        jacobian = values[: rows * rates].reshape(rows, rates)
        return self.row_scale[:, None] * jacobian * self.rate_scale, self.row_scale * values[rows * rates :]

    def moved(self, q: Array, u: Array) -> Array:
        """Configuration after the scaled step `u`."""
        return _run(self._moved, np.concatenate([q, self.rate_scale * u]))

    def closed(self, q: Array) -> Array | None:
        """The closed configuration next to `q`, or None."""
        for _ in range(12):
            jacobian, residual = self.system(q)
            if not np.isfinite(residual).all():
                return None
            if np.abs(residual).max(initial=0.0) < 1e-13:
                return q
            u = np.asarray(np.linalg.lstsq(jacobian, -residual, rcond=1e-7)[0], dtype=np.float64)
            if np.abs(u).max(initial=0.0) > 0.5:
                return None
            q = self.moved(q, u)
        return None

    def cloud(self, home: Array) -> Array:
        """Closed configurations around `home`, itself first, shape (k, nq): random walks that start there."""
        chance = np.random.default_rng(0)
        found = [home]
        q = home
        for _ in range(4 * CLOUD):
            if len(found) == CLOUD:
                break
            jacobian, _ = self.system(q)
            _, values, basis = np.linalg.svd(jacobian)
            free = basis[int(np.sum(values > 1e-7 * max(values.max(initial=0.0), 1e-300))) :]
            if not len(free):
                break
            direction = chance.normal(size=len(free)) @ free
            step = self.closed(self.moved(q, STRIDE * direction / np.abs(direction).max()))
            if step is not None:
                found.append(step)
            q = found[int(chance.integers(len(found)))]
        return np.array(found)


def _run(program: Program, inputs: Array) -> Array:
    with np.errstate(all="ignore"):
        return np.array([float(x) for x in interpret(program, list(inputs))])


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
                    if not (row_is_constant(row, rate, constant) and rate in constant[other]):
                        constant[other] -= present[row]
                    else:
                        constant[other] -= present[row] - constant[row]
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


def row_is_constant(row: int, rate: int, constant: list[set[int]]) -> bool:
    """Whether the pivot itself is a constant."""
    return rate in constant[row]


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
        if largest.min() < 1e-6:
            continue
        ratio = (column / largest[:, None]).min(axis=0)
        for index, row in enumerate(order):
            if rate not in present[row] or ratio[index] < THRESHOLD:
                continue
            fill = (len(present[row] & rates) - 1) * (counts[rate] - 1)
            merit = (float(fill), 0.0 if rate in constant[row] else 1.0, -float(ratio[index]))
            if best is None or merit < best:
                best, pick = merit, (row, rate)
    return pick
