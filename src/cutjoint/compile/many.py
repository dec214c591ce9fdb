"""Many runs of one closed loop at once: gains, inertial parameters and initial states vary from run to run.

Controller, plant and integrator are one compiled loop.  The plant is integrated in its position variables (for a chain
all joints) and the velocities of the actuators; for a chain each step ends with one Newton step onto the loops, so
nothing drifts.  The controller acts continuously, at every stage of the integrator, as in `cutjoint.simulation.run`
without a rate.
"""

from __future__ import annotations

import ctypes
import math
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, as_vector, positive, readonly
from cutjoint.compile.batch import cores
from cutjoint.compile.chain_trace import ChainSource
from cutjoint.compile.compiled import Compiled
from cutjoint.compile.emit import declarations, flat_function
from cutjoint.compile.graph import Graph, Number, absolute, maximum
from cutjoint.compile.kernels import accelerations
from cutjoint.compile.law_trace import Table, TracedDesired, trace_law
from cutjoint.compile.native import PREAMBLE, Machine, host
from cutjoint.compile.once import once
from cutjoint.compile.program import Program, assemble
from cutjoint.compile.reduction import STRAIN_LIMIT
from cutjoint.compile.run_emit import Sizes, run_loop
from cutjoint.compile.schedule import scheduled
from cutjoint.control import Law
from cutjoint.errors import CutjointError, InputError
from cutjoint.mechanism import Mechanism
from cutjoint.motion import Desired, Reference
from cutjoint.simulation import ReducedPlant

LARGEST_RECORD = 2**31
"""Records beyond this many bytes are refused; a larger `every` makes them smaller."""
RESIDUAL_LIMIT = 1e-6
"""A run whose loops were open by more than this before any settling step is not trusted [rad, or robot lengths]."""
_CALL = ctypes.CFUNCTYPE(
    None,
    ctypes.c_int64,
    ctypes.c_int64,
    ctypes.c_int64,
    ctypes.c_int64,
    ctypes.c_double,
    ctypes.c_double,
    ctypes.c_void_p,
)


@dataclass(frozen=True, eq=False)
class Many:
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
        for name in ("time", "q", "v", "effort", "positions", "error_rms", "error_max", "effort_max"):
            getattr(self, name).setflags(write=False)

    def __reduce__(self) -> Any:
        return Many, tuple(getattr(self, field.name) for field in fields(self))


