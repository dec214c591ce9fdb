"""The mobility report as commands show it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from cutjoint.commands.output import TerminalTable

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain, MobilityReport
    from cutjoint.chain.modes import Modes


def show_mobility(report: MobilityReport) -> None:
    """Print the mobility at home as a table."""
    facts = TerminalTable("mobility at home", ("", "", ""))
    facts.add_row("velocities of the open tree", str(report.velocities), "")
    facts.add_row("constraint rows", str(report.rows), f"{report.rank} independent")
    redundant = ", ".join(report.redundant_rows)
    facts.add_row("redundant rows", str(len(report.redundant_rows)), f"[dim]{redundant}[/]")
    facts.add_row("mobility", f"[bold]{report.mobility}[/]", "")
    if report.idle:
        facts.add_row("of it idle", str(report.idle_mobility), f"[dim]{', '.join(report.idle)}: the tool stays[/]")
    facts.add_row("actuators", str(report.actuators), _verdict(report))
    if math.isfinite(report.type2):
        facts.add_row("distance to a type-2 singularity", f"{report.type2:.4f}", "0 = moves with the actuators locked")
    if math.isfinite(report.type1):
        facts.add_row("distance to a type-1 singularity", f"{report.type1:.4f}", "0 = the tool cannot move somewhere")
        facts.add_row("condition of the tool Jacobian", f"{report.condition:.4g}", "")
    facts.add_row("loop gap", f"{report.gap[0]:.1e} m", f"{report.gap[1]:.1e} rad")
    facts.print()


def find_modes(chain: ClosedChain, assembly: bool = False) -> Modes | None:
    """Working modes at home, or the assembly modes; None where they are not discrete or the robot has no loops, or, for
    working modes, no tool."""
    from cutjoint.errors import ActuationError

    if not chain.description.cuts or (chain.description.tool is None and not assembly):
        return None
    try:
        return chain.assembly_modes() if assembly else chain.working_modes()
    except ActuationError:
        return None


def _verdict(report: MobilityReport) -> str:
    if report.determined:
        return "[green]they determine the motion[/]"
    moving = [joint for joint in report.free if joint not in report.idle]
    if moving:
        return f"[yellow]locked, these still move: {', '.join(moving)}[/]"
    surplus = report.actuators - report.mobility + report.idle_mobility
    return f"[yellow]{surplus} more than the mobility (redundant actuation)[/]"
