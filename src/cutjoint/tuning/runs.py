"""Runs of a case with many sets of gains at once: how large the error and the efforts come out, the worst payload and
noise of each.  All sets meet the same noise and jitter, so that what tells them apart is not luck."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from cutjoint.arrays import Array
from cutjoint.compile import Many
from cutjoint.compile.many.grid import time_grid
from cutjoint.simulation.hardware import Hardware
from cutjoint.tuning.case import PAYLOAD, TuningCase
from cutjoint.tuning.case import Gains as GivenGains
from cutjoint.tuning.linear import steps_of

SAMPLES = 2000
"""Samples of a run at which its late error is taken, at most."""


class RunFigures(NamedTuple):
    """Of N sets of gains; infinite where a run cannot be simulated to its end.

    Attributes:
        rms: root mean square of the actuators' errors over the run and the actuators, shape (N,) [m] or [rad]; where
            some slide and some turn, those that slide in lengths of the robot.
        late: largest error from the case's time on along any axis, of the tool [m] or of the actuators, shape (N,).
        largest: the same over the whole run.
        peak: largest effort of every actuator, shape (N, n) [N] or [N m].
        failed: why one of the runs failed, or "".
    """

    rms: Array
    late: Array
    largest: Array
    peak: Array
    failed: str


class CaseRuns:
    """The compiled loop of a case, its reference walked once.

    Args:
        case: what is run.
        gains: where the law is traced, and what the step of the integrator goes by: no faster loop should be run.
    """

    def __init__(self, case: TuningCase, gains: GivenGains) -> None:
        self.case, self.step = case, case.step_for(gains)
        self.loop = case.loop(gains)
        tick = tick_of(case.hardware)
        if tick is not None:
            self.step = tick / np.ceil(tick / self.step * (1.0 - 1e-12))
        self._every = self.step * max(1, round(case.reference.duration / SAMPLES / self.step))
        self._desired: Array | None = None
        self._table: Array | None = None

    def figures(self, gains: Mapping[str, Array], *, late: bool = True, whole: bool = False) -> RunFigures:
        """Of sets of gains, arrays of shape (N,) or (N, n).

        Args:
            gains: the sets.
            late: whether the errors over time are taken too; without them it is quicker.
            whole: whether runs that leave what is compiled for are done again by the model; else they have failed.
        """
        case = self.case
        count, payloads = len(next(iter(gains.values()))), np.repeat(case.payloads, case.draws)
        given = {name: np.repeat(np.asarray(one, dtype=np.float64), len(payloads), 0) for name, one in gains.items()}
        has_payload = PAYLOAD in case.robot.options.parameters
        if self._table is None:
            grid = time_grid(case.reference.duration, self.step, tick_of(case.hardware), None)
            self._table, self.step = self.loop.reference_table(case.reference, grid.step, grid.steps), grid.step
        many = self.loop.run(
            case.reference if whole else self._table,
            step=self.step,
            every=self._every if late else None,
            chance_again=case.draws,
            gains=given,
            parameters={PAYLOAD: np.tile(payloads, count)} if has_payload else None,
        )
        shape = (count, len(payloads))
        sizes = steps_of(case.robot)
        weights = sizes if case.mixes else np.ones(len(sizes))
        rms = np.sqrt(np.mean((many.error_rms / weights) ** 2, axis=1))
        errors = self._errors(many, given) if late else np.full((len(rms), 2), np.nan)
        peak = np.where(np.isnan(many.effort_max), np.inf, many.effort_max)
        late_error, largest = (_worst(one, shape) for one in errors.T)
        failed = next(iter(many.failed.values()), "")
        return RunFigures(_worst(rms, shape), late_error, largest, peak.reshape(*shape, -1).max(axis=1), failed)

    def _errors(self, many: Many, given: Mapping[str, Array]) -> Array:
        """Largest error from the time on and over the whole run, shape (runs, 2)."""
        case = self.case
        actual = many.q if case.of == "actuators" else self._places(many)
        if self._desired is None or len(self._desired) != len(many.time):
            way = [case.reference.at(t) for t in many.time.tolist()]
            self._desired = np.array([one.q if case.of == "actuators" else one.tool.position for one in way])
        sizes = steps_of(case.robot) if case.mixes and case.of == "actuators" else 1.0
        off = np.abs((actual - self._desired) / sizes).max(axis=2)
        since = many.time >= case.after - 1e-9 * max(1.0, case.after)
        return np.stack([off[:, since].max(axis=1), off.max(axis=1)], axis=1)

    def _places(self, many: Many) -> Array:
        """Where the tool is, shape (runs, samples, 3)."""
        runs, samples, width = many.positions.shape
        flat = many.positions.reshape(-1, width)
        good = np.isfinite(flat).all(axis=1)
        places = np.full((len(flat), 3), np.nan)
        robot = self.case.carrying(0.0)
        if good.any():
            places[good] = robot.batch.tool(flat[good]).position
        return places.reshape(runs, samples, 3)


def tick_of(hardware: Hardware | None) -> float | None:
    """Of the controller's clock [s]; None under continuous control."""
    return None if hardware is None else hardware.ticks.length


def _worst(values: Array, shape: tuple[int, int]) -> Array:
    """The worst payload and noise of each set; what failed is infinite."""
    return np.asarray(np.where(np.isnan(values), np.inf, values).reshape(shape).max(axis=1))
