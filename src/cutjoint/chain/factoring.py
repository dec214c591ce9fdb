"""Factorisations of small matrices, by Eigen and NumPy: SciPy's take a tenth of a second to import."""

from __future__ import annotations

import eigenpy  # type: ignore[import-untyped]  # what Pinocchio speaks to Python with; always there with it
import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array


class LU:
    """A square matrix (n, n) with n > 0 as the product of two triangles, with row pivoting."""

    def __init__(self, matrix: Array) -> None:
        self._factors = eigenpy.PartialPivLU(matrix)

    @property
    def pivots(self) -> list[float]:
        """What is divided by; 0 where the matrix is singular."""
        diagonal: list[float] = self._factors.matrixLU().diagonal().tolist()
        return diagonal

    @property
    def determinant(self) -> float:
        """Of the matrix."""
        return float(self._factors.determinant())

    def solve(self, right: Array) -> Array:
        """The x with matrix @ x = right, shape (n,) or (n, k); not finite where a pivot is 0."""
        return np.asarray(self._factors.solve(right)).reshape(right.shape)


def pivots_of(matrix: Array) -> npt.NDArray[np.intp]:
    """Columns of a matrix (m, n) in the order of a pivoted QR factorisation: independent ones first, shape (n,).

    The next one is the column of which most is left beside those before it (Gram-Schmidt, twice for rounding).
    """
    rest, order = matrix.astype(np.float64), list(range(matrix.shape[1]))
    basis = np.zeros((len(matrix), 0))
    for k in range(min(matrix.shape)):
        sizes = np.einsum("ij,ij->j", rest, rest)[order[k:]]
        best = int(np.argmax(sizes))
        if not sizes[best] > 0.0:
            break
        order[k:] = [order[k + best], *order[k : k + best], *order[k + best + 1 :]]
        basis = np.column_stack([basis, rest[:, order[k]] / np.sqrt(sizes[best])])
        rest -= basis @ (basis.T @ rest)
    return np.array(order, dtype=np.intp)
