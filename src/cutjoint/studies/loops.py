"""A case ready to run: plant, controller and reference compiled into one loop, and blocks of its runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.compile import ClosedLoop, Many, compiled
from cutjoint.compile.many.grid import TimeGrid, time_grid
from cutjoint.errors import ClosureError, InputError, SingularError, UnreachableError
from cutjoint.studies.cases import StudyCase, inside_of, law_of, model_of, reference_of
from cutjoint.studies.paths import GAINS, HARDWARE, START, is_of_robot, number_name, own_value
from cutjoint.studies.quantities import QUANTITIES
from cutjoint.studies.values import Study

WIDEST = 2**25
"""Bytes of the records of a block, at most."""
SMALLEST, LARGEST = 256, 2**14
"""Runs of a block where the study does not say."""
BLOCKS = 256
"""So many blocks a case are wanted."""
CANNOT_START = (ClosureError, SingularError, UnreachableError)

Told = Callable[[float], None]
Columns = dict[str, Array]


@dataclass(frozen=True, eq=False)
class BlockRows:
    """Some runs: their columns, why those failed that did, and which the model itself did."""

    columns: Columns
    failed: tuple[str | None, ...]
    slow: tuple[bool, ...]


class PreparedCase:
    """A case that can be run.

    Args:
        study: the study.
        case: one of its cases.

    Attributes:
        actuators: of the robot.

    Raises:
        InputError: the controller cannot be compiled, or the study does not fit the robot.
        UnreachableError, LimitError: the robot cannot follow the trajectory.
    """

    def __init__(self, study: Study, case: StudyCase) -> None:
        self.study, self.case = study, case
        model = model_of(study, case)
        inside = inside_of(study, case, model)
        self.paths = [one.path for one in study.varied]
        names = [path for path in self.paths if is_of_robot(path)]
        ranges = {path: spread.bounds for path, spread in zip(self.paths, case.spreads, strict=True) if path in names}
        self.plant = compiled(model, parameters=names, ranges=ranges if isinstance(model, ClosedChain) else None)
        self.actuators = model.actuators
        self._gains = [path.removeprefix(GAINS) for path in self.paths if path.startswith(GAINS)]
        self._numbers = [number_name(path) for path in self.paths if path.startswith(HARDWARE)]
        self.reference = reference_of(study, case, inside)
        self.loop = ClosedLoop(
            self.plant,
            law_of(study, case, inside),
            inside,
            gains=tuple(self._gains),
            hardware=case.hardware,
            varying=tuple(self._numbers),
            method=study.integrator,
        )
        self._keep = {name: QUANTITIES[name] for name in study.keep}
        self._every = study.every if any(one.sampled for one in self._keep.values()) else None
        if lacking := [name for name, one in self._keep.items() if one.tool and not _has_tool(model)]:
            raise InputError(f"{lacking[0]} needs a tool, and {model.name} names none; leave it out of keep.columns")

    @cached_property
    def grid(self) -> TimeGrid:
        """Steps and samples of a run."""
        hardware = self.case.hardware
        tick = None if hardware is None else hardware.ticks.length
        return time_grid(self.reference.duration, self.study.step, tick, self._every)

    @cached_property
    def table(self) -> Array:
        """What the loop reads of the reference."""
        return self.loop.reference_table(self.reference, self.grid.step, self.grid.steps)

    @cached_property
    def _way(self) -> Array:
        """Where the tool shall be at the samples, shape (m, 3) [m]."""
        return self._way_at(self.grid.step * np.array(self.grid.chosen, dtype=np.float64))

    def _way_at(self, times: Array) -> Array:
        return np.array([self.reference.at(t).tool.position for t in times.tolist()])

    @property
    def record(self) -> int:
        """Bytes that the record of a run takes."""
        return self.loop.record(self.grid)

    def block(self, samples: int) -> int:
        """Runs in a block, where the study does not say: so many that there are some hundred blocks, in bounds."""
        wanted = min(max(1 << (-(-samples // BLOCKS) - 1).bit_length(), SMALLEST), LARGEST)
        return max(8, min(wanted, WIDEST // self.record))

    def units(self) -> dict[str, str]:
        """The columns that are kept, and their units."""
        found: dict[str, str] = {}
        for name, one in self._keep.items():
            found |= one.columns(name, self.actuators)
        return found

    def run(self, values: Array, first: int, told: Told | None = None, *, duration: float | None = None) -> BlockRows:
        """Simulate runs with the `values` of what varies, shape (N, paths), the first one number `first` of the
        samples; those that cannot start are noted as failed."""
        try:
            many = self._many(values, first, told, duration)
        except CANNOT_START as error:
            if len(values) == 1:
                return self._failed(str(error))
            half = len(values) // 2
            return _joined(
                self.run(values[:half], first, told, duration=duration),
                self.run(values[half:], first + half, told, duration=duration),
            )
        failed = tuple(many.failed.get(k) for k in range(len(values)))
        return BlockRows(
            self._columns(many, values), failed, tuple(np.isin(np.arange(len(values)), many.slow).tolist())
        )

    def _many(self, values: Array, first: int, told: Told | None, duration: float | None) -> Many:
        gains, parameters, numbers = dict[str, Array](), dict[str, Array](), dict[str, Array]()
        start = np.tile(self.reference.at(0.0).q, (len(values), 1))
        names = [one.name for one in self.actuators]
        for k, path in enumerate(self.paths):
            if path.startswith(GAINS):
                gains[path.removeprefix(GAINS)] = self._scaled(path, values[:, k])
            elif path.startswith(HARDWARE):
                numbers[number_name(path)] = self._scaled(path, values[:, k])
            elif path.startswith(START):
                start[:, names.index(path.removeprefix(START))] += values[:, k]
            else:
                parameters[path] = values[:, k]
        return self.loop.run(
            self.reference,
            step=self.study.step,
            duration=duration,
            every=self._every,
            gains=gains,
            parameters=parameters,
            hardware_numbers=numbers,
            start=start if any(path.startswith(START) for path in self.paths) else None,
            runs=len(values),
            first_run=first,
            table=self.table if duration is None else None,
            threads=1,
            progress=told,
        )

    def _scaled(self, path: str, values: Array) -> Array:
        """A gain or number of hardware for every run, (N, n); one that differs from actuator to actuator is scaled
        where it varies by a part."""
        own = own_value(self.plant, self.case.law.gains, self.case.hardware, path)
        spread = self.study.varied[self.paths.index(path)].spread
        scaled = spread.kind == "relative" and own.ndim == 1
        return values[:, None] * (own if scaled else np.ones(len(self.actuators)))

    def _columns(self, many: Many, values: Array) -> Columns:
        found: Columns = {}
        for name, one in self._keep.items():
            numbers = one.of(many, lambda: self._places(many, values))
            columns = list(one.columns(name, self.actuators))
            found |= dict(zip(columns, numbers.T if one.each else [numbers], strict=True))
        return found

    def _places(self, many: Many, values: Array) -> Array:
        """Distances of the tool from its way, shape (N, m)."""
        runs, samples = many.positions.shape[:2]
        whole = np.array([k not in many.failed for k in range(runs)])
        found = np.full((runs, samples), np.nan)
        if whole.any():
            flat = many.positions[whole].reshape(-1, many.positions.shape[2])
            own = {path: np.repeat(values[whole, k], samples) for k, path in enumerate(self.paths) if is_of_robot(path)}
            places = self.plant.batch.tool(flat, parameters=own).position.reshape(-1, samples, 3)
            way = self._way if samples == len(self._way) else self._way_at(many.time)
            found[whole] = np.linalg.norm(places - way, axis=2)
        return found

    def _failed(self, why: str) -> BlockRows:
        return BlockRows({name: np.full(1, np.nan) for name in self.units()}, (why,), (False,))


def _has_tool(model: object) -> bool:
    return not isinstance(model, ClosedChain) or model.description.tool is not None


def _joined(one: BlockRows, other: BlockRows) -> BlockRows:
    columns: Mapping[str, Array] = {name: np.concatenate([x, other.columns[name]]) for name, x in one.columns.items()}
    return BlockRows(dict(columns), one.failed + other.failed, one.slow + other.slow)
