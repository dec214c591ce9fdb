"""Rank of dimensionless matrices, decided in one place.

A singular value counts where it is above the tolerance RANK of the largest one, or of 1 where all are smaller: the
entries are dimensionless, so a matrix whose entries are all rounding has rank 0, and no row is ever judged by its own
size.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.factoring import pivots_of


@dataclass(frozen=True, eq=False)
class Split:
    """A dimensionless matrix (m, n) split by its singular values.

    Attributes:
        rank: number of singular values that count.
        values: of those, shape (rank,), descending.
        left: orthonormal basis of the column space, shape (m, rank).
        right: orthonormal basis of the row space, shape (n, rank).
        null: orthonormal basis of the null space, shape (n, n - rank).
    """

    rank: int
    values: Array
    left: Array
    right: Array
    null: Array

    @staticmethod
    def of(matrix: Array) -> Split:
        """The split of a matrix, decided by `RANK`."""
        m, n = matrix.shape
        if not (m and n):
            return Split(0, np.zeros(0), np.zeros((m, 0)), np.zeros((n, 0)), np.eye(n))
        # all of `right` is needed for the null space, never all of `left`: of tall matrices that is most of the work
        left, values, right = np.linalg.svd(matrix, full_matrices=m < n)
        rank = int(np.count_nonzero(values > threshold(values)))
        return Split(rank, values[:rank], left[:, :rank], right[:rank].T, right[rank:].T)

    def solve(self, wanted: Array) -> Array:
        """Least-norm x with matrix @ x nearest to `wanted`, shape (n,) or (n, k)."""
        scaled = (self.left.T @ wanted).T / self.values
        return np.asarray(self.right @ scaled.T)

    def solve_transposed(self, wanted: Array) -> Array:
        """Least-norm y with matrix' @ y nearest to `wanted`, shape (m,) or (m, k)."""
        scaled = (self.right.T @ wanted).T / self.values
        return np.asarray(self.left @ scaled.T)


def threshold(values: Array) -> float:
    """The size above which a singular value counts, given all of a matrix's."""
    return tolerances.RANK.value * max(float(values.max(initial=0.0)), 1.0)


def rank_of(matrix: Array) -> int:
    """Rank of a dimensionless matrix."""
    values = singular_values(matrix)
    return int(np.count_nonzero(values > threshold(values)))


def singular_values(matrix: Array) -> Array:
    """Singular values of a matrix, descending; none of an empty one."""
    return np.asarray(np.linalg.svd(matrix, compute_uv=False), dtype=np.float64) if matrix.size else np.zeros(0)


def null_space(matrix: Array) -> Array:
    """Orthonormal basis of the null space of a dimensionless matrix, shape (columns, nullity)."""
    return Split.of(matrix).null


def coordinates_of(basis: Array) -> Array:
    """Another basis of the space of an orthonormal one (n, k), in which k of the coordinates are the parameters.

    It has the unit matrix there.  A motion that only a few joints make stays one of those joints alone, so that large
    and small are not mixed.
    """
    count = basis.shape[1]
    if count == 0:
        return basis
    chosen = np.arange(count) if count == len(basis) else np.sort(pivots_of(basis.T)[:count])
    return np.asarray(np.linalg.solve(basis[chosen].T, basis.T).T)


def dependent_rows(matrix: Array) -> list[int]:
    """Rows of a dimensionless matrix that depend on the rows before them (Gram-Schmidt, twice for rounding)."""
    basis: list[Array] = []
    dependent: list[int] = []
    size = max(float(np.abs(matrix).max(initial=0.0)), 1.0)
    for index, row in enumerate(matrix):
        rest = row.copy()
        for _ in range(2):
            for direction in basis:
                rest -= (rest @ direction) * direction
        length = float(np.linalg.norm(rest))
        if length > 10.0 * tolerances.RANK.value * size:
            basis.append(rest / length)
        else:
            dependent.append(index)
    return dependent
