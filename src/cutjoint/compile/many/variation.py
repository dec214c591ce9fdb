"""What varies from run to run: gains, parameters, initial states."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, as_vector
from cutjoint.compile.many.traced import TracedLoop
from cutjoint.errors import InputError


class Variation:
    """What varies: initial states and per-run arguments of all runs."""

    def __init__(
        self,
        loop: TracedLoop,
        gains: Mapping[str, npt.ArrayLike],
        parameters: Mapping[str, npt.ArrayLike],
        start: npt.ArrayLike,
        start_velocity: npt.ArrayLike | None,
    ) -> None:
        n, plant = loop.plant.n, loop.plant
        if set(gains) != set(loop.gains):
            raise InputError(f"gains must be given for {', '.join(loop.gains) or 'none'}; found {', '.join(gains)}")
        names = plant.options.parameters
        for name in parameters:
            if name not in names:
                raise InputError(
                    f"'{name}' is not an argument of the compiled plant ({', '.join(names) or 'it has none'}); "
                    "name it when compiling"
                )
        varied = {name: _rows(name, gains[name], n) for name in loop.gains}
        masses = {name: _column({**plant.parameters, **parameters}[name]) for name in names}
        q, v = _rows("start", start, n), _rows("start_velocity", 0.0 if start_velocity is None else start_velocity, n)
        counts = {len(x) for x in (*varied.values(), *masses.values(), q, v)} - {1}
        if len(counts) > 1:
            raise InputError(f"what varies must agree in the number of runs, found {sorted(counts)}")
        self.count = counts.pop() if counts else 1
        self.gains = {name: self._all(x) for name, x in varied.items()}
        self.parameters = {name: self._all(x)[:, 0] for name, x in masses.items()}
        closed = plant.batch.close(q)
        self.start, self.velocity = self._all(q), self._all(v)
        memory, none = np.zeros((self.count, loop.memory)), np.zeros((self.count, 0))
        self.state = np.concatenate([self._all(closed), self.velocity, memory], axis=1)
        own = (*self.gains.values(), *(x[:, None] for x in self.parameters.values()))
        self.given = np.concatenate([none, *own], axis=1)
        if not (np.isfinite(self.state).all() and np.isfinite(self.given).all()):
            raise InputError("gains, parameters and initial states must be finite")

    def _all(self, values: Array) -> Array:
        return np.broadcast_to(values, (self.count, values.shape[1]))


def _rows(name: str, values: npt.ArrayLike, n: int) -> Array:
    """A scalar, (n,), (N,) for gains, or (N, n), as (1 or N, n)."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim == 0:
        return np.full((1, n), float(array))
    if array.ndim == 1 and name in ("start", "start_velocity"):
        return as_vector(name, array, n)[None, :]
    if array.ndim == 1:
        return np.repeat(array[:, None], n, axis=1)
    if array.ndim != 2 or array.shape[1] != n:
        raise InputError(f"{name} must have shape (N,) or (N, {n}), found {array.shape}")
    return array


def _column(values: npt.ArrayLike) -> Array:
    """A number or (N,) as (1 or N, 1)."""
    return np.atleast_1d(np.asarray(values, dtype=np.float64))[:, None]