class ClosedLoop:
    """A plant, a law and what varies, compiled once; `run` then takes any number of runs.

    Args:
        plant: a compiled mechanism.  Its parameters that are arguments may vary.
        law: the controller.  Its own code is traced.
        mechanism: through whose inverse kinematics references are seen (see `Reference`).
        gains: names of the law's gains that vary, one number an actuator.
        limits: largest |effort|, scalar or one an actuator; default none.

    Raises:
        InputError: the law cannot be traced, or its model cannot follow the measured state.
        ActuationError: the actuators do not determine the motion of the plant, or its idle freedoms gain momentum.
    """

    def __init__(
        self,
        plant: Compiled,
        law: Law,
        mechanism: Mechanism,
        *,
        gains: tuple[str, ...] = (),
        limits: npt.ArrayLike | None = None,
    ) -> None:
        self.plant, self.law, self.mechanism, self.gains = plant, law, mechanism, tuple(gains)
        self._lock = threading.RLock()
        if isinstance(plant.source, ChainSource) and not plant.source.determined:
            plant.model.terms(plant.home)  # raises: the actuators do not determine the motion
        ReducedPlant(plant)  # raises: idle freedoms gain momentum, so these are not all coordinates of the motion
        n = self.n = plant.n
        self.limits = None if limits is None else np.broadcast_to(np.asarray(limits, dtype=np.float64), (n,))
        memory = self.memory = law.memory(n)
        positions = self.positions = plant.source.positions
        graph = Graph()
        state = graph.symbols(positions + n + memory)
        given = {name: graph.symbols(n) for name in self.gains}
        parameters = graph.symbols(len(plant.options.parameters))
        table = self.table = Table(graph)
        v = state[positions : positions + n]
        traced = plant.source.state(graph, state[:positions], parameters)
        desired = TracedDesired(table, n, mechanism)
        asked = trace_law(law, table, desired, traced, v, state[positions + n :], given, self.limits, plant)
        a, factor = accelerations(traced, v, asked.effort)
        errors = [x - y for x, y in zip(desired.q, traced.actuated, strict=True)]
        rate = [*traced.position_rate(v), *a, *asked.memory_rate]
        own = [*(x for xs in given.values() for x in xs), *parameters]
        fused = host().fused
        self.rate = scheduled(
            assemble(
                graph,
                "rate",
                {"state": state, "row": table.symbols, "given": own},
                {"rate": rate, "watched": [*asked.effort, *errors], "strain": [factor.strain]},
                fused=fused,
            )
        )
        self.settle: Program | None = None
        settled, residuals = traced.settled(None)
        if residuals:
            gaps: dict[bool, Number] = {True: 0.0, False: 0.0}
            assert isinstance(plant.source, ChainSource)
            for residual, is_length in zip(residuals, plant.source.row_is_length, strict=True):
                gaps[is_length] = maximum(absolute(residual), gaps[is_length])
            open_by = maximum(gaps[True] * (1.0 / plant.source.chain.length), gaps[False])
            self.settle = scheduled(
                assemble(
                    graph,
                    "settle",
                    {"state": state, "row": table.symbols, "given": own},
                    {"state": settled, "residual": [open_by], "strain": [traced.strain]},
                    fused=fused,
                )
            )
        self.sizes = Sizes(len(state), len(table.symbols), len(own), 2 * n, positions if self.settle else 0)

    def __reduce__(self) -> Any:
        return _loop, (self.plant, self.law, self.mechanism, self.gains, self.limits)

    @once
    def _lanes(self) -> Any:
        return self._machine(host().lanes)

    @once
    def _scalar(self) -> Any:
        return self._machine(1)

    def _machine(self, lanes: int) -> Any:
        processor = host()
        fast = self.plant.options.fast
        parts = [PREAMBLE, declarations(processor.lanes)]
        for name, program in (("rate", self.rate), ("settle", self.settle)):
            if program is not None:
                parts.append(
                    flat_function(program, name, lanes, width=processor.lanes, fused=processor.fused, fast=fast)
                )
        parts.append(run_loop("runs", self.sizes, lanes))
        machine = Machine("\n".join(parts))
        return machine, _CALL(machine.address("runs"))

    def reference_table(self, reference: Reference, step: float, steps: int) -> Array:
        """What the loop reads of a reference at every half step, shape (2 steps + 1, columns).

        Raises:
            UnreachableError: the reference leaves the workspace.
        """
        rows = np.empty((2 * steps + 1, self.sizes.columns))
        for k in range(len(rows)):
            desired: Desired = reference.at(0.5 * step * k)
            rows[k] = np.concatenate([np.ravel(filler(desired)) for filler in self.table.fillers])
        return rows

    def run(
        self,
        reference: Reference | Array,
        *,
        step: float = 1e-3,
        duration: float | None = None,
        every: float | None = None,
        gains: Mapping[str, npt.ArrayLike] | None = None,
        parameters: Mapping[str, npt.ArrayLike] | None = None,
        start: npt.ArrayLike | None = None,
        start_velocity: npt.ArrayLike | None = None,
        threads: int | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Many:
        """Simulate all runs; see `simulate_many`.  `reference` may be a table that `reference_table` made."""
        size = positive("step", step, "s")
        if isinstance(reference, Reference):
            span = positive("duration", reference.duration if duration is None else duration, "s")
            steps = max(1, round(span / size))
            size = span / steps
            rows = self.reference_table(reference, size, steps)
        else:
            rows = np.ascontiguousarray(reference)
            steps = (len(rows) - 1) // 2
        stride = steps if every is None else max(1, round(positive("every", every, "s") / size))
        q0 = rows[:1, 1 : 1 + self.n] if start is None else start
        variation = _Variation(self, gains or {}, parameters or {}, q0, start_velocity)
        count, samples = variation.count, -(-steps // stride) + 1
        width = self.sizes.state + self.sizes.watched
        if count * samples * width * 8 > LARGEST_RECORD:
            raise InputError(
                f"{count} runs of {samples} samples would take {count * samples * width * 8 / 2**30:.1f} GiB; record "
                "less "
                f"often: every={size * stride} s now"
            )
        records, sums = self._simulate(variation, rows, steps, stride, size, samples, threads, progress)
        return _Outcome(self, variation, rows, records, sums, steps, stride, size, progress).many(reference)

    def _simulate(
        self,
        variation: _Variation,
        rows: Array,
        steps: int,
        stride: int,
        size: float,
        samples: int,
        threads: int | None,
        progress: Callable[[float], None] | None,
    ) -> tuple[Array, Array]:
        """Records (N, samples, state + watched) and sums (N, 2 watched + 2)."""
        lanes = 1 if variation.count == 1 else host().lanes
        call = (self._scalar if lanes == 1 else self._lanes)[1]
        count = variation.count
        groups = -(-count // lanes)
        state, given = _grouped(variation.state, groups, lanes), _grouped(variation.given, groups, lanes)
        width, totals = self.sizes.state + self.sizes.watched, 2 * self.sizes.watched + 2
        records, sums = _aligned((groups, samples, width, lanes)), _aligned((groups, totals, lanes))
        addresses = [state.ctypes.data, given.ctypes.data, rows.ctypes.data, records.ctypes.data, sums.ctypes.data]
        table = np.array([*addresses, samples], dtype=np.int64)
        workers = min(cores() if threads is None else max(1, threads), groups)
        # a block is about a million evaluations: often enough to report, seldom enough not to matter
        block = max(1, min(-(-groups // workers), 250_000 // (steps * lanes) + 1))
        edges = list(range(0, groups, block))

        def work(begin: int) -> None:
            call(begin, min(begin + block, groups), steps, stride, size, STRAIN_LIMIT, table.ctypes.data)

        if workers == 1:
            for done, begin in enumerate(edges, start=1):
                work(begin)
                if progress is not None:
                    progress(done / len(edges))
        else:
            with ThreadPoolExecutor(workers) as pool:
                for done, _ in enumerate(pool.map(work, edges), start=1):
                    if progress is not None:
                        progress(done / len(edges))
        flat = records.transpose(0, 3, 1, 2).reshape(groups * lanes, samples, width)[:count]
        return flat, sums.transpose(0, 2, 1).reshape(groups * lanes, totals)[:count]


def _loop(
    plant: Compiled, law: Law, mechanism: Mechanism, gains: tuple[str, ...], limits: npt.ArrayLike | None
) -> ClosedLoop:
    return ClosedLoop(plant, law, mechanism, gains=gains, limits=limits)


class _Variation:
    """What varies: initial states and per-run arguments of all runs."""

    def __init__(
        self,
        loop: ClosedLoop,
        gains: Mapping[str, npt.ArrayLike],
        parameters: Mapping[str, npt.ArrayLike],
        start: npt.ArrayLike,
        start_velocity: npt.ArrayLike | None,
    ) -> None:
        n, plant = loop.n, loop.plant
        if set(gains) != set(loop.gains):
            raise InputError(f"gains must be given for {', '.join(loop.gains) or 'none'}; found {', '.join(gains)}")
        names = plant.options.parameters
        for name in parameters:
            if name not in names:
                raise InputError(
                    f"'{name}' is not an argument of the compiled plant ({', '.join(names) or 'it has none'}); name "
                    "it when "
                    "compiling"
                )
        columns: list[Array] = [_rows(name, gains[name], n) for name in loop.gains]
        masses = {**plant.parameters, **parameters}
        columns += [_column(masses[name]) for name in names]
        q, v = _rows("start", start, n), _rows("start_velocity", 0.0 if start_velocity is None else start_velocity, n)
        counts = {len(x) for x in (*columns, q, v)} - {1}
        if len(counts) > 1:
            raise InputError(f"what varies must agree in the number of runs, found {sorted(counts)}")
        self.count = counts.pop() if counts else 1
        self.gains = {name: self._all(_rows(name, gains[name], n)) for name in loop.gains}
        self.parameters = {
            name: self._all(np.atleast_1d(np.asarray(masses[name], float))[:, None])[:, 0] for name in names
        }
        closed = plant.batch.close(q)
        self.start = self._all(q)
        self.velocity = self._all(v)
        memory = np.zeros((self.count, loop.memory))
        self.state = np.concatenate([self._all(closed), self.velocity, memory], axis=1)
        wide = [self._all(column) for column in columns]
        self.given = np.concatenate(wide, axis=1) if wide else np.zeros((self.count, 0))
        if not (np.isfinite(self.state).all() and np.isfinite(self.given).all()):
            raise InputError("gains, parameters and initial states must be finite")

    def _all(self, values: Array) -> Array:
        return np.broadcast_to(values, (self.count, values.shape[1]))


class _Outcome:
    """Turns what the compiled loop left into a `Many`, and does again by the model what it could not do."""

    def __init__(
        self,
        loop: ClosedLoop,
        variation: _Variation,
        rows: Array,
        records: Array,
        sums: Array,
        steps: int,
        stride: int,
        step: float,
        progress: Callable[[float], None] | None,
    ) -> None:
        n, p = loop.n, loop.positions
        self.loop, self.variation, self.step, self.steps, self.stride = loop, variation, step, steps, stride
        self.time = step * np.array([*range(0, steps, stride), steps], dtype=np.float64)
        self.positions = records[:, :, :p]
        source = loop.plant.source
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
        arrays: dict[str, Array] = {
            "q": np.array(self.q),
            "v": np.array(self.v),
            "effort": np.array(self.effort),
            "positions": np.array(self.positions),
            "error_rms": np.array(self.error_rms),
            "error_max": np.array(self.error_max),
            "effort_max": np.array(self.effort_max),
        }
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
        from cutjoint.simulation import RungeKutta4
        from cutjoint.simulation import run as simulate

        loop, variation = self.loop, self.variation
        if not isinstance(reference, Reference):
            raise InputError(
                "the run left what is compiled for; give the reference itself to have it done by the model"
            )
        values = {name: float(column[run]) for name, column in variation.parameters.items()}
        model = loop.plant.with_parameters(**values).plain
        gains = {name: column[run] for name, column in variation.gains.items()}
        result = simulate(
            ReducedPlant(model),
            _with_gains(loop.law, gains),
            reference,
            integrator=RungeKutta4(self.step),
            duration=self.step * self.steps,
            limits=loop.limits,
            start=model.close(variation.start[run]),
            start_velocity=variation.velocity[run],
        )
        chosen = [*range(0, self.steps, self.stride), self.steps]
        error = result.desired_q - result.q
        places = result.q if loop.positions == loop.n else result.q_full
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
    import copy

    from cutjoint.control.law import Gain

    other = copy.copy(law)
    for name, value in gains.items():
        setattr(other, name, Gain(name, value))
    return other


def simulate_many(
    plant: Compiled,
    law: Law,
    reference: Reference,
    *,
    gains: Mapping[str, npt.ArrayLike] | None = None,
    parameters: Mapping[str, npt.ArrayLike] | None = None,
    start: npt.ArrayLike | None = None,
    start_velocity: npt.ArrayLike | None = None,
    step: float = 1e-3,
    duration: float | None = None,
    every: float | None = None,
    limits: npt.ArrayLike | None = None,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Many:
    """Simulate N closed loops that differ in gains, parameters or initial states.

    Args:
        plant: a compiled chain or published model.
        law: the controller.
        reference: what all runs follow.
        gains: gain of the law -> shape (N,) (all actuators alike) or (N, n).
        parameters: inertial parameter that is an argument of `plant` -> shape (N,) [kg].
        start: actuated coordinates at time 0, shape (N, n) or (n,); default those of the reference.
        start_velocity: their velocities; default at rest.
        step: of the classical Runge-Kutta method [s].
        duration: [s]; default that of the reference.
        every: distance of the samples [s]; default only the first and the last.
        limits: largest |effort|, scalar or one an actuator.
        threads: processor cores to use; default all.
        progress: called with the fraction that is done.

    Returns:
        The samples and the errors of all runs.  A run that came where the compiled plant must not be trusted is done
        again by the model itself; if that cannot go on either, it stands in `failed`.

    Raises:
        InputError: shapes do not agree, a gain or parameter does not exist, or the law cannot be traced.
        UnreachableError: the reference leaves the workspace.
        ClosureError, SingularError: a run cannot start.
    """
    loop = ClosedLoop(plant, law, reference.mechanism, gains=tuple(gains or ()), limits=limits)
    return loop.run(
        reference,
        step=step,
        duration=duration,
        every=every,
        gains=gains,
        parameters=parameters,
        start=start,
        start_velocity=start_velocity,
        threads=threads,
        progress=progress,
    )


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


def _grouped(values: Array, groups: int, lanes: int) -> Array:
    """(N, k) as (groups, k, lanes); the last group is filled up with its last run."""
    index = np.minimum(np.arange(groups * lanes), len(values) - 1)
    made = _aligned((groups, values.shape[1], lanes))
    made[:] = values[index].reshape(groups, lanes, values.shape[1]).transpose(0, 2, 1)
    return made


def _aligned(shape: tuple[int, ...]) -> Array:
    """Zeros that start at a multiple of 64 bytes."""
    size = math.prod(shape)
    raw = np.zeros(size + 8)
    first = (-raw.ctypes.data % 64) // 8
    return raw[first : first + size].reshape(shape)
