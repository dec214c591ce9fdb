"""Everything about a run, or several beside each other, as one self-contained page: whether it can be believed, how it
was made, what came of it, all curves, and the robot moving."""

from __future__ import annotations

import html
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.errors import CutjointError
from cutjoint.files import check_place, write_whole
from cutjoint.report.curves_page import curves, page_of
from cutjoint.report.named_runs import Runs, named_runs, robots_of
from cutjoint.report.own_files import REPORT
from cutjoint.simulation.belief import Belief, Grade, verdict_of
from cutjoint.simulation.charts import overlaid
from cutjoint.simulation.panels import Panel, all_panels
from cutjoint.simulation.result import Result
from cutjoint.simulation.summary import early, figure_rows, figures_of, setting_rows, title_of
from cutjoint.tables import TextTable
from cutjoint.texts import Cell

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain

WORDS: Mapping[Grade, str] = {"good": "good", "half": "look closer", "bad": "not good"}
SUFFIX = ".html"


class RunPage:
    """A page about runs.  Shows itself in a notebook, `save` writes it.

    Attributes:
        title: what runs these are.
        html: the whole page.
        verdicts: of the runs by name.
    """

    def __init__(self, title: str, text: str, verdicts: Mapping[str, Belief]) -> None:
        self.title, self.html, self.verdicts = title, text, dict(verdicts)

    def __repr__(self) -> str:
        grades = ", ".join(f"{name} {WORDS[one.grade]}" for name, one in self.verdicts.items())
        return f"RunPage({self.title}: {grades}; {len(self.html) / 1e6:.2g} MB)"

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the page, whole or not at all.

        Raises:
            InputError: the name does not end in .html, or nothing can be written there.
        """
        return write_whole(check_page_place(path), self.html)

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{html.escape(self.html)}" style="width: 100%; height: 640px; border: 0" '
            'sandbox="allow-scripts"></iframe>'
        )


def check_page_place(path: str | os.PathLike[str]) -> Path:
    """`path` as a place for a page; worth asking before long work.

    Raises:
        InputError: another suffix, no such folder, or a folder of that name.
    """
    from cutjoint.errors import InputError

    target = check_place(path)
    if target.suffix != SUFFIX:
        raise InputError(f"a report is written as {SUFFIX}; found {str(target)!r}")
    return target


def run_report(runs: Runs, *, robot: ClosedChain | None = None, file: str | os.PathLike[str] | None = None) -> RunPage:
    """A page about a run, or several beside each other.

    Args:
        runs: a result, several, or results by the names that legends and tables shall have.
        robot: that the runs were made with; default the one they name, where it is found.  Without it there are no
            reactions, no limits of joints and no animation, which the page says.
        file: where to write it too.

    Raises:
        InputError: runs of different robots, another robot, or no place for the file.
    """
    named = named_runs(runs)
    if file is not None:
        check_page_place(file)
    robots, why_none = robots_of(named, robot)
    made = _page(named, robots, why_none)
    if file is not None:
        made.save(file)
    return made


def _page(named: Mapping[str, Result], robots: Mapping[str, ClosedChain | None], why_none: str) -> RunPage:
    verdicts = {name: verdict_of(run, robots[name]) for name, run in named.items()}
    title = title_of(next(iter(named.values()))) if len(named) == 1 else _several(named)
    panels = {name: all_panels(run, robots[name]) for name, run in named.items()}
    frame, moving = _animation(named, robots, why_none)
    parts = {
        "Can it be believed?": _believed(verdicts, why_none),
        "How it was made": _beside(named, setting_rows),
        "What came of it": _beside(named, lambda run: figure_rows(run, figures_of(run)), also=_size)
        + _peaks(named, {name: found for name, (found, _) in panels.items()}),
        "Curves": _curves(panels),
        "Animation": moving,
    }
    links = "".join(f'<a href="#s{i}">{html.escape(name)}</a>' for i, name in enumerate(parts))
    sections = "\n".join(
        f'<section><h2 id="s{i}">{html.escape(name)}</h2>\n{part}</section>'
        for i, (name, part) in enumerate(parts.items())
    )
    lead = "; ".join(
        f"{name}: {len(run)} samples from {run.time[0]:g} s to {run.time[-1]:g} s" for name, run in named.items()
    )
    overall = "\n".join(
        f'<div class="overall {one.grade}"><b>{html.escape(name)}</b>{html.escape(one.sentence)}</div>'
        for name, one in verdicts.items()
    )
    body = (
        f'<h1>{html.escape(title)}</h1>\n<p class="lead">{html.escape(lead)}</p>\n<nav>{links}</nav>\n{overall}\n'
        f"{sections}"
    )
    return RunPage(title, page_of(title, body, REPORT, [frame] if frame else []), verdicts)


def _several(named: Mapping[str, Result]) -> str:
    return f"{len(named)} runs: {', '.join(f'{name}{early(run)}' for name, run in named.items())}"


def _table(table: TextTable) -> str:
    return f'<div class="scroll">{table.html()}</div>'


def _believed(verdicts: Mapping[str, Belief], why_none: str) -> str:
    text = ""
    for name, verdict in verdicts.items():
        rows = [
            (one.name, one.found, one.good, Cell(WORDS[one.grade], one.grade) if one.grade else "not looked at")
            for one in verdict.signs
        ]
        text += _table(TextTable(name, ("sign", "found", "good is", "verdict"), rows))
    note = f"The robot is not at hand, so what needs it is missing: {why_none}." if why_none else ""
    return text + (f'<p class="note">{html.escape(note)}</p>' if note else "")


def _size(run: Result) -> list[tuple[str, str]]:
    return [("samples", f"{len(run)} from {run.time[0]:g} s to {run.time[-1]:g} s")]


def _beside(
    named: Mapping[str, Result],
    rows_of: Callable[[Result], list[tuple[str, str]]],
    also: Callable[[Result], list[tuple[str, str]]] | None = None,
) -> str:
    """Rows of words of every run, a column each."""
    columns = {
        name: _joined([*(_motion(run) if also is None else also(run)), *rows_of(run)]) for name, run in named.items()
    }
    names = list(dict.fromkeys(name for rows in columns.values() for name in rows))
    rows = [(name, *(own.get(name, "–") for own in columns.values())) for name in names]
    return _table(TextTable("", ("", *columns), rows))


def _motion(run: Result) -> list[tuple[str, str]]:
    """Robot, law and motion of a run."""
    about = run.about
    found = [("robot", about.get("plant", about.get("robot", ""))), ("controller", about.get("law", ""))]
    return [*found, ("trajectory", about.get("trajectory", "none: nothing was followed"))]


def _joined(rows: Sequence[tuple[str, str]]) -> dict[str, str]:
    """Rows by name; those without a name go on with the one before."""
    found: dict[str, str] = {}
    last = ""
    for name, words in rows:
        last = name.strip() or last
        found[last] = f"{found[last]}; {words}" if last in found else words
    return found


def _peaks(named: Mapping[str, Result], panels: Mapping[str, Mapping[str, Sequence[Panel]]]) -> str:
    """Tables of the largest force and moment in every joint."""
    text = ""
    for name, found in panels.items():
        if "reactions" not in found:
            continue
        rows: list[tuple[str, ...]] = []
        force, moment = found["reactions"]
        for i, joint in enumerate(force.names):
            cells = [joint]
            for panel in (force, moment):
                worst = int(np.argmax(panel.values[:, i]))
                cells += [f"{panel.values[worst, i]:.4g}", f"{panel.time[worst]:.4g}"]
            rows.append(tuple(cells))
        columns = ("joint or cut", "force [N]", "at [s]", "moment [N m]", "when [s]")
        note = f"Of {len(force.time)} of the {len(named[name])} samples."
        text += _table(TextTable(f"{name}: largest reactions", columns, rows, columns[1:], note))
    return text


def _curves(panels: Mapping[str, tuple[Mapping[str, Sequence[Panel]], Mapping[str, str]]]) -> str:
    drawn = {name: [one for group in found.values() for one in group] for name, (found, _) in panels.items()}
    reasons: dict[str, list[str]] = {}
    for run, (_, left) in panels.items():
        for name, why in left.items():
            reasons.setdefault(f"{name}: {why}", []).append(run)
    told = [text if len(runs) == len(panels) else f"{text} ({', '.join(runs)})" for text, runs in reasons.items()]
    note = f'<p class="note">Not shown: {html.escape("; ".join(told))}.</p>' if told else ""
    return curves(overlaid(drawn), "curves") + note


def _animation(named: Mapping[str, Result], robots: Mapping[str, ClosedChain | None], why_none: str) -> tuple[str, str]:
    """The player's page of the first run, and the part of this page that holds it, or says why there is none."""
    name, run = next(iter(named.items()))
    robot = robots[name]
    if robot is None:
        return "", f"<p>There is no animation: {html.escape(why_none)}.</p>"
    try:
        from cutjoint.extras import needed

        needed("meshcat", "an animation")
        from cutjoint.viewer import play

        page = play(robot, run).html
    except CutjointError as error:
        return "", f"<p>There is no animation: {html.escape(str(error))}</p>"
    which = f"<p>Of the first run, {html.escape(name)}.</p>" if len(named) > 1 else ""
    frame = (
        f'<iframe title="animation of {html.escape(name)}" srcdoc="{html.escape(page)}" sandbox="allow-scripts" '
        'loading="lazy"></iframe>'
    )
    return page, f'{which}{frame}<p class="note paper">On paper there is no animation.</p>'
