"""Many runs of one closed loop at once: gains, inertial parameters and initial states vary from run to run.

Controller, plant and integrator are one compiled loop.  The plant is integrated in its position variables (for a chain
all joints) and the velocities of the actuators; for a chain each step ends with one Newton step onto the loops, so
nothing drifts.  The controller acts continuously, at every stage of the integrator, or at the instants of its hardware,
as in `cutjoint.simulation.run`.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, positive
from cutjoint.compile.batch import cores
from cutjoint.compile.compiler import Compiled
from cutjoint.compile.machine.backends import backend
from cutjoint.compile.machine.kernel import Runs
from cutjoint.compile.many.blocks import Blocks
from cutjoint.compile.many.grid import TimeGrid, time_grid
from cutjoint.compile.many.instants import Chances
from cutjoint.compile.many.results import Many, Outcome
from cutjoint.compile.many.traced import traced_loop
from cutjoint.compile.many.variation import Variation
from cutjoint.compile.once import once
from cutjoint.control import Law
from cutjoint.errors import InputError
from cutjoint.mechanism import Mechanism
from cutjoint.motion import Desired, Reference
from cutjoint.simulation.hardware import Clock, Drive, Hardware
from cutjoint.simulation.integrators import fixed_step

LARGEST_RECORD = 2**31
"""Records beyond this many bytes are refused; a larger `every` makes them smaller."""


class ClosedLoop:
    """A plant, a law and what varies, compiled once; `run` then takes any number of runs.

    Args:
        plant: a compiled mechanism.  Its parameters that are arguments may vary.
        law: the controller.  Its own code is traced.
        mechanism: through whose inverse kinematics references are seen (see `Reference`).
        gains: names of the law's gains that vary, one number an actuator.
        rate: of the controller [Hz], whose effort is held in between; default continuous control.
        limits: largest |effort|, scalar or one an actuator; default none.
        hardware: all that is between law and joints, in place of rate and limits.
        method: integrator of fixed step, a name of `cutjoint.simulation.integrators.FIXED_STEP`.

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
        rate: float | None = None,
        limits: npt.ArrayLike | None = None,
        hardware: Hardware | None = None,
        method: str = "rk4",
    ) -> None:
        fixed_step(method)
        control = _control(hardware, rate, limits, plant.n)
        self.traced = traced_loop(plant, law, mechanism, tuple(gains), control, method)
        self.plant, self.law, self.mechanism, self.sizes = plant, law, mechanism, self.traced.parts.sizes
        self._lock = threading.RLock()

    def __reduce__(self) -> tuple[object, ...]:
        loop, hardware = self.traced, self.traced.hardware
        limits = loop.control if hardware is None else None
        made = partial(ClosedLoop, gains=loop.gains, limits=limits, hardware=hardware, method=loop.method)
        return made, (self.plant, self.law, self.mechanism)

    @once
    def _runs(self) -> Runs:
        options = self.plant.options
        return backend(options.backend).runs(self.traced.parts, fast=options.fast)

    def grid(self, span: float, step: float, every: float | None) -> TimeGrid:
        """Steps of at most `step` [s] and samples `every` so many [s], over `span` [s].

        Raises:
            InputError: not positive, or a span that is no whole number of steps.
        """
        hardware = self.traced.hardware
        tick = None if hardware is None else hardware.ticks.length
        return time_grid(positive("duration", span, "s"), positive("step", step, "s"), tick, every)

    def reference_table(self, reference: Reference, grid: TimeGrid) -> Array:
        """What the loop reads of a reference: at every half step under continuous control, at every step otherwise;
        shape (instants, columns).

        Raises:
            UnreachableError: the reference leaves the workspace.
        """
        parts = 1 if grid.beat else 2
        rows = np.empty((parts * grid.steps + 1, self.sizes.columns))
        for k in range(len(rows)):
            desired: Desired = reference.at(grid.step * k / parts)
            rows[k] = np.concatenate([np.ravel(filler(desired)) for filler in self.traced.desired.fillers])
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
        times = TimeGrid(size, steps, stride)
        q0 = rows[:1, 1 : 1 + self.plant.n] if start is None else start
        variation = Variation(self.traced, gains or {}, parameters or {}, q0, start_velocity)
        taken = variation.count * len(times.chosen) * (self.sizes.state + self.sizes.watched) * 8
        if taken > LARGEST_RECORD:
            raise InputError(
                f"{variation.count} runs of {len(times.chosen)} samples would take {taken / 2**30:.1f} GiB; record "
                f"less often: every={size * stride} s now"
            )
        records, sums = self._simulate(variation, rows, times, threads, progress)
        return Outcome(self.traced, variation, records, sums, times).many(reference)

    def _simulate(
        self,
        variation: Variation,
        rows: Array,
        times: TimeGrid,
        threads: int | None,
        progress: Callable[[float], None] | None,
    ) -> tuple[Array, Array]:
        """Records (N, samples, state + watched) and sums (N, 2 watched + 2)."""
        lanes = 1 if variation.count == 1 else self._runs.lanes
        call = self._runs.loop(lanes)
        count, samples, steps = variation.count, len(times.chosen), times.steps
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
            call(begin, min(begin + block, groups), steps, times.stride, times.step, STRAIN_LIMIT, table.ctypes.data)

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
