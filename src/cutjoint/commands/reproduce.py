"""`cutjoint reproduce`: the papers' experiments, run again and judged."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cutjoint.commands.output import console, table


def command(
    robot: Annotated[str, typer.Argument(metavar="cpm|omega3|all", help="Whose paper.")] = "all",
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE", help="The report, one HTML file that needs no network.")
    ] = Path("reproduction.html"),
) -> None:
    """Run the experiments of both papers again, print their tables and write one report with all figures.

    Table 3 of the Cartesian Parallel Manipulator by four models, its figures 9 to 22, the rule for its gains, the
    claims of both papers with a verdict each, the Omega-3's curve with other plants and a heavier payload, the cost of
    the papers' hypotheses, and every erratum.
    """
    import time

    from rich.markup import escape
    from rich.progress import Progress

    from cutjoint import __version__
    from cutjoint.experiments.study import PARTS, reproduce, tasks
    from cutjoint.files import check_place, write_whole
    from cutjoint.report import Table, page
    from cutjoint.report.figures import plotting

    check_place(output)
    plotting()
    robots = list(PARTS) if robot == "all" else [robot]
    began = time.perf_counter()
    with Progress(transient=True) as bar:
        task = bar.add_task("simulating", total=len(tasks(robots)))
        sections = reproduce(robots, lambda count: bar.update(task, completed=count))
    for section in sections:
        for part in section.parts:
            if isinstance(part, Table) and not part.wide:
                shown = table(
                    escape(part.title), [escape(one) for one in part.columns], [escape(one) for one in part.right]
                )
                for row in part.rows:
                    shown.add_row(*map(escape, row))
                shown.print()
    title = "Two parallel robots: their papers' experiments, reproduced"
    lead = (
        f"Made by cutjoint {__version__}. Every number was computed for this page; what could not be "
        "reproduced is said so. SI units."
    )
    write_whole(output, page(title, lead, sections))
    console().print(f"{output}: {output.stat().st_size / 1e6:.1f} MB, {time.perf_counter() - began:.0f} s")
