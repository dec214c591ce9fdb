"""Curves of one run or several in one frame each, and the same as JSON for pages, thinned where a run is long.

A curve keeps its colour over all runs, a run its dash over all curves; where that would be more than can be told apart,
every quantity gets a frame of its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cutjoint.arrays import Array, Values, readonly
from cutjoint.simulation.panels import Panel, scaled

COLOURS = 8
DASHES = 6
"""How many there are to tell curves apart; `report.figures` and the pages' curves.js have the same tables."""
MOST = 12
"""Curves in one frame."""
GROUP = 8
"""Curves in a frame where those of one run are more than `MOST`."""
POINTS = 2000
"""Samples of a curve on a page: more than there are pixels across it."""


@dataclass(frozen=True, eq=False)
class ChartCurve(Values):
    """One quantity of one run.

    Attributes:
        name: as the legend has it.
        time: shape (m,), [s].
        values: shape (m,), in the chart's unit.
        colour: number in a table of `COLOURS`.
        dash: number in a table of `DASHES`.
        low: lower limit of this quantity, or None.
        high: upper limit, or None.
    """

    name: str
    time: Array
    values: Array
    colour: int = 0
    dash: int = 0
    low: float | None = None
    high: float | None = None

    def __post_init__(self) -> None:
        for name in ("time", "values"):
            object.__setattr__(self, name, readonly(getattr(self, name)))


@dataclass(frozen=True)
class Chart:
    """Curves over time in one frame.

    Attributes:
        title: what is shown.
        quantity: what the vertical axis measures.
        unit: of all curves, SI.
        curves: in the order of the legend.
        bound: a limit of all of them at plus and minus this value, or None.
        since: time from which it counts [s].
    """

    title: str
    quantity: str
    unit: str
    curves: tuple[ChartCurve, ...]
    bound: float | None = None
    since: float = 0.0


def look(i: int) -> tuple[int, int]:
    """Colour and dash of curve i of one run: the first 48 are all different."""
    return i % COLOURS, (i + i // 24) % DASHES


def overlaid(runs: Mapping[str, Sequence[Panel]]) -> list[Chart]:
    """The panels of runs of one robot by name, those of the same title and unit in one chart."""
    found: dict[tuple[str, str], dict[str, Panel]] = {}
    for run, panels in runs.items():
        for panel in panels:
            found.setdefault((panel.title, panel.unit), {})[run] = panel
    charts = []
    for same in found.values():
        charts += _of_one(*same.values()) if len(runs) == 1 else _of_several(same, tuple(runs))
    return charts


def _curve(panel: Panel, i: int, name: str, look: tuple[int, int]) -> ChartCurve:
    low, high = (None, None) if panel.limits is None else panel.limits[i]
    ends = [float(one) if one is not None and math.isfinite(one) else None for one in (low, high)]
    return ChartCurve(name, panel.time, panel.values[:, i], *look, *ends)


def _of_one(panel: Panel) -> list[Chart]:
    chart = Chart(panel.title, panel.quantity, panel.unit, (), panel.bound, panel.since)
    count = len(panel.names)
    parts = 1 if count <= MOST else math.ceil(count / GROUP)
    found = []
    for part in range(parts):
        own = range(part * count // parts, (part + 1) * count // parts)
        curves = tuple(_curve(panel, i, panel.names[i], look(k)) for k, i in enumerate(own))
        title = panel.title if parts == 1 else f"{panel.title} ({part + 1} of {parts})"
        found.append(replace(chart, title=title, curves=curves))
    return found


def _of_several(same: Mapping[str, Panel], runs: Sequence[str]) -> list[Chart]:
    """One chart of a panel of several runs, or one for each of its curves."""
    panel = next(iter(same.values()))
    bounds = [one.bound for one in same.values() if one.bound is not None]
    bound = bounds[0] if len(bounds) == len(same) and len(set(bounds)) == 1 else None
    chart = Chart(panel.title, panel.quantity, panel.unit, (), bound, panel.since)
    names = list(dict.fromkeys(name for one in same.values() for name in one.names))
    of_name = {
        name: [(run, one, one.names.index(name)) for run, one in same.items() if name in one.names] for name in names
    }
    if len(names) > 1 and sum(map(len, of_name.values())) <= MOST and len(runs) <= DASHES:
        curves = tuple(
            _curve(one, k, f"{name}, {run}", (i % COLOURS, runs.index(run)))
            for i, (name, own) in enumerate(of_name.items())
            for run, one, k in own
        )
        return [replace(chart, curves=curves)]
    return [
        replace(
            chart,
            title=panel.title if len(names) == 1 else f"{panel.title}: {name}",
            curves=tuple(_curve(one, k, run, look(runs.index(run))) for run, one, k in own),
        )
        for name, own in of_name.items()
    ]


def thinned(time: Array, values: Array, points: int) -> tuple[Array, Array]:
    """At most `points` of the samples: the first, the last, and the smallest and largest of even stretches of time.

    Samples as they are, none in between, so no peak is lost and none is lower.
    """
    if len(time) <= points:
        return time, values
    edges = np.linspace(time[0], time[-1], max(points // 2 - 1, 1) + 1)[1:-1]
    starts = np.unique(np.concatenate([[0], np.searchsorted(time, edges)]))
    ends = np.append(starts[1:], len(time))
    kept = {0, len(time) - 1}
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        part = values[start:end]
        kept |= {start + int(part.argmin()), start + int(part.argmax())}
    index = np.array(sorted(kept))
    return time[index], values[index]


def panels_json(panels: Sequence[Panel], points: int = POINTS) -> list[dict[str, object]]:
    """Panels of one run as curves.js draws them; of long runs at most `points` samples a curve, without loss of peaks.

    Values are in a unit with handy digits, which `unit` tells.
    """
    return charts_json(overlaid({"": panels}), points)


def charts_json(charts: Sequence[Chart], points: int = POINTS) -> list[dict[str, object]]:
    """Charts as curves.js draws them, as `panels_json`."""
    return [_chart_json(chart, points) for chart in charts]


def _chart_json(chart: Chart, points: int) -> dict[str, object]:
    factor, unit = scale_of(chart)
    shared = chart.curves[0].time
    whole = len(shared) <= points
    curves = []
    for curve in chart.curves:
        time, values = thinned(curve.time, curve.values, points)
        own = not whole or not np.array_equal(curve.time, shared)
        ends = {"low": curve.low, "high": curve.high}
        curves.append(
            {
                "name": curve.name,
                "colour": curve.colour,
                "dash": curve.dash,
                "values": _short(factor * values, 7),
                **({"time": _short(time, 9)} if own else {}),
                **{name: factor * value for name, value in ends.items() if value is not None},
            }
        )
    return {
        "title": chart.title,
        "quantity": chart.quantity,
        "unit": unit,
        "time": _short(shared, 9) if whole else [],
        "curves": curves,
        "bound": None if chart.bound is None else factor * chart.bound,
        "since": chart.since,
    }


def scale_of(chart: Chart) -> tuple[float, str]:
    """Factor and unit in which the values of a chart have handy digits."""
    largest = [float(np.abs(curve.values).max(initial=0.0)) for curve in chart.curves]
    if chart.bound is not None:
        largest.append(chart.bound)
    return scaled(np.array(largest), chart.unit)


def _short(values: Array, digits: int) -> list[float]:
    """So many significant digits: enough to show and to read off, and short in a file."""
    return [float(f"{value:.{digits}g}") for value in values]
