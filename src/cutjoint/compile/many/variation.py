"""What varies from run to run: gains, parameters, initial states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, as_vector
from cutjoint.compile.many.hardware_numbers import arguments_of
from cutjoint.compile.many.traced import TracedLoop
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.errors import InputError
from cutjoint.simulation.hardware.numbers import with_numbers


@dataclass(frozen=True, eq=False)
class SomeRuns:
    """Some runs in a row.

    Attributes:
        numbers: of the runs, for their chance, shape (N,).
        gains, parameters, hardware: name -> shape (N, n), (N,), (N, n).
        start, velocity: actuated coordinates and velocities at the beginning, shape (N, n).
        state, given: what the compiled loop takes, shape (N, size).
    """

    numbers: range | list[int]
    gains: Mapping[str, Array]
    parameters: Mapping[str, Array]
    hardware: Mapping[str, Array]
    start: Array
    velocity: Array
    state: Array
    given: Array


class Variation:
    """What varies: initial states and per-run arguments of all runs.

    Args:
        loop: the loop.
        gains, parameters, start, start_velocity, numbers: see `simulate_many`; the last one is `hardware_numbers`.
        runs: how many, where nothing varies but chance.
        first: number of the first run, for its chance.
        again: after how many runs numbers begin again; None for never.

    Attributes:
        count: number of runs.

    Raises:
        InputError: shapes do not agree, names are not there, or numbers are not finite.
    """

    def __init__(
        self,
        loop: TracedLoop,
        gains: Mapping[str, npt.ArrayLike],
        parameters: Mapping[str, npt.ArrayLike],
        start: npt.ArrayLike,
        start_velocity: npt.ArrayLike | None,
        runs: int | None = None,
        first: int = 0,
        again: int | None = None,
        numbers: Mapping[str, npt.ArrayLike] | None = None,
    ) -> None:
        n, plant = loop.plant.n, loop.plant
        self.loop, self.first = loop, first
        self._again = None if again is None else whole("chance_again", again)
        if isinstance(first, bool) or not isinstance(first, int) or first < 0:
            raise InputError(f"first_run must be a whole number >= 0, found {first!r}")
        if set(gains) != set(loop.gains):
            raise InputError(f"gains must be given for {', '.join(loop.gains) or 'none'}; found {', '.join(gains)}")
        names = plant.options.parameters
        values: dict[str, npt.ArrayLike] = {**plant.parameters, **plant.arrays(parameters)}
        self.gains = {name: rows_of(name, gains[name], n) for name in loop.gains}
        self.parameters = {name: _column(values[name]) for name in names}
        self.hardware = _numbers(loop, numbers or {})
        self.start = rows_of("start", start, n)
        self.velocity = rows_of("start_velocity", 0.0 if start_velocity is None else start_velocity, n)
        varied = (*self.gains.values(), *self.parameters.values(), *self.hardware.values(), self.start, self.velocity)
        counts = {len(x) for x in varied} - {1}
        if runs is not None:
            counts |= {whole("runs", runs)} - ({1} if counts else set())
        if len(counts) > 1:
            raise InputError(f"what varies must agree in the number of runs, found {sorted(counts)}")
        self.count = counts.pop() if counts else 1
        if not all(np.isfinite(x).all() for x in varied):
            raise InputError("gains, parameters, numbers of hardware and initial states must be finite")
        self._moved = isinstance(plant.source, ChainSource) and bool(plant.source.placing)
        self._closed = None if len(self.start) > 1 or self._moved else plant.batch.close(self.start)

    def given(self, begin: int, end: int) -> dict[str, Array]:
        """What the runs from `begin` to before `end` have of their own, by name: gains, parameters (N,), numbers of
        hardware, and `start` and `start_velocity` where these vary, else (N, n)."""
        part: dict[str, Array] = {}
        starts = {"start": self.start, "start_velocity": self.velocity}
        varied = {name: x for name, x in starts.items() if len(x) > 1}
        for name, values in (self.gains | self.parameters | self.hardware | varied).items():
            rows = np.broadcast_to(values if len(values) == 1 else values[begin:end], (end - begin, values.shape[1]))
            part[name] = rows[:, 0] if name in self.parameters else rows
        return part

    def part(self, begin: int, end: int) -> SomeRuns:
        """The runs from `begin` to before `end`.

        Raises:
            ClosureError, SingularError: one of them cannot start.
        """
        count = end - begin

        def some(values: Array) -> Array:
            return np.broadcast_to(values if len(values) == 1 else values[begin:end], (count, values.shape[1]))

        start, velocity = some(self.start), some(self.velocity)
        gains = {name: some(x) for name, x in self.gains.items()}
        columns = {name: some(x) for name, x in self.parameters.items()}
        hardware = {name: some(x) for name, x in self.hardware.items()}
        batch = self.loop.plant.batch
        if self._closed is not None:
            closed = some(self._closed)
        elif self._moved:
            closed = batch.close(start, {name: x[:, 0] for name, x in columns.items()})
        else:
            closed = batch.close(start)
        state = np.concatenate([closed, velocity, np.zeros((count, self.loop.behind))], axis=1)
        arguments = arguments_of(self.loop.hardware, hardware)
        given = np.concatenate([np.zeros((count, 0)), *gains.values(), *columns.values(), *arguments], axis=1)
        own = {name: x[:, 0] for name, x in columns.items()}
        chance: range | list[int] = range(self.first + begin, self.first + end)
        if self._again is not None:
            chance = [self.first + run % self._again for run in range(begin, end)]
        return SomeRuns(chance, gains, own, hardware, start, velocity, state, given)


def _numbers(loop: TracedLoop, numbers: Mapping[str, npt.ArrayLike]) -> dict[str, Array]:
    """Numbers of hardware as (1 or N, n), whose ends can be."""
    if set(numbers) != set(loop.varying):
        raise InputError(
            f"hardware_numbers must be given for {', '.join(loop.varying) or 'none'}; found {', '.join(numbers)}"
        )
    found = {name: rows_of(name, numbers[name], loop.plant.n) for name in loop.varying}
    for name, rows in found.items():
        for end in (rows.min(axis=0), rows.max(axis=0)):
            assert loop.hardware is not None
            with_numbers(loop.hardware, {name: end})
    return found


def whole(name: str, value: int) -> int:
    """A whole number >= 1."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise InputError(f"{name} must be a whole number >= 1, found {value!r}")
    return int(value)


def rows_of(name: str, values: npt.ArrayLike, n: int) -> Array:
    """A scalar, (n,), (N,) for gains, or (N, n), as (1 or N, n)."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim == 0:
        return np.full((1, n), float(array))
    if array.ndim == 1 and name in ("start", "start_velocity"):
        return as_vector(name, array, n)[None, :]
    if array.ndim == 1:
        return np.broadcast_to(array[:, None], (len(array), n))
    if array.ndim != 2 or array.shape[1] != n:
        raise InputError(f"{name} must have shape (N,) or (N, {n}), found {array.shape}")
    return array


def _column(values: npt.ArrayLike) -> Array:
    """A number or (N,) as (1 or N, 1)."""
    return np.atleast_1d(np.asarray(values, dtype=np.float64))[:, None]
