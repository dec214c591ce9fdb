"""The picture of moves from point to point: how much of each limit but that of jerk, which is kept by being constant
between switches, is used, and how far the actuators are from home."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cutjoint.doors import door
from cutjoint.report.answers.retiming import parts_over_time
from cutjoint.report.answers.sheet import sheet
from cutjoint.report.figures import COLOURS, DASHES, INK, Drawing, drawable
from cutjoint.retiming import Moved

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INSTANTS = 600


@door
def moves_sheet(found: Moved) -> Drawing:
    """Draw moves from point to point.

    Raises:
        MissingPackageError: matplotlib is not installed.
    """

    def draw(figure: Figure) -> None:
        kinds = sorted({one.kind for one in found.actuators})
        grid = figure.add_gridspec(len(kinds), 2, width_ratios=(1.25, 1.0))
        over_time = figure.add_subplot(grid[:, 0])
        shown = [k for k, one in enumerate(found.peaks) if not one.quantity.startswith("jerk")]
        parts_over_time(over_time, found.time, found.used[:, shown], [found.peaks[k] for k in shown])
        over_time.set_xlabel("time [s]")
        _mark(over_time, found)
        handles, labels = over_time.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=min(3, len(labels)), handlelength=2.6)
        for row, kind in enumerate(kinds):
            ax = figure.add_subplot(grid[row, 1])
            _places(ax, found, kind)
            if row == 0:
                ax.set_title("Actuators, since home")
            if row == len(kinds) - 1:
                ax.set_xlabel("time [s]")

    count = len(found.slowed)
    return sheet(draw, f"{found.name}: {count} move{'s' if count > 1 else ''} in {found.duration:.4g} s", (11.0, 6.6))


def _mark(ax: Axes, found: Moved) -> None:
    """Where the robot stands."""
    for t in found.stops[1:-1].tolist():
        ax.axvline(t, color=INK, linewidth=0.8, linestyle=(0, (4, 3)))


def _places(ax: Axes, found: Moved, kind: str) -> None:
    t = np.linspace(0.0, found.duration, INSTANTS)
    q = np.array([found.trajectory.at(float(one)).q for one in t]) - found.points[0]
    for k, one in enumerate(found.actuators):
        if one.kind == kind:
            colour, dash = COLOURS[k % len(COLOURS)], DASHES[k % len(DASHES)]
            ax.plot(t, q[:, k], color=colour, linestyle=dash, label=drawable(one.name))
    ax.set_xlim(0.0, found.duration)
    ax.set_ylabel("travel [m]" if kind == "translation" else "travel [rad]")
    ax.legend(loc="best", fontsize=9)
    _mark(ax, found)
