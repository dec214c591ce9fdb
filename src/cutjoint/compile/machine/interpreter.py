"""A kernel that needs no compiler: NumPy walks the program, once for all rows of a batch.

A single evaluation takes a thousand times as long as machine code; one of a thousand rows takes less than compiling.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile.expressions.program import interpret
from cutjoint.compile.machine.kernel import Kernel


class Interpreter(Kernel):
    """A program that is interpreted."""

    def __call__(self, *arguments: Array) -> Array:
        """See `Kernel`."""
        with np.errstate(all="ignore"):
            return np.array(interpret(self.program, np.concatenate(arguments).tolist()), dtype=np.float64)

    def fill(self, results: list[Array], given: list[Array], count: int, threads: int, lanes: bool) -> None:
        """See `Kernel`."""
        with np.errstate(all="ignore"):
            done = iter(interpret(self.program, [column for x in given for column in np.moveaxis(x, -1, 0)]))
        for result in results:
            for k in range(result.shape[1]):
                result[:, k] = next(done)
