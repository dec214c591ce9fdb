"""The options of many runs by name, for types: those of a call of a loop, and those of `simulate_many`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypedDict

import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.simulation.hardware import Hardware


class RunOptions(TypedDict, total=False):
    """Of `simulate_many` and `ClosedLoop`."""

    step: float
    duration: float | None
    every: float | None
    gains: Mapping[str, npt.ArrayLike] | None
    parameters: Mapping[str, npt.ArrayLike] | None
    hardware_numbers: Mapping[str, npt.ArrayLike] | None
    start: npt.ArrayLike | None
    start_velocity: npt.ArrayLike | None
    runs: int | None
    threads: int | None
    progress: Callable[[float], None] | None


class LoopOptions(RunOptions, total=False):
    """Of `ClosedLoop.run`: also the number of the first run, for its chance; after how many runs chance begins again,
    so that runs with other gains meet the same noise; and a table that `reference_table` made of the reference."""

    first_run: int
    chance_again: int | None
    table: Array | None


class ManyOptions(RunOptions, total=False):
    """Of `simulate_many`."""

    method: str
    rate: float | None
    limits: npt.ArrayLike | None
    hardware: Hardware | None
    chunk: int | None
