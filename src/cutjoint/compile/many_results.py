"""What many runs are given and what they give; runs that left what is compiled for are done again by the model."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Values, as_vector, readonly
from cutjoint.compile.many_loop import TimeGrid, TracedLoop
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.control import Law
from cutjoint.control.law import Gain
from cutjoint.errors import CutjointError, InputError
from cutjoint.motion import Reference
from cutjoint.simulation import ReducedPlant, RungeKutta4
from cutjoint.simulation import run as simulate

RESIDUAL_LIMIT = 1e-6
"""A run whose loops were open by more than this before any settling step is not trusted [rad, or robot lengths]."""

_PER_RUN = ("q", "v", "effort", "positions", "error_rms", "error_max", "effort_max")


@dataclass(frozen=True, eq=False)
class Many(Values):
    """N runs of a robot with n actuators, m samples each.

    Attributes:
        time: of the samples, shape (m,) [s].
        q, v, effort: actuated coordinates, velocities and efforts, shape (N, m, n).
        positions: all position variables, shape (N, m, positions).
        error_rms: root mean square of desired minus actual coordinate over all steps, shape (N, n).
        error_max: largest of it, shape (N, n).
        effort_max: largest |effort|, shape (N, n).
        failed: run -> why it could not be simulated to its end.  Its numbers are NaN.
        slow: runs that left what is compiled for and were done by the model itself.
    """

    time: Array
    q: Array
    v: Array
    effort: Array
    positions: Array
    error_rms: Array
    error_max: Array
    effort_max: Array
    failed: Mapping[int, str]
    slow: tuple[int, ...]

    def __post_init__(self) -> None:
        for name in ("time", *_PER_RUN):
            getattr(self, name).setflags(write=False)


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
        values: dict[str, npt.ArrayLike] = {**plant.parameters, **plant.arrays(parameters)}
        varied = {name: _rows(name, gains[name], n) for name in loop.gains}
        masses = {name: _column(values[name]) for name in names}
        q, v = _rows("start", start, n), _rows("start_velocity", 0.0 if start_velocity is None else start_velocity, n)
        counts = {len(x) for x in (*varied.values(), *masses.values(), q, v)} - {1}
        if len(counts) > 1:
            raise InputError(f"what varies must agree in the number of runs, found {sorted(counts)}")
        self.count = counts.pop() if counts else 1
        self.gains = {name: self._all(x) for name, x in varied.items()}
        self.parameters = {name: self._all(x)[:, 0] for name, x in masses.items()}
        moved = isinstance(plant.source, ChainSource) and bool(plant.source.placing)
        closed = plant.batch.close(self._all(q), self.parameters) if moved else plant.batch.close(q)
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


class Outcome:
    """Turns what the compiled loop left into a `Many`, and does again by the model what it could not do."""

    def __init__(self, loop: TracedLoop, variation: Variation, records: Array, sums: Array, times: TimeGrid) -> None:
        source, n, steps = loop.plant.source, loop.plant.n, times.steps
        p = source.positions
        self.loop, self.variation, self.times = loop, variation, times
        self.time = times.step * np.array(times.chosen, dtype=np.float64)
        self.positions = records[:, :, :p]
        self.q = records[:, :, list(source.actuated)] if isinstance(source, ChainSource) else self.positions
        self.v = records[:, :, p : p + n]
        self.effort = records[:, :, loop.sizes.state : loop.sizes.state + n]
        self.effort_max = sums[:, 0 : 2 * n : 2]
        self.error_max = sums[:, 2 * n : 4 * n : 2]
        self.error_rms = np.sqrt(sums[:, 2 * n + 1 : 4 * n + 1 : 2] / (steps + 1))
        broken = (sums[:, 4 * n] <= steps) | (sums[:, 4 * n + 1] > RESIDUAL_LIMIT) | ~np.isfinite(sums).all(axis=1)
        self.broken = np.flatnonzero(broken | ~np.isfinite(records[:, -1]).all(axis=1)).tolist()

    def many(self, reference: Reference | Array) -> Many:
        """The result."""
        arrays = {name: np.array(getattr(self, name), dtype=np.float64) for name in _PER_RUN}
        failed: dict[int, str] = {}
        for run in self.broken:
            for array in arrays.values():
                array[run] = np.nan
            try:
                found = self._by_model(run, reference)
            except CutjointError as error:
                failed[run] = str(error)
                continue
            for name, values in found.items():
                arrays[name][run] = values
        slow = tuple(run for run in self.broken if run not in failed)
        return Many(time=readonly(self.time), failed=failed, slow=slow, **arrays)

    def _by_model(self, run: int, reference: Reference | Array) -> dict[str, Array]:
        """One run by the model that is not compiled, with the same integrator.

        Raises:
            SimulationError: it cannot be simulated to its end.
        """
        loop, variation, times = self.loop, self.variation, self.times
        if not isinstance(reference, Reference):
            raise InputError(
                "the run left what is compiled for; give the reference itself to have it done by the model"
            )
        values = {name: float(column[run]) for name, column in variation.parameters.items()}
        model = loop.plant.with_parameters(values).plain
        gains = {name: column[run] for name, column in variation.gains.items()}
        result = simulate(
            ReducedPlant(model),
            _with_gains(loop.law, gains),
            reference,
            integrator=RungeKutta4(times.step),
            duration=times.step * times.steps,
            limits=loop.limits,
            start=model.close(variation.start[run]),
            start_velocity=variation.velocity[run],
        )
        chosen = times.chosen
        error = result.desired_q - result.q
        places = result.q if loop.plant.source.positions == loop.plant.n else result.q_full
        return {
            "q": result.q[chosen],
            "v": result.v[chosen],
            "effort": result.effort[chosen],
            "positions": places[chosen],
            "error_rms": np.sqrt(np.mean(error**2, axis=0)),
            "error_max": np.abs(error).max(axis=0),
            "effort_max": np.abs(result.effort).max(axis=0),
        }


def _with_gains(law: Law, gains: Mapping[str, Array]) -> Law:
    """A copy of a law with other gains."""
    other = copy.copy(law)
    for name, value in gains.items():
        setattr(other, name, Gain(name, value))
    return other
