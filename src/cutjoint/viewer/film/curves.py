"""The curves beside a film: panels of a run in groups that can be chosen, as JSON for the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cutjoint.chain import ClosedChain
from cutjoint.simulation import Result
from cutjoint.simulation.charts import panels_json
from cutjoint.simulation.panels import PANELS, Panel, Shown

OFFERED = ("error", "orientation", "effort", "tool", "joints", "velocity", "power", "passive", "energy", "gap")
"""Groups that can be chosen, as far as a run has them; names of `PANELS`."""
FIRST = ("error", "effort")
"""Groups that are shown unasked."""
MANY = 12
"""Curves of a group that is shown unasked."""
POINTS, MOST, FEWEST = 25_000, 500, 60
"""Samples of all curves of a page together, so that it stays small, and of one curve at most and at least."""


@dataclass(frozen=True)
class CurveGroup:
    """Panels that are chosen together, under one name."""

    name: str
    panels: tuple[Panel, ...]

    @property
    def curves(self) -> int:
        """How many there are."""
        return sum(len(panel.names) for panel in self.panels)


def groups_of(result: Result, chain: ClosedChain | None, offered: Sequence[str] = OFFERED) -> tuple[CurveGroup, ...]:
    """What a run has to show of the groups that are offered, over times from 0; `chain` where its configurations are
    the run's."""
    start = float(result.time[0])
    found = []
    for name in offered:
        panels = PANELS[name].make(Shown(result, chain))
        moved = [replace(panel, time=panel.time - start, since=panel.since - start) for panel in panels]
        if moved:
            found.append(CurveGroup(name, tuple(moved)))
    return tuple(found)


def as_data(groups: Sequence[CurveGroup]) -> list[dict[str, object]]:
    """Groups as JSON for the page."""
    points = int(np.clip(POINTS // max(sum(group.curves for group in groups), 1), FEWEST, MOST))
    return [
        {
            "name": group.name,
            "shown": group.name in FIRST and group.curves <= MANY,
            "panels": panels_json(group.panels, points),
        }
        for group in groups
    ]
