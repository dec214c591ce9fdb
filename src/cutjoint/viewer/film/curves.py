"""The curves beside a film: panels of a run as JSON for the page, thinned so that the page stays small.

A curve is thinned by itself: of every stretch of time its smallest and its largest value stay, so that no peak is lost.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.simulation import Result
from cutjoint.simulation.panels import PANELS, Panel, panels_of

SHOWN = ("error", "effort")
"""Groups that are shown at first; the other ones can be chosen."""
OFFERED = ("error", "effort", "tool", "joints", "power")
POINTS = 60_000
"""Of all curves of a page together, as far as each may have FEWEST."""
MOST, FEWEST = 600, 100
"""Points of one curve."""
MANY = 8
"""Actuators; the curves of more fill the panel and are not shown at first."""


@dataclass(frozen=True)
class CurveGroup:
    """Panels that are chosen together, under one name."""

    name: str
    panels: tuple[Panel, ...]


def groups_of(result: Result, offered: Sequence[str] = OFFERED) -> tuple[CurveGroup, ...]:
    """What a run has to show of the groups that are offered."""
    found = []
    for name in offered:
        if name not in PANELS or (name == "error" and not result.followed) or not len(result):
            continue
        panels = tuple(panel for panel in panels_of(result, (name,)) if panel.names)
        if panels:
            found.append(CurveGroup(name, panels))
    return tuple(found)


def as_data(groups: Sequence[CurveGroup], start: float) -> list[dict[str, object]]:
    """Groups as JSON for the page, whose clock begins at `start` [s]."""
    curves = sum(len(panel.names) for group in groups for panel in group.panels)
    points = int(np.clip(POINTS // max(curves, 1), FEWEST, MOST))
    first = [group.name for group in groups if group.name in SHOWN] or [group.name for group in groups][:1]
    return [
        {
            "name": group.name,
            "shown": group.name in first and all(len(panel.names) <= MANY for panel in group.panels),
            "panels": [_panel(panel, start, points) for panel in group.panels],
        }
        for group in groups
    ]


def _panel(panel: Panel, start: float, points: int) -> dict[str, object]:
    curves = []
    for i, name in enumerate(panel.names):
        kept = thinned(panel.values[:, i], points)
        time, values = panel.time[kept] - start, panel.values[kept, i]
        curves.append({"name": name, "colour": i, "time": _rounded(time), "values": _rounded(values)})
    found: dict[str, object] = {"title": panel.title, "unit": panel.unit, "quantity": panel.quantity, "curves": curves}
    if panel.bound is not None:
        found |= {"bound": panel.bound, "since": panel.since - start}
    return found


def thinned(values: Array, points: int) -> list[int]:
    """Indices of at most about `points` of the values, shape (m,): first, last, and the extremes between them."""
    count = len(values)
    if count <= points:
        return list(range(count))
    edges = np.linspace(0, count, max(points // 2, 1) + 1).astype(int)
    kept = {0, count - 1}
    for low, high in itertools.pairwise(edges):
        kept |= {low + int(np.argmin(values[low:high])), low + int(np.argmax(values[low:high]))}
    return sorted(kept)


def _rounded(values: Array) -> list[float]:
    """Six significant digits."""
    return [float(f"{value:.6g}") for value in values]
