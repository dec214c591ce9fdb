"""`cutjoint report`: everything about a simulation, or several beside each other, as one page of HTML."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cutjoint import interrupts
from cutjoint.commands import options
from cutjoint.commands.output import say
from cutjoint.commands.progress import progress
from cutjoint.commands.run_robot import Robot, beside, robot_of_options


def command(
    runs: Annotated[
        list[Path],
        typer.Argument(metavar="RUN.npz...", help="Results that `cutjoint simulate --save` wrote, of one robot."),
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE.html", help="Default RUN.html beside the (first) run."),
    ] = None,
    robot: Robot = None,
    variant: options.Variant = None,
    ideal: options.Ideal = False,
    lenient: options.Lenient = False,
) -> None:
    """Write one page about a simulation: whether it can be believed, how it was made, curves, and the robot moving.

    The page needs nothing else and makes no network request.  Several runs stand beside each other, their curves over
    each other.
    """
    from cutjoint.report import run_report
    from cutjoint.report.named_runs import runs_of_files
    from cutjoint.report.own_files import REPORT, check_own
    from cutjoint.report.run_page import check_page_place

    target = check_page_place(beside(runs[0], ".html") if output is None else output)
    if output is None:
        check_own(target, REPORT)
    named, chain = runs_of_files(runs), robot_of_options(robot, variant, ideal, lenient)
    with progress(f"report of {', '.join(named)}"):
        made = run_report(named, robot=chain)
    for name, verdict in made.verdicts.items():
        say(f"{name}: {verdict.sentence}")
    with interrupts.keeping():
        written = made.save(target)
    say(f"wrote {written}")
