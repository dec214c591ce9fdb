"""What many runs give; runs that left what is compiled for are done again by the model."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, Values, readonly
from cutjoint.compile.many.grid import TimeGrid
from cutjoint.compile.many.traced import TracedLoop
from cutjoint.compile.many.variation import SomeRuns
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.control import Law
from cutjoint.control.law import Gain
from cutjoint.errors import CutjointError, InputError, Interrupted
from cutjoint.motion import Reference
from cutjoint.reprs import line
from cutjoint.simulation import ReducedPlant
from cutjoint.simulation import run as simulate
from cutjoint.simulation.hardware import Hardware
from cutjoint.simulation.hardware.numbers import with_numbers
from cutjoint.simulation.integrators import fixed_step

RESIDUAL_LIMIT = 1e-6
"""A run whose loops were open by more than this before any settling step is not trusted [rad, or robot lengths]."""

SAMPLED = ("q", "v", "effort", "positions", "measured_q", "measured_v", "asked", "command")
"""The columns of `Many` that have samples."""
NOT_AGAIN = "it left what is compiled for, and was interrupted before the model had done it again"
INTERRUPTED = "interrupted; {} runs are done"
_PER_RUN = (*SAMPLED, "error_rms", "error_max", "effort_max")


@dataclass(frozen=True, eq=False)
class Many(Values):
    """N runs of a robot with n actuators, m samples each.

    Attributes:
        time: of the samples, shape (m,) [s].
        q, v, effort: actuated coordinates, velocities and efforts, shape (N, m, n).
        positions: all position variables, shape (N, m, positions).
        measured_q, measured_v, asked, command: what the law saw last of coordinates and velocities, what it asked for
            then, and the command in effect, shape (N, m, n); (N, m, 0) under continuous control.
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
    measured_q: Array
    measured_v: Array
    asked: Array
    command: Array
    error_rms: Array
    error_max: Array
    effort_max: Array
    failed: Mapping[int, str]
    slow: tuple[int, ...]

    __repr__ = line(
        "time",
        "q",
        "failed",
        "error_rms",
        "error_max",
        "effort_max",
        time="s",
        q="m or rad",
        error_rms="m",
        error_max="m",
        effort_max="N or N m",
    )

    def __post_init__(self) -> None:
        for name in ("time", *_PER_RUN):
            getattr(self, name).setflags(write=False)


class Outcome:
    """Turns what the compiled loop left into a `Many`, and does again by the model what it could not do."""

    def __init__(self, loop: TracedLoop, part: SomeRuns, records: Array, sums: Array, times: TimeGrid) -> None:
        source, n, steps, sizes = loop.plant.source, loop.plant.n, times.steps, loop.parts.sizes
        p = source.positions
        self.loop, self.part, self.times = loop, part, times
        self.time = times.step * np.array(times.chosen, dtype=np.float64)
        positions = records[:, :, :p]
        shown = records[:, :, sizes.state + sizes.watched :]
        measured_q, measured_v, asked, command = np.split(shown, 4, axis=2)
        self.arrays = {
            "q": records[:, :, list(source.actuated)] if isinstance(source, ChainSource) else positions,
            "v": records[:, :, p : p + n],
            "effort": records[:, :, sizes.state : sizes.state + n],
            "positions": positions,
            "measured_q": measured_q,
            "measured_v": measured_v,
            "asked": asked,
            "command": command,
            "error_rms": np.sqrt(sums[:, 2 * n + 1 : 4 * n + 1 : 2] / (steps + 1)),
            "error_max": sums[:, 2 * n : 4 * n : 2],
            "effort_max": sums[:, 0 : 2 * n : 2],
        }
        broken = (sums[:, 4 * n] <= steps) | (sums[:, 4 * n + 1] > RESIDUAL_LIMIT) | ~np.isfinite(sums).all(axis=1)
        self.broken = np.flatnonzero(broken | ~np.isfinite(records[:, -1]).all(axis=1)).tolist()

    def many(self, reference: Reference | Array, *, again: bool = True) -> Many:
        """The result; without `again` nothing is done again.

        Raises:
            Interrupted: a `KeyboardInterrupt` came while a run was done again; `result` lacks it and those behind it.
        """
        arrays = {name: np.array(values, dtype=np.float64) for name, values in self.arrays.items()}
        for array in arrays.values():
            array[self.broken] = np.nan
        failed = dict.fromkeys(self.broken, NOT_AGAIN)
        interrupt: KeyboardInterrupt | None = None
        for run in self.broken if again else ():
            try:
                found = self._by_model(run, reference)
            except CutjointError as error:
                failed[run] = str(error)
                continue
            except KeyboardInterrupt as error:
                interrupt = error
                break
            del failed[run]
            for name, values in found.items():
                arrays[name][run] = values
        slow = tuple(run for run in self.broken if run not in failed)
        made = Many(time=readonly(self.time), failed=failed, slow=slow, **arrays)
        if interrupt is not None:
            raise Interrupted(INTERRUPTED.format(len(made.q)), done=1.0, result=made) from interrupt
        return made

    def _by_model(self, run: int, reference: Reference | Array) -> dict[str, Array]:
        """One run by the model that is not compiled, with the same integrator, hardware and chance.

        Raises:
            SimulationError: it cannot be simulated to its end.
        """
        loop, part, times = self.loop, self.part, self.times
        if not isinstance(reference, Reference):
            raise InputError(
                "the run left what is compiled for; give the reference itself to have it done by the model"
            )
        values = {name: float(column[run]) for name, column in part.parameters.items()}
        model = loop.plant.with_parameters(values).plain
        gains = {name: column[run] for name, column in part.gains.items()}
        own = {name: column[run] for name, column in part.hardware.items()}
        hardware = None if loop.hardware is None else with_numbers(loop.hardware, own)
        result = simulate(
            ReducedPlant(model),
            _with_gains(loop.law, gains),
            reference,
            integrator=fixed_step(loop.method)(times.step),
            duration=times.step * times.steps,
            limits=None if isinstance(loop.control, Hardware) else loop.control,
            hardware=hardware,
            run_number=0 if hardware is None else part.numbers[run],
            start=model.close(part.start[run]),
            start_velocity=part.velocity[run],
        )
        error = result.desired_q - result.q
        columns = {"positions": result.q if loop.plant.source.positions == loop.plant.n else result.q_full}
        names = SAMPLED if hardware is not None else SAMPLED[:4]
        columns |= {name: getattr(result, name) for name in names if name != "positions"}
        found = {name: column[times.chosen] for name, column in columns.items()}
        return found | {
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
