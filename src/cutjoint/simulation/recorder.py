"""Collects the samples of a run until they become a `Result`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cutjoint.arrays import Array
from cutjoint.motion import Desired
from cutjoint.simulation.plant import Observation
from cutjoint.simulation.result import ARRAYS, Result


class Recorder:
    """A growing record."""

    def __init__(self) -> None:
        self._rows: list[tuple[object, ...]] = []

    def add(self, t: float, seen: Observation, desired: Desired, effort: Array, work: float) -> None:
        """Take one sample."""
        row = {
            "time": t,
            "q": seen.q,
            "v": seen.v,
            "desired_q": desired.q,
            "desired_v": desired.v,
            "tool": seen.tool,
            "tool_velocity": seen.tool_velocity,
            "desired_tool": desired.tool.position,
            "desired_tool_velocity": desired.tool.velocity,
            "effort": effort,
            "gap": seen.gap,
            "kinetic": seen.kinetic,
            "potential": seen.potential,
            "work": work,
            "q_full": seen.q_full,
        }
        self._rows.append(tuple(row[name] for name in ARRAYS))

    def result(self, about: Mapping[str, Any]) -> Result:
        """Everything taken so far."""
        columns = zip(*self._rows, strict=True)
        return Result(**dict(zip(ARRAYS, map(list, columns), strict=True)), about=about)  # type: ignore[arg-type]
