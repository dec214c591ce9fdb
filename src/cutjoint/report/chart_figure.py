"""Charts of runs as one figure: a grid of frames, each with its legend beside it.  Needs matplotlib."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.report.figures import COLOURS, DASHES, INK, SETTINGS, Drawing, drawable, plotting
from cutjoint.simulation.charts import Chart, ChartCurve, scale_of, thinned

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POINTS = 3000
"""Samples of a curve in a figure: more than it has pixels across."""
WIDTH, HEIGHT = 7.6, 3.0
"""Inches of one frame with its legend."""
TITLE = 85
"""Characters of a title that one frame is broad."""
FAR = 4.0
"""Limits so many times further away than the values reach are told in the legend, not drawn: they would press the
curves flat.  curves.js does the same."""


def chart_figure(charts: Sequence[Chart], columns: int | None = None, title: str = "") -> Drawing:
    """The charts below each other, from four on in two columns, and a title above them.

    Raises:
        MissingPackageError: matplotlib is not installed.
    """
    mpl = plotting()
    from matplotlib.figure import Figure

    across = columns or (1 if len(charts) < 4 else 2)
    down = math.ceil(len(charts) / across)
    with mpl.rc_context(SETTINGS | {"font.size": 11, "legend.fontsize": 10, "axes.titlesize": 12}):
        drawn = Figure(figsize=(WIDTH * across, HEIGHT * down), layout="constrained")
        frames = drawn.subplots(down, across, squeeze=False).ravel()
        for chart, ax in zip(charts, frames, strict=False):
            _draw(ax, chart)
        for ax in frames[len(charts) :]:
            ax.set_visible(False)
        if title:
            drawn.suptitle("\n".join(textwrap.wrap(title, TITLE * across)), fontsize=12)
        return Drawing(drawn)


def _draw(ax: Axes, chart: Chart) -> None:
    factor, unit = scale_of(chart)
    alone = len(chart.curves) == 1
    for curve in chart.curves:
        time, values = thinned(curve.time, curve.values, POINTS)
        colour = INK if alone else COLOURS[curve.colour]
        ax.plot(
            time,
            factor * values,
            color=colour,
            linestyle=DASHES[curve.dash],
            label=drawable(curve.name),
            marker="o" if len(time) == 1 else "",
        )
    start, end = (pick(c.time[i] for c in chart.curves) for pick, i in ((min, 0), (max, -1)))
    if end > start:
        ax.set_xlim(start, end)
    far = _limits(ax, chart, factor)
    ax.set_title(drawable(chart.title))
    ax.set_xlabel("time [s]")
    ax.set_ylabel(f"{chart.quantity} [{unit}]")
    if far:
        ax.plot([], [], color=INK, linewidth=1.0, linestyle=(0, (1, 1.5)), label=far)
    if not alone or far:
        ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.02), handlelength=3.2, borderaxespad=0.0)


def _limits(ax: Axes, chart: Chart, factor: float) -> str:
    """Draw the limits that are near the values; words for those that are not."""
    low = min(float(curve.values.min()) for curve in chart.curves)
    high = max(float(curve.values.max()) for curve in chart.curves)
    far: list[float] = []
    for value, colour, since in _lines(chart, low):
        if max(high, value) - min(low, value) <= FAR * max(high - low, 1e-300):
            last = max(float(curve.time[-1]) for curve in chart.curves)
            ax.plot([since, last], [factor * value] * 2, color=colour, linewidth=1.1, linestyle=(0, (1, 1.5)))
        else:
            far.append(factor * value)
    if not far:
        return ""
    ends = sorted(set(np.round(far, 12).tolist()))
    return f"limit: {' and '.join(f'{one:.4g}' for one in ends)}" if len(ends) < 3 else "limits: outside"


def _lines(chart: Chart, low: float) -> list[tuple[float, str, float]]:
    """Value, colour and start of every limit of a chart; what all curves share once, in ink."""
    found: list[tuple[float, str, float]] = []
    if chart.bound is not None:
        found += [(sign * chart.bound, INK, chart.since) for sign in ((1.0, -1.0) if low < 0.0 else (1.0,))]

    def ends(curve: ChartCurve) -> set[float]:
        return {one for one in (curve.low, curve.high) if one is not None}

    shared = set.intersection(*(ends(curve) for curve in chart.curves))
    for curve in chart.curves:
        start = float(curve.time[0])
        found += [(one, COLOURS[curve.colour], start) for one in sorted(ends(curve) - shared)]
    first = min(float(curve.time[0]) for curve in chart.curves)
    return [*found, *((one, INK, first) for one in sorted(shared))]
