"""Plots of runs: what is asked for of one run or several over each other, as a figure, and as a page to read off."""

from __future__ import annotations

import html
import os
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from cutjoint.errors import InputError
from cutjoint.files import check_place, write_whole
from cutjoint.report.chart_figure import chart_figure
from cutjoint.report.curves_page import curves, page_of
from cutjoint.report.named_runs import Runs, named_runs, robots_of
from cutjoint.report.own_files import PLOT
from cutjoint.reprs import one_line, quoted
from cutjoint.simulation.charts import Chart, overlaid
from cutjoint.simulation.panels import PANELS, USUAL, between, panels_of
from cutjoint.simulation.summary import early, title_of

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain
    from cutjoint.report.figures import Drawing

SUFFIXES = (".svg", ".png", ".html")
DPI = 150


class Plot:
    """Curves of runs.  Shows itself in a notebook; `save` writes SVG, PNG, or a page of HTML.

    Attributes:
        title: what runs these are.
        charts: what is drawn.
    """

    def __init__(self, title: str, charts: Sequence[Chart]) -> None:
        self.title, self.charts = title, tuple(charts)

    def __repr__(self) -> str:
        return one_line("Plot", [quoted(self.title), *(chart.title for chart in self.charts)])

    @cached_property
    def drawing(self) -> Drawing:
        """As a figure of matplotlib.

        Raises:
            MissingPackageError: it is not installed.
        """
        return chart_figure(self.charts, title=self.title)

    @property
    def html(self) -> str:
        """As a page that needs nothing else, with curves to read off and to enlarge; it needs no matplotlib."""
        return page_of(self.title, f"<h1>{html.escape(self.title)}</h1>\n{curves(self.charts, 'charts')}", PLOT)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write it; the suffix picks the format: .svg, .png or .html.

        Raises:
            InputError: another suffix, or a place where nothing can be written.
            MissingPackageError: .svg and .png need matplotlib.
        """
        target = check_plot_place(path)
        if target.suffix == ".html":
            return write_whole(target, self.html)
        drawn = self.drawing
        return write_whole(target, drawn.png(DPI) if target.suffix == ".png" else drawn.svg_file(PLOT))

    def _repr_svg_(self) -> str:
        return self.drawing.svg("plot")


def check_plot_place(path: str | os.PathLike[str]) -> Path:
    """`path` as a place for a plot; worth asking before long work.

    Raises:
        InputError: another suffix, no such folder, or a folder of that name.
    """
    target = check_place(path)
    if target.suffix not in SUFFIXES:
        raise InputError(f"a plot is written as {', '.join(SUFFIXES)}; found {str(target)!r}")
    return target


def plot(
    runs: Runs,
    what: str | Sequence[str] = (),
    *,
    robot: ClosedChain | None = None,
    start: float | None = None,
    end: float | None = None,
    file: str | os.PathLike[str] | None = None,
) -> Plot:
    """Curves of a run, or of several over each other.

    Args:
        runs: a result, several, or results by the names that the legend shall have.
        what: names of `simulation.panels.PANELS`, as a list or with commas between them; default the usual ones.
        robot: that the runs were made with; default the one they name, where it is found.  Limits of its joints are
            drawn, and "reactions" need it.
        start: first time to show [s]; default all.
        end: last time to show [s].
        file: where to write it too: .svg, .png or .html.

    Raises:
        InputError: runs of different robots, a run without what is asked for, no stretch of time, no place for a file.
        UnknownNameError: there is no panel of that name.
        MissingPackageError: matplotlib is not installed, and `file` needs it.
    """
    named = named_runs(runs)
    if file is not None:
        check_plot_place(file)
    names = [one.strip() for one in what.split(",")] if isinstance(what, str) and what else list(what or ())
    first = next(iter(named.values()))
    robots, missing = robots_of(named, robot)
    if missing and "reactions" in names:
        raise InputError(missing)
    found = {name: between(panels_of(run, names, robots[name]), start, end) for name, run in named.items()}
    if not any(found.values()):
        raise InputError(f"these runs have none of {', '.join(USUAL)}; ask for others: {', '.join(PANELS)}")
    title = title_of(first) if len(named) == 1 else ", ".join(f"{name}{early(run)}" for name, run in named.items())
    made = Plot(title, overlaid(found))
    if file is not None:
        made.save(file)
    return made
