"""Plots of results: quantities over time and paths in a plane, one to three panels beside each other, as SVG or PNG.

One look for all: colours that everybody can tell apart (M. Okabe, K. Ito: Color Universal Design, 2008), the same
colour and dash for a limb everywhere.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterable
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import shown
from cutjoint.extras import needed
from cutjoint.reprs import line
from cutjoint.simulation.charts import look
from cutjoint.simulation.panels import Panel, scaled

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


BLUE, ORANGE, GREEN = "#0072B2", "#E69F00", "#009E73"
PURPLE = "#CC79A7"
INK, GREY = "#222222", "#8a8a8a"

COLOURS = (BLUE, ORANGE, GREEN, "#D55E00", PURPLE, "#56B4E9", INK, "#8A6D00")
DASHES = (
    "-",
    (0, (6, 1.5)),
    (0, (2, 1.2)),
    (0, (7, 2, 1.5, 2)),
    (0, (11, 3)),
    (0, (3, 1.5, 1, 1.5, 1, 1.5)),
)
"""Of the curves of `simulation.charts`, in the order of its numbers; pages have the same in curves.js."""
LIMBS = tuple(zip(COLOURS[:3], DASHES[:3], strict=True))
"""Colour and dash of limb 1, 2 and 3 (and of the axes x, y and z); the robots under urdf/ wear the same colours."""

DESIRED, ACTUAL = GREY, PURPLE
GRID, PLATE = "#e4e4e4", "#ffffff"

ON_DARK = {
    BLUE: "#4AA3DF",
    ORANGE: "#F2B134",
    GREEN: "#3ECFA3",
    "#D55E00": "#F07F3C",
    PURPLE: "#E7A3C8",
    "#56B4E9": "#9AD4FF",
    INK: "#E8EAED",
    "#8A6D00": "#D8C25A",
    GREY: "#a5adb8",
    GRID: "#363c45",
    PLATE: "#16191d",
}
"""Every colour of a figure, and what a dark page has in its place; curves.js has the same."""

SETTINGS = {
    "font.family": "DejaVu Sans",
    "text.parse_math": False,
    "font.size": 9,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": GRID,
    "text.color": INK,
    "figure.facecolor": PLATE,
    "axes.facecolor": PLATE,
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.5,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "svg.fonttype": "path",
    "svg.hashsalt": "cutjoint",
    "path.simplify_threshold": 0.3,
}


LONGEST = 60
"""Most characters of a name in a figure."""
HEIGHT = 2.9
WIDTHS = {1: 4.6, 2: 7.8, 3: 11.2}


@dataclass(frozen=True)
class ToolPath:
    """Paths of the tool in a plane of two world axes.

    Attributes:
        title: what is shown.
        axes: which two of x, y, z.
        desired: shape (m, 3), [m].
        actual: shape (m, 3), [m], or None.
    """

    title: str
    axes: str
    desired: Array
    actual: Array | None = None

    __repr__ = line(desired="m", actual="m")


class Drawing:
    """A finished figure."""

    __repr__ = line()

    def __init__(self, canvas: Figure) -> None:
        self._figure = canvas

    def svg(self, key: str) -> str:
        """As an SVG element to put into HTML; `key` keeps its identifiers apart from those of other figures."""
        text = self.svg_file()
        text = text[text.index("<svg") :]
        text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
        text = re.sub(r'\bid="', f'id="{key}-', text)
        text = re.sub(r'(xlink:href="#|url\(#)', rf"\g<1>{key}-", text)
        for colour in ON_DARK:  # where a page says nothing else they are as they are
            text = re.sub(rf"(?i)(?<=[: ]){colour}\b", f"var({_variable(colour)}, {colour})", text)
        # Its natural width, less where the page is narrower; the height follows.
        return re.sub(
            r'<svg ([^>]*?)width="([^"]*)" height="[^"]*"', r'<svg role="img" style="width: \2" \1', text, count=1
        )

    def svg_file(self, creator: str | None = None) -> str:
        """As a file of its own, which names its creator where there is one."""
        buffer = io.StringIO()
        with plotting().rc_context(SETTINGS):
            self._figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": creator})
        return buffer.getvalue()

    def png(self, dpi: int = 110) -> bytes:
        """As a picture."""
        buffer = io.BytesIO()
        with plotting().rc_context(SETTINGS):
            self._figure.savefig(buffer, format="png", dpi=dpi)
        return buffer.getvalue()


def _variable(colour: str) -> str:
    """The CSS variable that a colour of a figure is replaced by."""
    return f"--figure-{colour[1:].lower()}"


def dark_variables() -> str:
    """CSS declarations with which the figures of a page suit a dark one."""
    return " ".join(f"{_variable(light)}: {dark};" for light, dark in ON_DARK.items())


def figure(*panels: Panel | ToolPath) -> Drawing:
    """The panels beside each other."""
    mpl = plotting()
    from matplotlib.figure import Figure

    with mpl.rc_context(SETTINGS):
        drawn = Figure(figsize=(WIDTHS.get(len(panels), 4.0 * len(panels)), HEIGHT), layout="constrained")
        axes = drawn.subplots(1, len(panels), squeeze=False)[0]
        for panel, ax in zip(panels, axes, strict=True):
            if isinstance(panel, Panel):
                _over_time(ax, panel)
            else:
                _path(ax, panel)
        _legend(drawn, axes)
        drawn.draw_without_rendering()  # laid out once, so that every file of it is the same
        drawn.set_layout_engine("none")
        return Drawing(drawn)


def _legend(drawn: Figure, axes: Iterable[Axes]) -> None:
    """One legend for all panels, below them."""
    entries: dict[str, Artist] = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    if len(entries) > 1:
        drawn.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=len(entries), handlelength=2.4)


def plotting() -> ModuleType:
    """Matplotlib.

    Raises:
        MissingPackageError: it is not installed.
    """
    return needed("matplotlib", "a plot")


def drawable(text: str) -> str:
    """A text that can be drawn, whatever it is: printable, and no broader than a legend can be."""
    return shown(text, LONGEST)


def _over_time(ax: Axes, panel: Panel) -> None:
    reach = panel.values if panel.bound is None else np.append(panel.values.ravel(), panel.bound)
    factor, unit = scaled(reach, panel.unit)
    _curves(ax, panel, factor)
    ax.set_title(drawable(panel.title))
    ax.set_xlabel("time [s]")
    ax.set_ylabel(f"{panel.quantity} [{unit}]")
    ax.set_xlim(panel.time[0], panel.time[-1])
    if panel.zoom is not None:
        _enlarged(ax, panel, panel.zoom)


def _curves(ax: Axes, panel: Panel, factor: float) -> None:
    for i, name in enumerate(panel.names):
        colour, dash = (COLOURS[look(i)[0]], DASHES[look(i)[1]]) if len(panel.names) > 1 else (INK, "-")
        ax.plot(panel.time, factor * panel.values[:, i], color=colour, linestyle=dash, label=drawable(name))
    if panel.bound is not None:
        from_to = [panel.since, panel.time[-1]]
        for sign in (1.0, -1.0) if (panel.values < 0.0).any() else (1.0,):
            bound = [sign * factor * panel.bound] * 2
            ax.plot(from_to, bound, color=INK, linewidth=1.0, linestyle=(0, (1, 1.5)), label="limit")


def _enlarged(ax: Axes, panel: Panel, zoom: tuple[float, float]) -> None:
    """A small window with its own vertical scale."""
    inside = panel.values[(panel.time >= zoom[0]) & (panel.time <= zoom[1])]
    limits = inside if panel.bound is None or zoom[1] <= panel.since else np.append(inside, [panel.bound])
    factor, unit = scaled(limits, panel.unit)
    low, high = factor * min(inside.min(), 0.0), factor * limits.max()
    if panel.bound is not None and zoom[1] > panel.since and low < 0.0:
        low = min(low, -factor * panel.bound)
    window = ax.inset_axes((0.42, 0.6, 0.56, 0.27))
    _curves(window, panel, factor)
    window.set_xlim(*zoom)
    window.set_ylim(low - 0.08 * (high - low), high + 0.08 * (high - low))
    window.tick_params(labelsize=7, length=2, pad=2)
    when = f"first {zoom[1]:g} s" if zoom[0] == 0.0 else f"from {zoom[0]:g} s on"
    window.set_title(f"{when} [{unit}]", fontsize=7.5, fontweight="normal", pad=2)


def _path(ax: Axes, panel: ToolPath) -> None:
    from matplotlib.ticker import MaxNLocator

    i, j = ("xyz".index(axis) for axis in panel.axes)
    ax.plot(panel.desired[:, i], panel.desired[:, j], color=DESIRED, linewidth=3.0, alpha=0.6, label="desired path")
    if panel.actual is not None:
        ax.plot(panel.actual[:, i], panel.actual[:, j], color=ACTUAL, linewidth=1.2, label="actual path")
        ax.plot(*panel.actual[0, [i, j]], marker="o", markersize=4, color=ACTUAL)
    ax.set_title(panel.title)
    ax.set_xlabel(f"{panel.axes[0]} [m]")
    ax.set_ylabel(f"{panel.axes[1]} [m]")
    ax.set_aspect("equal", adjustable="datalim")
    ax.xaxis.set_major_locator(MaxNLocator(5))
