"""`cutjoint reproduce`: the papers' experiments, run again and judged."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint import interrupts
from cutjoint.commands.output import TerminalTable, console
from cutjoint.commands.stopping import stopped, stopped_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from cutjoint.report import ReportTable, Section

COLOURS = {"good": "green", "half": "yellow", "bad": "red"}


def command(
    robot: Annotated[str, typer.Argument(metavar="cpm|omega3|all", help="Whose paper.")] = "all",
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE", help="The report, one HTML file that needs no network.")
    ] = Path("reproduction.html"),
) -> None:
    """Run the experiments of both papers again, print their tables and write one report with all figures.

    Table 3 of the Cartesian Parallel Manipulator by four models, its figures 9 to 22, the rule for its gains, the
    claims of both papers with a verdict each, the Omega-3's curve with other plants and a heavier payload, the cost of
    the papers' hypotheses, and every erratum.  Interrupted (Ctrl-C), it writes what there is under FILE's name with
    `.stopped` in it, and keeps the runs that are done: the next reproduction goes on from there.
    """
    import time

    from rich.progress import Progress

    from cutjoint.errors import Interrupted
    from cutjoint.experiments.study import PARTS, reproduce, tasks
    from cutjoint.files import check_place
    from cutjoint.report import ReportTable
    from cutjoint.report.figures import plotting

    check_place(output)
    plotting()
    robots = list(PARTS) if robot == "all" else [robot]
    began = time.perf_counter()
    with interrupts.keeping():
        try:
            with Progress(transient=True) as bar:
                task = bar.add_task("simulating", total=len(tasks(robots)))
                sections = reproduce(robots, lambda count: bar.update(task, completed=count))
        except Interrupted as error:
            written = _write(stopped_name(output), error.result)  # type: ignore[arg-type]
            raise stopped(f"{error}; what can be shown of them is in {written}") from None
        _write(output, sections)
    for section in sections:
        for part in section.parts:
            if isinstance(part, ReportTable) and not part.wide:
                _print(part)
    console().print(f"{output}: {output.stat().st_size / 1e6:.1f} MB, {time.perf_counter() - began:.0f} s")


def _write(output: Path, sections: Sequence[Section]) -> Path:
    """Write the page."""
    from cutjoint import __version__
    from cutjoint.files import write_whole
    from cutjoint.report import page

    title = "Two parallel robots: their papers' experiments, reproduced"
    lead = (
        f"Made by cutjoint {__version__}. Every number was computed for this page; what could not be "
        "reproduced is said so. SI units."
    )
    return write_whole(output, page(title, lead, sections))


def _print(part: ReportTable) -> None:
    """A table of numbers the way that fits the terminal; rows of text as paragraphs."""
    from rich.markup import escape
    from rich.padding import Padding

    from cutjoint.report.page import MARKS, verdict_style

    out = console()
    if not part.is_text:
        fitting = part.fitting(out.width)
        shown = TerminalTable(part.title, fitting.columns, fitting.right)
        for row in fitting.rows:
            shown.add_row(*map(escape, row))
        shown.print()
        return
    out.print(f"[bold]{escape(part.title)}[/]\n")
    for where, *lines in part.rows:
        for number, line in enumerate(lines):
            style = verdict_style(line)
            text = f"[{COLOURS[style]}]{MARKS[style]} {escape(line)}[/]" if style else escape(line)
            if number == 0:
                text = f"{text} [dim]({escape(where)})[/]"
            out.print(Padding(text, (0, 0, 0, 1 if number == 0 else 5)))
        out.print()
