"""The robot that runs were made with, as options name it, else as a saved run does."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint.errors import InputError

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain
    from cutjoint.simulation import Result

Robot = Annotated[
    str | None,
    typer.Option(metavar="ROBOT", help="The robot of the runs, where it is not found by the name that they tell."),
]


def robot_of_run(result: Result, robot: str | None, variant: str | None, lenient: bool) -> ClosedChain:
    """The robot as asked for, else as the result names it.

    Raises:
        InputError: the result names no robot that is here.
        CutjointError: as of loading it.
    """
    from cutjoint.report.named_runs import robot_of
    from cutjoint.robots import load

    if robot is not None:
        return load(robot, variant, lenient=lenient)
    return robot_of(result, variant, lenient=lenient)


def beside(run: Path, suffix: str) -> Path:
    """The file of another kind beside a run.

    Raises:
        InputError: it is no name of a file.
    """
    if not run.name:
        raise InputError(f"'{run}' is no result file; give a .npz that `cutjoint simulate --save` wrote")
    return run.with_suffix(suffix)


def robot_of_options(robot: str | None, variant: str | None, ideal: bool, lenient: bool) -> ClosedChain | None:
    """The robot that is asked for; None where none is.

    Raises:
        InputError: options of a robot, and none.
        UnknownNameError, DescriptionError, ClosureError: as of `robots.load`.
    """
    if robot is None:
        used = [name for name, on in (("--variant", variant), ("--ideal", ideal), ("--lenient", lenient)) if on]
        if used:
            raise InputError(f"{', '.join(used)} says more about a robot; give it too, with --robot ROBOT")
        return None
    from cutjoint.robots import load

    return load(robot, variant, dynamics="ideal" if ideal else "real", lenient=lenient)
