"""`cutjoint plot`: curves of a simulation, or of several over each other, as a picture or a page to read off."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cutjoint import interrupts
from cutjoint.commands import options
from cutjoint.commands.output import say
from cutjoint.commands.progress import progress
from cutjoint.commands.run_robot import Robot, beside, robot_of_options

WHAT = (
    "error, orientation, tool, tool_velocity, joints, velocity, effort, power, command, measured, passive, energy, gap"
)


def command(
    runs: Annotated[
        list[Path],
        typer.Argument(metavar="RUN.npz...", help="Results that `cutjoint simulate --save` wrote, of one robot."),
    ],
    what: Annotated[
        str,
        typer.Option(
            metavar="NAME,...", help=f"Of {WHAT}, and reactions; default the tool, joints, efforts and power."
        ),
    ] = "",
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="FILE", help="A .svg, .png or .html; default RUN.svg beside the (first) run."
        ),
    ] = None,
    robot: Robot = None,
    variant: options.Variant = None,
    ideal: options.Ideal = False,
    lenient: options.Lenient = False,
    start: Annotated[float | None, typer.Option("--from", metavar="S", help="First time to show, in seconds.")] = None,
    end: Annotated[float | None, typer.Option("--to", metavar="S", help="Last time to show, in seconds.")] = None,
) -> None:
    """Draw curves of a simulation over time, or of several over each other.

    As .html a page that needs nothing else, with a cursor that reads values off and a zoom; as .svg or .png a figure.
    """
    from cutjoint.report import plot
    from cutjoint.report.named_runs import runs_of_files
    from cutjoint.report.own_files import PLOT, check_own
    from cutjoint.report.run_plot import check_plot_place

    target = check_plot_place(beside(runs[0], ".svg") if output is None else output)
    if output is None:
        check_own(target, PLOT)
    named, chain = runs_of_files(runs), robot_of_options(robot, variant, ideal, lenient)
    with progress(f"plot of {', '.join(named)}"):
        made = plot(named, what, robot=chain, start=start, end=end)
        with interrupts.keeping():
            written = made.save(target)
    say(f"wrote {written}")
