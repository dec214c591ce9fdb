"""Reactions over a run for the command line: the file that is asked for, and the table of peaks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from cutjoint.commands.output import show
from cutjoint.commands.progress import progress
from cutjoint.tables import TextTable

if TYPE_CHECKING:
    from cutjoint.mechanism import Mechanism
    from cutjoint.simulation import ReactionHistory, Result


def check_reactions(file: Path, robot: Mechanism) -> None:
    """Before a long run: whether there will be reactions to write.

    Raises:
        InputError: not a place for a CSV file, or the robot is a published model, which has no joints of its own.
    """
    from cutjoint.chain import ClosedChain
    from cutjoint.errors import InputError
    from cutjoint.simulation.reactions import check_csv

    check_csv(file)
    if not isinstance(robot, ClosedChain):
        raise InputError(f"{robot.name} is a published model, without joints that carry anything; use --plant chain")


def save_reactions(file: Path, result: Result, robot: Mechanism) -> ReactionHistory:
    """Reactions of a run, in a CSV file too."""
    from cutjoint.chain import ClosedChain
    from cutjoint.simulation import reactions_of

    assert isinstance(robot, ClosedChain)
    with progress(f"{robot.name}: reactions", len(result), "samples") as told:
        found = reactions_of(result, robot, progress=told)
    found.save(file)
    return found


def peaks_data(found: ReactionHistory) -> list[dict[str, object]]:
    """The peaks as plain values."""
    return [
        {
            "name": one.name,
            "force_n": one.force,
            "force_at_s": one.force_time,
            "force_unique": one.force_unique,
            "moment_nm": one.moment,
            "moment_at_s": one.moment_time,
            "moment_unique": one.moment_unique,
        }
        for one in found.peaks
    ]


def show_peaks(found: ReactionHistory) -> None:
    """Print the table of peaks."""
    columns = ("joint or cut", "force [N]", "at [s]", "moment [N m]", "at [s]")
    rows = []
    for one in found.peaks:
        force, moment = f"{one.force:.4g}", f"{one.moment:.4g}"
        rows.append(
            (
                one.name,
                force if one.force_unique else f"{force} *",
                f"{one.force_time:.4g}",
                moment if one.moment_unique else f"{moment} *",
                f"{one.moment_time:.4g}",
            )
        )
    unique = all(one.force_unique and one.moment_unique for one in found.peaks)
    note = "" if unique else "* the loops are redundant: of the reactions that are possible, the least"
    show(TextTable("largest reactions", columns, rows, note=note))
