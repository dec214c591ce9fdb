"""`cutjoint reproduce`: the papers' experiments, run again and judged."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint import interrupts
from cutjoint.commands import completing
from cutjoint.commands.output import say, show
from cutjoint.commands.progress import progress
from cutjoint.commands.stopping import stopped, stopped_name
from cutjoint.tables import TextTable
from cutjoint.texts import Cell

if TYPE_CHECKING:
    from collections.abc import Sequence

    from cutjoint.report import Section


def command(
    robot: Annotated[
        str,
        typer.Argument(
            metavar="cpm|omega3|all", help="Whose paper.", autocompletion=completing.words("cpm", "omega3", "all")
        ),
    ] = "all",
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

    from cutjoint.errors import Interrupted
    from cutjoint.experiments.study import PARTS, reproduce, tasks
    from cutjoint.files import check_place
    from cutjoint.report.figures import plotting

    check_place(output)
    plotting()
    robots = list(PARTS) if robot == "all" else [robot]
    began = time.perf_counter()
    with interrupts.keeping():
        try:
            with progress("simulating", len(tasks(robots)), "runs") as told:
                sections = reproduce(robots, told)
        except Interrupted as error:
            written = _write(stopped_name(output), error.result)  # type: ignore[arg-type]
            raise stopped(f"{error}; what can be shown of them is in {written}") from None
        _write(output, sections)
    for section in (one for one in sections if one.printed):
        for part in section.parts:
            if isinstance(part, TextTable):
                show(part)
    size, spent = output.stat().st_size / 1e6, time.perf_counter() - began
    say(Cell("the report: ", "bold"), f"{output}, {size:.1f} MB with all figures, made in {spent:.0f} s")


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
