"""Mobility, task and modes of a robot at home, printed and as plain data."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from cutjoint.commands.output import say, show
from cutjoint.texts import Cell

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain, MobilityReport
    from cutjoint.chain.modes import Modes


def show_mobility(report: MobilityReport) -> None:
    """Print the mobility at home as a table."""
    show(replace(report.table(), title="mobility at home"))


def task_at_home(chain: ClosedChain) -> dict[str, object] | None:
    """The task of a chain with its coordinates at home, or why it has none; None for a robot without a tool."""
    from cutjoint.errors import InputError

    if chain.description.tool is None:
        return None
    declared = bool(chain.description.task)
    try:
        task = chain.task
    except InputError as error:
        return {"names": [], "declared": declared, "problem": str(error)}
    home = zip(task.names, task.coordinates(task.home).tolist(), task.units, strict=True)
    return {
        "names": list(task.names),
        "axes": task.axes,
        "declared": declared,
        "home": [{"name": name, "value": value, "unit": unit} for name, value, unit in home],
        "problem": None,
    }


def show_task(chain: ClosedChain) -> None:
    """Print the task in a line or two; nothing for a robot without a tool."""
    from cutjoint.errors import InputError

    if chain.description.tool is None:
        return
    try:
        task = chain.task
    except InputError as error:
        say("task: ", Cell(str(error), "caution"))
        say()
        return
    origin = "declared" if chain.description.task else "found at home"
    say("task: ", Cell(str(task), "bold"), f" ({origin})")
    places = zip(task.names, task.coordinates(task.home).tolist(), task.units, strict=True)
    home = ", ".join(f"{name} {value if abs(value) > 1e-12 else 0.0:.6g} {unit}" for name, value, unit in places)
    say(Cell(f"at home: {home}", "dim"))
    say()


def find_modes(chain: ClosedChain, assembly: bool = False) -> Modes | None:
    """Working modes at home, or the assembly modes; None where they are not discrete or the robot has no loops, or, for
    working modes, no tool or no task."""
    from cutjoint.errors import ActuationError, InputError

    if not chain.description.cuts or (chain.description.tool is None and not assembly):
        return None
    try:
        return chain.assembly_modes() if assembly else chain.working_modes()
    except (ActuationError, InputError):
        return None
