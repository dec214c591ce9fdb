"""What a back end makes of a program: a kernel, which can be called with one state or with many."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.expressions.program import Program
from cutjoint.errors import InputError


class Kernel:
    """A program that can be called.  A back end says how one evaluation is done, and may do many in its own way.

    Args:
        program: what it computes.
        fast: sums may be reassociated, where the back end can.

    Attributes:
        compile_time: seconds that making it took.
    """

    compile_time = 0.0

    def __init__(self, program: Program, *, fast: bool = False) -> None:
        self.program, self.fast = program, fast

    def __reduce__(self) -> tuple[object, ...]:
        # what was made for this process and processor does not travel: it is made anew by whoever unpickles
        return _again, (type(self), self.program, self.fast)

    def __call__(self, *arguments: Array) -> Array:
        """One evaluation: arguments of the program's lengths in, all results one after another out."""
        raise AssertionError

    @property
    def address(self) -> int:
        """Address of `void f(const double *x, double *y)`, to be called from other compiled code; x holds all arguments
        one after another, y all results.

        Raises:
            InputError: this back end has none.
        """
        raise InputError("this back end makes nothing that has an address; compile with backend='llvm'")

    def batch(self, arguments: Sequence[Array], *, threads: int = 1, lanes: bool = True) -> list[Array]:
        """Many evaluations.

        Args:
            arguments: of shape (N, size) each, or (size,) where all evaluations share it.
            threads: processor cores to use.
            lanes: False does one row after another (for comparison; the digits are the same).

        Returns:
            One (N, size) array a result.
        """
        given = [np.ascontiguousarray(x, dtype=np.float64) for x in arguments]
        for (name, size), x in zip(self.program.arguments, given, strict=True):
            if x.shape[-1] != size or x.ndim > 2:
                raise InputError(f"{name} must have shape (N, {size}) or ({size},), found {x.shape}")
        counts = {x.shape[0] for x in given if x.ndim == 2}
        if len(counts) != 1:
            raise InputError(f"the arguments must agree in their number of rows, found {sorted(counts)}")
        results = [np.empty((*counts, size)) for _, size in self.program.results]
        self.fill(results, given, counts.pop(), threads, lanes)
        return results

    def fill(self, results: list[Array], given: list[Array], count: int, threads: int, lanes: bool) -> None:
        """The evaluations of a batch: `given` are its arguments, in order and of the right shapes."""
        for row in range(count):
            y, start = self(*(x if x.ndim == 1 else x[row] for x in given)), 0
            for result in results:
                result[row] = y[start : start + result.shape[1]]
                start += result.shape[1]


def _again(kind: type[Kernel], program: Program, fast: bool) -> Kernel:
    return kind(program, fast=fast)
