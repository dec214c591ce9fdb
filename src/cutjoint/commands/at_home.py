"""Mobility, task and modes of a robot at home, printed and as plain data."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from cutjoint.commands.output import say, show
from cutjoint.tables import TextTable
from cutjoint.texts import Cell

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain, MobilityReport
    from cutjoint.chain.modes import Modes


def show_mobility(report: MobilityReport) -> None:
    """Print the mobility at home as a table."""
    state = "good" if report.determined else "caution"
    rows = [
        ("velocities of the open tree", str(report.velocities), ""),
        ("constraint rows", str(report.rows), f"{report.rank} independent"),
        ("redundant rows", str(len(report.redundant_rows)), Cell(", ".join(report.redundant_rows), "dim")),
        ("mobility", Cell(str(report.mobility), "bold"), ""),
    ]
    if report.idle:
        still = Cell(f"{', '.join(report.idle)}: the tool stays", "dim")
        rows.append(("of it idle", str(report.idle_mobility), still))
    rows.append(("actuators", str(report.actuators), Cell(_verdict(report), state)))
    if math.isfinite(report.type2):
        rows.append(("distance to a type-2 singularity", f"{report.type2:.4f}", "0 = moves with actuators locked"))
    if math.isfinite(report.type1):
        rows.append(("distance to a type-1 singularity", f"{report.type1:.4f}", "0 = tool cannot move somewhere"))
        rows.append(("condition of the tool Jacobian", f"{report.condition:.4g}", ""))
    rows.append(("loop gap", f"{report.gap[0]:.1e} m", f"{report.gap[1]:.1e} rad"))
    show(TextTable("mobility at home", ("", "", ""), rows))


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


def _verdict(report: MobilityReport) -> str:
    if report.determined:
        return "they determine the motion"
    moving = [joint for joint in report.free if joint not in report.idle]
    if moving:
        return f"locked, these still move: {', '.join(moving)}"
    surplus = report.actuators - report.mobility + report.idle_mobility
    return f"{surplus} more than the mobility (redundant actuation)"
