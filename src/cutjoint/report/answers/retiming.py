"""The picture of a retimed motion: parts of the limits over time, which of them is active, and the phase plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.arrays import Array
from cutjoint.doors import door
from cutjoint.report.answers.sheet import sheet
from cutjoint.report.figures import COLOURS, DASHES, GREY, INK, Drawing, drawable
from cutjoint.retiming import LimitPeak, Retimed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 8
"""Quantities that are drawn: those that come nearest to their limits."""
HEADROOM = 1.6
"""Top of the phase plane beside the largest rate of the motion."""


@door
def retiming_sheet(found: Retimed) -> Drawing:
    """Draw a retimed motion.

    Raises:
        MissingPackageError: matplotlib is not installed.
    """

    def draw(figure: Figure) -> None:
        grid = figure.add_gridspec(2, 2, width_ratios=(1.55, 1.0), height_ratios=(6.0, 1.0))
        over_time = figure.add_subplot(grid[0, 0])
        band = figure.add_subplot(grid[1, 0], sharex=over_time)
        parts_over_time(over_time, found.time, found.used, found.peaks)
        shown = _shown(found.peaks)
        _band(band, found, shown)
        _phase(figure.add_subplot(grid[:, 1]), found)
        over_time.tick_params(labelbottom=False)
        handles, labels = over_time.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=min(3, len(labels)), handlelength=2.6)

    turns = "" if found.cycles_per_minute is None else f", {found.cycles_per_minute:.4g} cycles a minute"
    return sheet(draw, f"{found.name}: {found.duration:.4g} s{turns}", (11.0, 6.6))


def _shown(peaks: Sequence[LimitPeak]) -> list[int]:
    """Numbers of the quantities that are drawn, in their order."""
    nearest = sorted(range(len(peaks)), key=lambda k: -peaks[k].part)[:MOST]
    return sorted(nearest)


def _look(place: int) -> tuple[str, object]:
    return COLOURS[place % len(COLOURS)], DASHES[place % len(DASHES)]


def parts_over_time(ax: Axes, time: Array, used: Array, peaks: Sequence[LimitPeak]) -> None:
    """Parts of limits over time [s], those that come nearest to theirs; `used` has a column a peak."""
    shown = _shown(peaks)
    for place, k in enumerate(shown):
        colour, dash = _look(place)
        one = peaks[k]
        label = f"{drawable(one.quantity)}, {one.limit:.4g} {one.unit}"
        ax.plot(time, 100.0 * used[:, k], color=colour, linestyle=dash, label=label)
    signed = bool((used[:, shown] < -1e-3).any())
    for level in (100.0, -100.0) if signed else (100.0,):
        ax.axhline(level, color=INK, linewidth=1.0, linestyle=(0, (1, 1.5)))
    ax.set_ylim(-112.0 if signed else 0.0, 112.0)
    ax.set_xlim(0.0, time[-1])
    ax.set_ylabel("part of its limit [%]")
    left = len(peaks) - len(shown)
    ax.set_title("How much of each limit is used" + (f" (the {len(shown)} nearest, {left} not shown)" if left else ""))


def _band(ax: Axes, found: Retimed, shown: list[int]) -> None:
    """Which limit is active when, in the colour of its curve."""
    colours = {found.peaks[k].quantity: _look(place)[0] for place, k in enumerate(shown)}
    active, time = found.active, found.time
    edges = np.concatenate([[time[0]], 0.5 * (time[1:] + time[:-1]), [time[-1]]])
    start = 0
    for i in range(1, len(active) + 1):
        if i == len(active) or active[i] != active[start]:
            if active[start]:
                ax.axvspan(edges[start], edges[i], color=colours.get(active[start], GREY), linewidth=0.0)
            start = i
    ax.set_yticks([])
    ax.set_ylim(0.0, 1.0)
    ax.grid(visible=False)
    ax.set_ylabel("active", rotation=0, ha="right", va="center")
    ax.set_xlabel("time [s]")


def _phase(ax: Axes, found: Retimed) -> None:
    """The rate of the way over the way, below what the limits leave."""
    s, most = found.ceiling.T
    top = HEADROOM * float(found.speed.max())
    seen = np.where(np.isfinite(most), np.minimum(most, 10.0 * top), 10.0 * top)
    ax.fill_between(s, seen, 10.0 * top, color=GREY, alpha=0.25, linewidth=0.0)
    ax.plot(s, seen, color=GREY, linewidth=1.5)
    order = np.argsort(found.place, kind="stable")
    ax.plot(found.place[order], found.speed[order], color=INK)
    ax.set_xlim(0.0, 1.0)
    ax.set_ylim(0.0, top)
    ax.set_xlabel("way s [1]")
    ax.set_ylabel("its rate [1/s]")
    ax.text(0.5, 0.985 * top, "no acceleration is left", ha="center", va="top", color=INK, fontsize=10.5)
    ax.set_title("Phase plane")
