"""`cutjoint check`: everything that is wrong with a robot's files, at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint.commands import completing, options
from cutjoint.commands.acting import physics_data, show_physics
from cutjoint.commands.at_home import find_modes, show_mobility, show_task, task_at_home
from cutjoint.commands.output import print_json, say
from cutjoint.commands.progress import progress
from cutjoint.errors import shown
from cutjoint.texts import Cell
from cutjoint.tolerances import CLOSURE

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain, Modes
    from cutjoint.description import RobotDescription
    from cutjoint.errors import Problem


def command(
    file: Annotated[
        str,
        typer.Argument(
            metavar="FILE",
            help="A robot's file or folder, or the name of a robot.",
            autocompletion=completing.robots,
        ),
    ],
    lenient: options.Lenient = False,
    json: options.Json = False,
) -> None:
    """Every problem of a robot's files at once: where, what was found, what was expected, how to mend it.

    If the files are right the loops are closed at home, and the mobility there is shown: redundant rows by name, joints
    that stay free, distance to singularities, the tool's task, working modes.

    Exit status: 0 if the robot loads and closes (warnings or not), 1 if it does not.
    """
    from cutjoint.description import read_checked

    reading = read_checked(file, lenient)
    problems, chain = tuple(reading.problems), None
    if reading.description is not None:
        from cutjoint.chain.findings import kinematic_problems

        kinematic, chain = kinematic_problems(reading.description)
        problems += kinematic
    if json:
        print_json(_data(file, reading.description, problems, chain))
    else:
        _show(file, reading.description, problems)
        if chain is not None:
            _show_motion(chain)
    if any(problem.severity == "error" for problem in problems) or chain is None:
        raise typer.Exit(1)


def _data(
    file: str, robot: RobotDescription | None, problems: Sequence[Problem], chain: ClosedChain | None
) -> dict[str, object]:
    data: dict[str, object] = {
        "file": file,
        "loads": robot is not None,
        "closes": chain is not None,
        "problems": [{key: getattr(one, key) for key in one.__dataclass_fields__} for one in problems],
    }
    if chain is not None:
        report, modes = chain.mobility(), _modes(chain)
        data["mobility"] = {key: getattr(report, key) for key in report.__dataclass_fields__}
        data["task"] = task_at_home(chain)
        data["physics"] = physics_data(chain.description)
        data["gap_at_zero"] = chain.gap(chain.neutral)
        data["working_modes"] = None if modes is None else len(modes)
    return data


def _show_motion(chain: ClosedChain) -> None:
    say()
    show_mobility(chain.mobility())
    show_task(chain)
    show_physics(chain.description)
    distance, angle = chain.gap(chain.neutral)
    if chain.description.cuts or chain.description.couplings:
        closed = max(distance, angle) <= CLOSURE.value
        state = "closed" if closed else f"open by up to {distance:.3g} m and {angle:.3g} rad, which is usual"
        say(f"zero configuration: {state}")
        modes = _modes(chain)
        if modes is not None:
            say(f"working modes found at home: {len(modes)} (cutjoint info lists them)")


def _modes(chain: ClosedChain) -> Modes | None:
    with progress(f"{chain.name}: searching working modes"):
        return find_modes(chain)


def _show(file: str, robot: RobotDescription | None, problems: Sequence[Problem]) -> None:
    for problem in problems:
        style = "bad" if problem.severity == "error" else "caution"
        place = f"{problem.file}:{problem.line}" if problem.line else problem.file
        say(Cell(problem.severity, style), " " if place else "", Cell(place, "bold"))
        for what, text in (("found", problem.found), ("expected", problem.expected), ("mend", problem.mend)):
            if text:
                say(text, first=f"  {what:<8}  ")
    errors = sum(problem.severity == "error" for problem in problems)
    counts = f"{_count(errors, 'error')}, {_count(len(problems) - errors, 'warning')}"
    if robot is None:
        say(Cell(f"{shown(file) or 'no name'} does not load", "bad"), f": {counts}")
        if any(problem.tolerable for problem in problems if problem.severity == "error"):
            say(Cell("--lenient passes flaws that do not prevent computing", "dim"))
        return
    parts = [
        _count(len(robot.links), "link"),
        _count(len(robot.joints), "joint"),
        _count(len(robot.cuts), "cut joint"),
        _count(len(robot.couplings), "coupling"),
        _count(len(robot.actuators), "actuator"),
    ]
    say(Cell(f"{robot.name} loads", "good"), f": {counts}; {', '.join(parts)}")


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"
