"""`cutjoint synthesise`: lengths, mounting and masses of a robot chosen for what it shall be able to do."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint import interrupts
from cutjoint.commands import options
from cutjoint.commands.output import print_json, say, show, write_path
from cutjoint.commands.progress import progress
from cutjoint.commands.stopping import stopped

if TYPE_CHECKING:
    from cutjoint.synthesis import Synthesis


def command(
    file: Annotated[
        Path, typer.Argument(metavar="FILE.toml", help="What may be chosen and what is wanted (docs/synthesis.md).")
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FOLDER", help="A new folder for the new robot and its report."),
    ] = None,
    designs: Annotated[int | None, typer.Option(min=2, help="How many are judged; default as in the file.")] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Of the search; default as in the file.")] = None,
    take: Annotated[
        int | None, typer.Option(min=0, metavar="NUMBER", help="The design to take; default the best.")
    ] = None,
    json: options.Json = False,
) -> None:
    """Choose lengths, mounting and masses of a robot for what it shall be able to do.

    The file names numbers of the robot that may vary, links that may be stretched or how it may be mounted, and what
    is wanted: workspace, stiffness, isotropy, effort, power, cycle time, mass. With several goals the front of designs
    that none beats is searched, with one goal the best design. Exit status 1: no design does.
    """
    from cutjoint.errors import InputError, Interrupted
    from cutjoint.extras import needed
    from cutjoint.synthesis import read_order, synthesise
    from cutjoint.synthesis.keeping import check_folder, keep

    order = read_order(file)
    if out is not None:
        check_folder(out)
        needed("matplotlib", "the report of a synthesis")
    count, start = designs or order.designs, order.seed if seed is None else seed
    if take is not None and take >= count:
        raise InputError(f"--take must be one of the designs 0 to {count - 1}, found {take}")
    halted = False
    with interrupts.keeping():
        try:
            with progress(f"{order.problem.robot.name}: designs", count, "designs") as told:
                found = synthesise(order.problem, count, start, told)
        except Interrupted as stop:
            if out is None:
                raise
            found, halted = stop.result, True  # type: ignore[assignment]
        status = 0 if found.front else 1
        taken = _taken(found, take)
        if out is not None and taken is not None:
            from cutjoint.report.answers.synthesis import synthesis_page

            written = keep(found, out, synthesis_page(found, taken), taken)
        else:
            written = ()
    if json:
        print_json(found.as_json(taken))
    else:
        _tell(found, taken)
        for one in written:
            write_path(one)
    raise stopped(f"{len(found.designs)} of {count} designs were judged") if halted else typer.Exit(status)


def _taken(found: Synthesis, take: int | None) -> int | None:
    """Number of the design that is taken; None where none does."""
    if take is not None:
        found.description(take)
        return take
    return found.best if found.front else None


def _tell(found: Synthesis, taken: int | None) -> None:
    if taken is None:
        say(f"None of {len(found.designs)} designs does what is wanted.")
    else:
        show(found.front_table())
        show(found.against_old(taken))
    for told in found.told:
        say(told)
    for why, count in found.reasons():
        say(f"{count} of {len(found.designs)} designs do not do: {why}")
    if taken is None:
        first = next(one for one in found.designs if one.why)
        say(f"the robot as it is: {found.old.why or 'does'}; for one: {first.why}")
