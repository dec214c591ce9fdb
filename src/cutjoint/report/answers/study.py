"""The page of a study: tables, box plots, histograms, and bars of what matters most."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.doors import door
from cutjoint.extras import how_to_get, is_installed
from cutjoint.files import write_whole
from cutjoint.report.answers.sheet import sheet
from cutjoint.report.answers.study_tables import failure_table, ranking_tables, summary_tables
from cutjoint.report.figures import BLUE, GREY, INK, ORANGE, Drawing, drawable
from cutjoint.report.page import Picture, Section, page
from cutjoint.studies import ColumnSummary, Ranking, StudySummary

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 12
"""Drawings of a kind on a page."""
PATHS = 12
"""Paths of a ranking that are drawn."""
ROW = 0.34
"""Inches of a box or a bar."""
FACTORS = ((1e-9, "n"), (1e-6, "µ"), (1e-3, "m"), (1.0, ""), (1e3, "k"), (1e6, "M"))
"""Factors of units that are drawn."""
PREFIXED = ("m", "N", "J", "W", "m/s")
"""Units that take a prefix: those of one letter, but for angles."""


@door
def study_page(summary: StudySummary) -> str:
    """The page of a study as HTML; without matplotlib it has no drawings, and says so."""
    drawn = is_installed("matplotlib")
    lead = f"{summary.runs} of {summary.wanted} runs ({summary.method}), {summary.failed} failed, {summary.slow} slow."
    first = [*summary.told]
    if not drawn:
        first.append(f"Drawings need matplotlib: {how_to_get('matplotlib')}")
    elif len(_names(summary, None)) > MOST or len(summary.rankings) > MOST:
        first.append(f"Drawn are the first {MOST} quantities; the tables have all.")
    sections = [Section("What came out", [*first, *summary_tables(summary)], level=2)]
    if summary.reasons:
        sections.append(Section("Runs that failed", [failure_table(summary)], level=2))
    if drawn:
        sections.append(Section("Spread", _boxes(summary), level=2))
        sections.append(Section("Distributions", _histograms(summary), level=2))
    if summary.rankings:
        pictures = _bars(summary) if drawn else []
        sections.append(Section("What matters most", [*ranking_tables(summary), *pictures], level=2))
    return page(f"Study {summary.name}", lead, [one for one in sections if one.parts])


@door
def write_study_page(summary: StudySummary, path: str | os.PathLike[str]) -> Path:
    """Write the page of a study.

    Raises:
        InputError: the folder does not exist, or the file cannot be written.
    """
    return write_whole(path, study_page(summary))


def box_drawing(summary: StudySummary, column: str) -> Drawing:
    """A column in all cases as boxes: median and quartiles, whiskers from 5 % to 95 %, points at the ends."""
    own = [one for one in summary.columns if one.column == column]
    factor, unit = scale_of(own)

    def draw(figure: Figure) -> None:
        axes: Axes = figure.subplots()
        for place, one in enumerate(own):
            low, left, middle, right, high = (one.quantiles / factor).tolist()
            axes.barh(place, right - left, 0.55, left, color=f"{BLUE}40", edgecolor=BLUE, linewidth=1.5)
            axes.plot([middle, middle], [place - 0.275, place + 0.275], color=ORANGE, linewidth=2.5)
            for near, far in ((left, low), (right, high)):
                axes.plot([near, far], [place, place], color=BLUE, linewidth=1.5)
                axes.plot([far, far], [place - 0.14, place + 0.14], color=BLUE, linewidth=1.5)
            axes.plot([one.least / factor, one.largest / factor], [place, place], "o", markersize=5, color=INK)
        axes.set_yticks(range(len(own)), [drawable(summary.cases[one.case] or "all runs") for one in own])
        axes.invert_yaxis()
        axes.set_axisbelow(True)
        axes.grid(visible=False, axis="y")
        axes.set_xlabel(f"{drawable(column)} [{unit}]")

    return sheet(draw, column, (9.0, 1.5 + ROW * 1.6 * len(own)))


def histogram_drawing(summary: StudySummary, column: str) -> Drawing:
    """How often a column has which values, a row a case."""
    own = [one for one in summary.columns if one.column == column]
    factor, unit = scale_of(own)

    def draw(figure: Figure) -> None:
        every = figure.subplots(len(own), 1, squeeze=False, sharex=True)[:, 0]
        for axes, one in zip(every, own, strict=True):
            edges = np.linspace(one.least, one.largest, len(one.counts) + 1) / factor
            axes.stairs(100.0 * one.counts / max(one.counts.sum(), 1.0), edges, fill=True, color=BLUE, alpha=0.75)
            axes.axvline(one.quantiles[2] / factor, color=ORANGE, label="median")
            axes.axvline(one.mean / factor, color=INK, linestyle=(0, (2, 1.2)), label="mean")
            axes.set_axisbelow(True)
            axes.set_ylabel("runs [%]")
            axes.set_title(drawable(summary.cases[one.case]) if len(summary.cases) > 1 else "")
        every[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)
        every[-1].set_xlabel(f"{drawable(column)} [{unit}]")

    return sheet(draw, column, (9.0, 1.2 + 2.0 * len(own)))


def ranking_drawing(summary: StudySummary, ranking: Ranking) -> Drawing:
    """What matters most to a column, as bars."""
    shown = ranking.effects[:PATHS]
    name = summary.cases[ranking.case]
    places = np.arange(len(shown))

    def draw(figure: Figure) -> None:
        axes: Axes = figure.subplots()
        if ranking.explained is None:
            first, total = ([getattr(one, kind) for one in shown] for kind in ("first", "total"))
            near, far = ([getattr(one, f"{kind}_within") for one in shown] for kind in ("first", "total"))
            line = {"ecolor": INK, "capsize": 2.5, "elinewidth": 1.2}
            up, down = places - 0.19, places + 0.19
            axes.barh(up, total, 0.36, xerr=far, color=BLUE, label="ST, with others", error_kw=line)
            axes.barh(down, first, 0.36, xerr=near, color=ORANGE, label="S1, alone", error_kw=line)
            axes.set_xlabel("Sobol index [1], with 95 % interval")
            axes.legend(loc="lower right")
        else:
            rank = [one.rank or 0.0 for one in shown]
            axes.barh(places, rank, height=0.6, color=[BLUE if x >= 0.0 else ORANGE for x in rank])
            axes.axvline(0.0, color=GREY, linewidth=1.0)
            axes.set_xlim(-1.05, 1.05)
            axes.set_xlabel("Spearman's rank correlation [1]")
        axes.set_yticks(places, [drawable(one.path) for one in shown])
        axes.invert_yaxis()
        axes.set_axisbelow(True)
        axes.grid(visible=False, axis="y")

    title = f"{ranking.column}{name and f' ({name})'}"
    return sheet(draw, title, (9.0, 1.6 + 1.5 * ROW * len(shown)))


def scale_of(columns: Sequence[ColumnSummary]) -> tuple[float, str]:
    """A factor and a unit in which the numbers of columns are neither tiny nor huge."""
    unit = columns[0].unit
    most = max((abs(x) for one in columns for x in (one.least, one.largest) if np.isfinite(x)), default=0.0)
    if unit not in PREFIXED or most == 0.0:
        return 1.0, unit
    factor, prefix = next((one for one in reversed(FACTORS) if most >= one[0]), FACTORS[0])
    return factor, prefix + unit


def _names(summary: StudySummary, most: int | None = MOST) -> list[str]:
    return list(dict.fromkeys(one.column for one in summary.columns))[:most]


def _boxes(summary: StudySummary) -> list[Picture]:
    caption = "{}: median and quartiles, whiskers from 5 % to 95 %, points at the ends."
    return [Picture(box_drawing(summary, one), caption.format(one)) for one in _names(summary)]


def _histograms(summary: StudySummary) -> list[Picture]:
    return [Picture(histogram_drawing(summary, one), f"{one}: share of the runs.") for one in _names(summary)]


def _bars(summary: StudySummary) -> list[Picture]:
    return [
        Picture(ranking_drawing(summary, one), f"{one.column}: the paths that matter most.")
        for one in summary.rankings[:MOST]
    ]
