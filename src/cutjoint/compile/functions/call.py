"""A compiled function that can be called: its results come by name and in their shapes, or not at all."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, prod

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.compile.equations.reduction import STRAIN_LIMIT
from cutjoint.compile.functions.table import Function
from cutjoint.compile.machine.kernel import Kernel
from cutjoint.compile.sources.interface import Source, size


class CompiledFunction:
    """One function of one model.

    Args:
        row: what it is.
        kernel: the machine code; whoever calls that directly looks at the strain himself.
        source: the model.
    """

    def __init__(self, row: Function, kernel: Kernel, source: Source) -> None:
        self.row, self.kernel = row, kernel
        self._parts: list[tuple[str, slice, tuple[int, ...] | None]] = []
        start = 0
        for part in row.parts:
            shape = tuple(size(source, symbol) for symbol in part.shape.split(","))
            stop = start + prod(shape)
            self._parts.append((part.name, slice(start, stop), shape if len(shape) > 1 else None))
            start = stop

    def __call__(self, *arguments: Array) -> dict[str, Array] | None:
        """One evaluation: the parts of the result by name, read-only; None where it must not be trusted."""
        y = self.kernel(*arguments)
        # a sum is finite only if all its terms are; the strain stands last
        if not (y[-1] <= STRAIN_LIMIT and isfinite(np.add.reduce(y))):
            return None
        y.flags.writeable = False
        return {name: y[at] if shape is None else y[at].reshape(shape) for name, at, shape in self._parts}

    def parts(self, y: Array) -> dict[str, Array]:
        """The parts of a result of the kernel."""
        return {name: y[at] if shape is None else y[at].reshape(shape) for name, at, shape in self._parts}

    def batch(self, arguments: Sequence[Array], threads: int = 1) -> tuple[dict[str, Array], npt.NDArray[np.bool_]]:
        """Many evaluations: arrays of shape (N, ...) by name, and which of the N may be trusted."""
        *results, strain = self.kernel.batch(arguments, threads=threads)
        # one pass over the data: a row with anything not finite has no finite sum
        total = np.einsum("ij->i", results[0])
        for result in results[1:]:
            total += np.einsum("ij->i", result)
        good = (strain[:, 0] <= STRAIN_LIMIT) & np.isfinite(total)
        named = zip(self._parts, results, strict=True)
        return {name: y if shape is None else y.reshape(-1, *shape) for (name, _, shape), y in named}, good
