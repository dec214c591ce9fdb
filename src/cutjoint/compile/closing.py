"""Closing the loops of a chain by its compiled functions: one posture, many at once."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.compile.equations import newton
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.compile.functions.library import Library
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.doors import of_type
from cutjoint.errors import InputError
from cutjoint.mechanism import Posture

OPEN = 10.0
"""How many times as open as one that was closed here a posture may be that somebody gives, as for the chain itself."""


class ChainClosing:
    """Closes the loops of one chain.

    Args:
        source: the chain.
        library: its compiled functions.
        parameters: values of the parameters that are arguments, shape (parameters,).
    """

    def __init__(self, source: ChainSource, library: Library, parameters: Array) -> None:
        self.source, self.library, self.parameters = source, library, parameters
        self.lengths, self.row_scale, self.q_scale = source.closure.is_length, source.row_scale, source.position_scale

    def start(self, near: Posture) -> Array:
        """The configuration of a posture of this chain."""
        chain = self.source.chain
        if not hasattr(near, "q_full"):
            of_type("a posture", near, Posture)
        if near.q_full.shape != (chain.nq,):
            raise InputError(
                f"this posture has {near.q_full.size} coordinates, {chain.name} has {chain.nq}; make it with this "
                "robot's close() or reach()"
            )
        return near.q_full

    def to(self, q: Array, target: Array) -> Posture | None:
        """From the closed `q` to the actuated `target`; None where it is not plainly on the same branch."""
        step = self.library["step"]
        kernel, next_q, open_by = step.kernel, step.place("q_next"), step.place("residual")
        last: float | None = None
        worst = np.inf
        for _ in range(newton.STEPS):
            y = kernel(q, target, self.parameters)
            if not (y[-1] <= STRAIN_LIMIT and isfinite(np.add.reduce(y))):
                return None
            after, residual = y[next_q], y[open_by]
            size = float(np.maximum.reduce(np.abs((after - q) / self.q_scale), initial=0.0))
            gap = float(np.maximum.reduce(np.abs(residual * self.row_scale), initial=0.0))
            if last is not None and newton.arrived(gap, worst):
                gaps = np.abs(residual)
                pair = float(gaps[self.lengths].max(initial=0.0)), float(gaps[~self.lengths].max(initial=0.0))
                return Posture(q[list(self.source.actuated)], q, pair, self.source.chain.home.layout)
            if size > newton.longest(last):
                return None
            last, worst, q = size, gap, after
        return None

    def walk(
        self, q: Array, target: Array, threads: int, begin: Array | None = None, end: Array | None = None
    ) -> tuple[Array, npt.NDArray[np.bool_]]:
        """Walk all rows from the closed `q` to their actuated `target`; also returns which arrived, see `walked`.

        Args:
            begin: values of the parameters at which `q` is closed, shape (parameters,); default the present ones.
            end: those that are walked to, shape (parameters,) or (N, parameters); default the present ones.
        """
        function = self.library["step"]
        start = q[:, list(self.source.actuated)]
        last = self.parameters if end is None else end
        first = self.parameters if begin is None else begin

        def step(at: Array, fraction: float) -> tuple[Array, Array, Array]:
            to = target if fraction == 1.0 else start + fraction * (target - start)
            values = last if fraction == 1.0 or first is last else first + fraction * (last - first)
            parts, trusted = function.batch([at, to, values], threads)
            after = parts["q_next"]
            change, gap = after - at, parts["residual"] * self.row_scale
            change /= self.q_scale
            size = np.maximum.reduce(np.abs(change, out=change), axis=1)
            if not trusted.all():
                size[~trusted] = np.inf
            return after, size, np.maximum.reduce(np.abs(gap, out=gap), axis=1, initial=0.0)

        return walked(q, step)

    def check(self, q: Array, values: Array | None = None, threads: int = 1) -> None:
        """Check that configurations are closed at values of the parameters, shape (parameters,) or (N, parameters);
        default the present ones.

        Raises:
            InputError: one is not; it names the row.
        """
        many = np.atleast_2d(q)
        given = self.parameters if values is None else values
        parts, _ = self.library["residual"].batch([many, given], threads)
        open_by = np.maximum.reduce(np.abs(parts["residual"] * self.row_scale), axis=1, initial=0.0)
        bad = np.flatnonzero(~(open_by < OPEN * tolerances.CLOSURE.value))
        if bad.size:
            where = f"row {bad[0]} of the postures" if q.ndim == 2 else "this posture"
            raise InputError(
                f"{where} leaves the loops of {self.source.name} open by {open_by[bad[0]]:.3g} robot lengths or rad at "
                "these values of its parameters; make it with close() or reach() at the same values"
            )


Step = Callable[[Array, float], tuple[Array, Array, Array]]
"""(configurations, fraction of the way) -> configurations after one step of Newton's method towards there; of every row
the size of the step, and what was left before it; dimensionless, and infinite where a row must not be trusted."""


def walked(q: Array, step: Step) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Walk all rows of closed configurations to the end of a way, in steps short against the links.

    Also returns which rows arrived, on the branch they started from.
    """
    _, size, _ = step(q, 1.0)
    pieces = int(np.ceil(min(float(size[np.isfinite(size)].max(initial=0.0)) / 0.1, 200.0))) + 1
    good = np.ones(len(q), dtype=bool)
    for piece in range(1, pieces + 1):
        last: Array | None = None
        gap = np.full(len(q), np.inf)
        for _ in range(newton.STEPS):
            after, size, gap = step(q, 1.0 if piece == pieces else piece / pieces)
            good &= size <= newton.longest(last)
            if last is not None and float(size[good].max(initial=0.0)) < newton.RESTS:
                break
            q, last = np.where(good[:, None], after, q), size
    # on the way a tool may be beside what it cannot reach; at its end nothing is left
    return q, good & (gap <= tolerances.CLOSURE.value)
