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
from typing import Any

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, positive
from cutjoint.compile.batch import cores
from cutjoint.compile.compiler import Compiled
from cutjoint.compile.equations.reduction import STRAIN_LIMIT
from cutjoint.compile.expressions.functions import absolute, maximum
from cutjoint.compile.expressions.graph import Graph, Number
from cutjoint.compile.expressions.program import Program
from cutjoint.compile.expressions.straight_line import assemble
from cutjoint.compile.functions.table import accelerations
from cutjoint.compile.machine.llvm.native import PREAMBLE, Machine, host
from cutjoint.compile.machine.llvm.run_loop import run_loop
from cutjoint.compile.machine.llvm.text import declarations, flat_function
from cutjoint.compile.machine.runs import Sizes
from cutjoint.compile.machine.schedule import scheduled
from cutjoint.compile.many_results import Many, Outcome
from cutjoint.compile.many_variations import Variation
from cutjoint.compile.once import once
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.compile.sources.law import Table, TracedDesired, trace_law
from cutjoint.control import Law
from cutjoint.errors import InputError
from cutjoint.mechanism import Mechanism
from cutjoint.motion import Desired, Reference
from cutjoint.simulation import ReducedPlant

LARGEST_RECORD = 2**31
"""Records beyond this many bytes are refused; a larger `every` makes them smaller."""
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
        variation = Variation(self, gains or {}, parameters or {}, q0, start_velocity)
        count, samples = variation.count, -(-steps // stride) + 1
        width = self.sizes.state + self.sizes.watched
        if count * samples * width * 8 > LARGEST_RECORD:
            raise InputError(
                f"{count} runs of {samples} samples would take {count * samples * width * 8 / 2**30:.1f} GiB; record "
                "less "
                f"often: every={size * stride} s now"
            )
        records, sums = self._simulate(variation, rows, steps, stride, size, samples, threads, progress)
        return Outcome(self, variation, rows, records, sums, steps, stride, size, progress).many(reference)

    def _simulate(
        self,
        variation: Variation,
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
