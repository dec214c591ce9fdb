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
from typing import Unpack, overload

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
from cutjoint.compile.many.options import LoopOptions, ManyOptions, RunOptions
from cutjoint.compile.many.results import INTERRUPTED, Many, Outcome
from cutjoint.compile.many.sinks import Asked, Into, sink_of
from cutjoint.compile.many.statistics import Summary
from cutjoint.compile.many.traced import traced_loop
from cutjoint.compile.many.variation import Variation, whole
from cutjoint.compile.once import once
from cutjoint.control import Law, fitted_law
from cutjoint.doors import door
from cutjoint.errors import InputError, Interrupted
from cutjoint.mechanism import Mechanism
from cutjoint.motion import Desired, Reference
from cutjoint.reprs import line
from cutjoint.simulation.hardware import Hardware
from cutjoint.simulation.hardware.checks import check_robot, check_span
from cutjoint.simulation.hardware.control import control_of, limits_of
from cutjoint.simulation.integrators import fixed_step

LARGEST_RECORD = 2**31
"""Records beyond this many bytes are refused; a larger `every` makes them smaller."""
CHUNK = 2**26
"""Bytes of the records of a chunk where nobody says how many runs it has."""


@door
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
        varying: names of the hardware's numbers that vary, such as `encoder.noise`, one number an actuator.
        method: integrator of fixed step, a name of `cutjoint.simulation.integrators.FIXED_STEP`.

    Raises:
        InputError: the law cannot be traced, or its model cannot follow the measured state.
        ActuationError: the actuators do not determine the motion of the plant, or its idle freedoms gain momentum.
    """

    __repr__ = line("law", "robot")

    def __init__(
        self,
        plant: Compiled,
        law: Law | Callable[..., npt.ArrayLike],
        mechanism: Mechanism,
        *,
        gains: tuple[str, ...] = (),
        rate: float | None = None,
        limits: npt.ArrayLike | None = None,
        hardware: Hardware | None = None,
        varying: tuple[str, ...] = (),
        method: str = "rk4",
    ) -> None:
        fixed_step(method)
        law = fitted_law(law, plant.n)
        bounds = limits_of(limits, plant.n)
        control = control_of(hardware, rate, None if bounds is None else np.broadcast_to(bounds, plant.n))
        if isinstance(control, Hardware):
            check_robot(control, plant, ())
        self.traced = traced_loop(plant, law, mechanism, tuple(gains), control, method, tuple(varying))
        self.plant, self.law, self.mechanism, self.sizes = plant, law, mechanism, self.traced.parts.sizes
        self._lock = threading.RLock()

    def __reduce__(self) -> tuple[object, ...]:
        loop, hardware = self.traced, self.traced.hardware
        limits = None if isinstance(loop.control, Hardware) else loop.control
        made = partial(
            ClosedLoop,
            gains=loop.gains,
            limits=limits,
            hardware=hardware,
            varying=loop.varying,
            method=loop.method,
        )
        return made, (self.plant, self.law, self.mechanism)

    @once
    def _runs(self) -> Runs:
        options = self.plant.options
        return backend(options.backend).runs(self.traced.parts, fast=options.fast)

    def reference_table(self, reference: Reference, step: float, steps: int) -> Array:
        """What the loop reads of a reference over so many steps: at every half step under continuous control, at every
        step otherwise; shape (instants, columns).

        Raises:
            UnreachableError: the reference leaves the workspace.
        """
        halves = self.traced.rows_per_step
        rows = np.empty((halves * steps + 1, self.sizes.columns))
        for k in range(len(rows)):
            desired: Desired = reference.at(step / halves * k)
            rows[k] = np.concatenate([np.ravel(filler(desired)) for filler in self.traced.desired.fillers])
        return rows

    def run(self, reference: Reference | Array, **options: Unpack[LoopOptions]) -> Many:
        """Simulate all runs; see `simulate_many`.  `reference` may be a table that `reference_table` made, or `table`
        one that it made of the reference.  Chance is that of the runs from `first_run` on, and begins again after
        `chance_again` runs."""
        asked = self._asked(reference, options)
        if (taken := asked.variation.count * self.record(asked.grid)) > LARGEST_RECORD:
            raise InputError(
                f"{asked.variation.count} runs of {len(asked.grid.chosen)} samples would take {taken / 2**30:.1f} GiB; "
                f"record less often (every={asked.grid.step * asked.grid.stride:g} s now), or take them in chunks "
                "(into=)"
            )
        return self._chunk(asked, 0, asked.variation.count, options.get("threads"), options.get("progress"))

    def stream(
        self, reference: Reference | Array, into: Into, *, chunk: int | None = None, **options: Unpack[LoopOptions]
    ) -> Summary:
        """Simulate all runs, `chunk` of them at a time, and hand each chunk on; see `simulate_many`."""
        asked = self._asked(reference, options)
        count = asked.variation.count
        size = max(8, CHUNK // self.record(asked.grid)) if chunk is None else whole("chunk", chunk)
        summary, progress = Summary(), options.get("progress")
        with sink_of(into, self.traced, asked) as sink:
            for begin in range(0, count, size):
                end = min(begin + size, count)

                def tell(part: float, begin: int = begin, end: int = end) -> None:
                    if progress is not None:
                        progress((begin + part * (end - begin)) / count)

                try:
                    many = self._chunk(asked, begin, end, options.get("threads"), tell)
                except KeyboardInterrupt as error:
                    if isinstance(error, Interrupted) and isinstance(error.result, Many):
                        sink.take(begin, error.result)
                        summary = summary.extended(error.result)
                    raise Interrupted(
                        f"interrupted; {summary.runs} of {count} runs are done",
                        done=summary.runs / count,
                        result=summary,
                    ) from error
                sink.take(begin, many)
                summary = summary.extended(many)
        return summary

    def record(self, grid: TimeGrid) -> int:
        """Bytes that the record of a run takes."""
        return 8 * len(grid.chosen) * self.sizes.width

    def _asked(self, reference: Reference | Array, options: LoopOptions) -> Asked:
        """What is asked for, checked."""
        hardware, size = self.traced.hardware, positive("step", options.get("step", 1e-3), "s")
        tick, duration, every = None, options.get("duration"), options.get("every")
        if hardware is not None:
            tick = hardware.ticks.length
        if isinstance(reference, Reference):
            span = positive("duration", reference.duration if duration is None else duration, "s")
            grid = time_grid(span, size, tick, every)
            table, wanted = options.get("table"), (self.traced.rows_per_step * grid.steps + 1, self.sizes.columns)
            rows = self.reference_table(reference, grid.step, grid.steps) if table is None else table
            if rows.shape != wanted:
                raise InputError(f"the table of the reference must have shape {wanted}, found {rows.shape}")
        else:
            rows = np.ascontiguousarray(reference)
            steps = (len(rows) - 1) // self.traced.rows_per_step
            grid = time_grid(steps * size, size, tick, every)
            if grid.steps != steps:
                raise InputError(f"a table of {steps} steps goes with steps of {grid.step:g} s, found step={size:g}")
        if hardware is not None:
            check_span(hardware, grid.step * grid.steps)
        start = options.get("start")
        variation = Variation(
            self.traced,
            options.get("gains") or {},
            options.get("parameters") or {},
            rows[:1, 1 : 1 + self.plant.n] if start is None else start,
            options.get("start_velocity"),
            options.get("runs"),
            options.get("first_run", 0),
            options.get("chance_again"),
            options.get("hardware_numbers"),
        )
        return Asked(reference, rows, grid, variation)

    def _chunk(
        self, asked: Asked, begin: int, end: int, threads: int | None, progress: Callable[[float], None] | None
    ) -> Many:
        """Some of the runs."""
        part, loop = asked.variation.part(begin, end), self.traced
        chances = None
        if loop.hardware is not None:
            chances = Chances(loop.hardware, asked.grid, self.sizes.noise)
        blocks = Blocks(self._runs, self.sizes, part, asked.rows, asked.grid, chances)
        try:
            blocks.go(cores() if threads is None else max(1, threads), progress)
        except KeyboardInterrupt as error:
            ready, many = blocks.whole, None
            if ready:
                part = asked.variation.part(begin, begin + ready)
                outcome = Outcome(loop, part, blocks.records[:ready], blocks.sums[:ready], asked.grid)
                many = outcome.many(asked.reference, again=False)
            raise Interrupted(INTERRUPTED.format(ready), done=ready / blocks.count, result=many) from error
        return Outcome(loop, part, blocks.records, blocks.sums, asked.grid).many(asked.reference)


@overload
def simulate_many(
    plant: Compiled,
    law: Law | Callable[..., npt.ArrayLike],
    reference: Reference,
    *,
    into: None = None,
    **options: Unpack[ManyOptions],
) -> Many: ...


@overload
def simulate_many(
    plant: Compiled,
    law: Law | Callable[..., npt.ArrayLike],
    reference: Reference,
    *,
    into: Into,
    **options: Unpack[ManyOptions],
) -> Summary: ...


# long: its arguments and what they mean
@door
def simulate_many(
    plant: Compiled,
    law: Law | Callable[..., npt.ArrayLike],
    reference: Reference,
    *,
    gains: Mapping[str, npt.ArrayLike] | None = None,
    parameters: Mapping[str, npt.ArrayLike] | None = None,
    start: npt.ArrayLike | None = None,
    start_velocity: npt.ArrayLike | None = None,
    runs: int | None = None,
    step: float = 1e-3,
    method: str = "rk4",
    duration: float | None = None,
    every: float | None = None,
    rate: float | None = None,
    limits: npt.ArrayLike | None = None,
    hardware: Hardware | None = None,
    hardware_numbers: Mapping[str, npt.ArrayLike] | None = None,
    into: Into | None = None,
    chunk: int | None = None,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Many | Summary:
    """Simulate N closed loops that differ in gains, parameters, initial states, or chance alone.

    Args:
        plant: a compiled chain or published model.
        law: the controller, or a function (t, desired, q, v) -> efforts; its own code is traced.
        reference: what all runs follow.
        gains: gain of the law -> shape (N,) (all actuators alike) or (N, n).
        parameters: inertial parameter that is an argument of `plant` -> shape (N,) [kg].
        start: actuated coordinates at time 0, shape (N, n) or (n,); default those of the reference.
        start_velocity: their velocities; default at rest.
        runs: N, where nothing varies but noise and jitter of the hardware.
        step: longest step of the integrator [s]; whole ones fill the run, or a tick of the controller's clock.
        method: integrator: `rk4`, or `midpoint` of order 2, with half the work a step.
        duration: [s]; default that of the reference.
        every: distance of the samples [s]; default only the first and the last.
        rate: of the controller [Hz], whose effort is held in between (zero-order hold); default continuous control.
        limits: largest |effort|, scalar or one an actuator.
        hardware: all that is between law and joints, in place of rate and limits.  Run k has the noise and jitter of
            `run(..., run_number=k)`.
        hardware_numbers: number of the hardware, such as `encoder.noise` -> shape (N,) or (N, n).
        into: where the runs go, a chunk at a time, so that memory stays bounded: a function of the number of the first
            run and a `Many`, or the path of a Parquet file (needs the extra `parquet`).
        chunk: runs a chunk; default as many as have records of 64 MiB.
        threads: processor cores to use; default all.
        progress: called with the fraction that is done.

    Returns:
        The samples and the errors of all runs, or where they go elsewhere (`into`) their statistics.  A run that came
        where the compiled plant must not be trusted is done again by the model itself; if that cannot go on either, it
        stands in `failed`.

    Raises:
        InputError: shapes do not agree, a gain or parameter does not exist, or the law cannot be traced.
        UnreachableError: the reference leaves the workspace.
        ClosureError, SingularError: a run cannot start.
        Interrupted: a `KeyboardInterrupt` (Ctrl-C) came; it is one, and holds the first runs that were done.  What
            goes elsewhere (`into`) has been handed on, the last chunk being shorter.
    """
    loop = ClosedLoop(
        plant,
        law,
        reference.mechanism,
        gains=tuple(gains or ()),
        rate=rate,
        limits=limits,
        hardware=hardware,
        varying=tuple(hardware_numbers or ()),
        method=method,
    )
    options = RunOptions(
        step=step,
        duration=duration,
        every=every,
        gains=gains,
        parameters=parameters,
        hardware_numbers=hardware_numbers,
        start=start,
        start_velocity=start_velocity,
        runs=runs,
        threads=threads,
        progress=progress,
    )
    if into is None:
        return loop.run(reference, **options)
    return loop.stream(reference, into, chunk=chunk, **options)
