"""A cloud of closed postures around home, on which everything that a compiled robot fixes for ever is decided.

The constraints are asked in numbers, from their expressions, and dimensionless: rows that are lengths are divided by
the robot's length, rates that are lengths multiplied by it.  So nothing here depends on how large the robot is.

Home may be singular (a flat parallelogram).  What is decided for ever must not be decided there: `regular` keeps the
postures of the cloud at which the rank is what it is almost everywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.rank import Split, null_space, singular_values, threshold
from cutjoint.compile.equations import newton
from cutjoint.compile.equations.coordinates import moved
from cutjoint.compile.equations.cut_rows import ConstraintRow
from cutjoint.compile.equations.pose import TreePose
from cutjoint.compile.expressions.graph import Graph, Number
from cutjoint.compile.expressions.program import Program, interpret
from cutjoint.compile.expressions.straight_line import assemble

CLOUD = 24
"""Postures in the cloud."""
STRIDE = 0.15
"""Length of the steps that make it [rad or robot lengths]."""
CLOSED = 1e-10
"""A posture is closed where Newton's method has come to rest on rounding; this only tells rounding from a gap."""
REGULAR = 0.02
"""Postures whose smallest singular value is below this part of the usual one are near a singularity."""


class Posed(Protocol):
    """A tree whose poses can be traced.

    Attributes:
        positions, nv: sizes of configuration and velocity.
        parameters: names of what is an argument beside the configuration.
    """

    @property
    def positions(self) -> int: ...
    @property
    def nv(self) -> int: ...
    @property
    def parameters(self) -> tuple[str, ...]: ...

    def pose(self, q: Sequence[Number], parameters: Sequence[Number]) -> TreePose:
        """The tree at a configuration and values of the parameters."""
        ...


class RowsOnTree(Protocol):
    """Loops, with or without more rows beside theirs."""

    def rows(self, pose: TreePose) -> list[ConstraintRow]:
        """All rows at a pose of the tree."""
        ...


class Survey:
    """Numeric Jacobian, residual and motion of a tree with rows on it, from their expressions; `row_scale` (rows,) and
    `rate_scale` (nv,) make them dimensionless.  What it takes for a configuration has the parameters behind it."""

    def __init__(self, tree: Posed, loops: RowsOnTree, row_scale: Array, rate_scale: Array) -> None:
        graph = Graph()
        q, p = graph.symbols(tree.positions), graph.symbols(len(tree.parameters))
        u = graph.symbols(tree.nv)
        pose = tree.pose(q, p)
        rows = loops.rows(pose)
        self.pattern = [set(row.coefficients) for row in rows]
        self._constant = [
            {k for k, c in row.coefficients.items() if graph.constant_of(graph.reference(c)) is not None}
            for row in rows
        ]
        entries = [row.coefficients.get(k, 0.0) for row in rows for k in range(tree.nv)]
        self._system = assemble(
            graph, "rows", {"q": [*q, *p]}, {"jacobian": entries, "residual": [row.residual for row in rows]}
        )
        self._moved = assemble(graph, "moved", {"q": [*q, *p], "u": u}, {"q": [*moved(pose, u), *p]})
        self.shape = (len(rows), tree.nv)
        self.row_scale, self.rate_scale, self._parameters = row_scale, rate_scale, len(p)

    def is_constant(self, row: int, rate: int) -> bool:
        """Whether an entry of the Jacobian is the same in every posture."""
        return rate in self._constant[row]

    def system(self, q: Array) -> tuple[Array, Array]:
        """Scaled Jacobian (rows, nv) and residual (rows,)."""
        values = run(self._system, q)
        rows, rates = self.shape
        jacobian = values[: rows * rates].reshape(rows, rates)
        return self.row_scale[:, None] * jacobian * self.rate_scale, self.row_scale * values[rows * rates :]

    def moved(self, q: Array, u: Array) -> Array:
        """Configuration after the scaled step `u`."""
        return run(self._moved, np.concatenate([q, self.rate_scale * u]))

    def closed(self, q: Array) -> Array | None:
        """The closed configuration next to `q`, as exact as rounding lets Newton's method come, or None."""
        best, least = q, np.inf
        for _ in range(16):
            jacobian, residual = self.system(q)
            size = float(np.abs(residual).max(initial=0.0))
            if not np.isfinite(size):
                return None
            if size > newton.SHRINKS * least and least < CLOSED:
                break
            if size < least:
                best, least = q, size
            if size == 0.0:
                break
            u = Split.of(jacobian).solve(-residual)
            if np.abs(u).max(initial=0.0) > 0.5:
                return None
            q = self.moved(q, u)
        return best if least < CLOSED else None

    def at_values(self, x: Array, values: Array) -> Array | None:
        """The closed configuration next to a closed one at other values of the parameters; the way there is walked in
        pieces where it is long.  None where there is none, or one that the loops hold by more rows: of a robot that
        moves because its lengths fit each other, with others a structure may be left."""
        size = len(x) - self._parameters
        for pieces in (1, 4, 16):
            here = x
            for piece in range(1, pieces + 1):
                between = x[size:] + piece / pieces * (values - x[size:])
                found = self.closed(np.concatenate([here[:size], between]))
                if found is None:
                    break
                here = found
            else:
                return here if self._rank(here) <= self._rank(x) else None
        return None

    def _rank(self, x: Array) -> int:
        values = singular_values(self.system(x)[0])
        return int(np.sum(values > threshold(values)))

    def cloud(self, home: Array) -> Array:
        """Closed configurations around `home`, itself first, shape (k, nq): random walks that start there."""
        chance = np.random.default_rng(0)
        found = [home]
        q = home
        for _ in range(4 * CLOUD):
            if len(found) == CLOUD:
                break
            jacobian, _ = self.system(q)
            free = null_space(jacobian).T
            if not len(free):
                break
            direction = chance.normal(size=len(free)) @ free
            step = self.closed(self.moved(q, STRIDE * direction / np.abs(direction).max()))
            if step is not None:
                found.append(step)
            q = found[int(chance.integers(len(found)))]
        return np.array(found)

    def regular(self, cloud: Array, keep: Sequence[int]) -> Array:
        """The postures of a cloud that are not near a singularity, shape (k, nq).

        Regular is where the rank, of all constraints and of those on the rates beside `keep`, is the one that the cloud
        has almost everywhere, by a margin: its smallest singular values are near what they are elsewhere.
        """
        dependent = np.setdiff1d(np.arange(self.shape[1]), np.asarray(keep, dtype=int))
        measure = np.ones(len(cloud))
        for columns in (np.arange(self.shape[1]), dependent):
            values = [singular_values(self.system(q)[0][:, columns]) for q in cloud]
            rank = max(int(np.sum(one > threshold(one))) for one in values)
            if rank:
                last = np.array([one[rank - 1] for one in values])
                measure = np.minimum(measure, last / np.median(last[last > tolerances.RANK.value]))
        return np.asarray(cloud[measure >= REGULAR])


def run(program: Program, inputs: Array) -> Array:
    """Results of a program in plain numpy."""
    with np.errstate(all="ignore"):
        return np.array([float(x) for x in interpret(program, list(inputs))])
