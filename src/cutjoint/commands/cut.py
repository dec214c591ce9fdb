"""`cutjoint cut`: where a robot with loops may be cut, and a folder with it cut there."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint.commands import options
from cutjoint.commands.failing import complain
from cutjoint.commands.output import print_json, say, show, write
from cutjoint.tables import TextTable
from cutjoint.texts import harmless

if TYPE_CHECKING:
    from cutjoint.drafting.cutting.proposal import Proposal


def command(
    file: Annotated[str, typer.Argument(metavar="FILE", help="A robot's file or folder, or the name of a robot.")],
    cut: Annotated[
        list[str] | None,
        typer.Option("--cut", metavar="JOINT", help="Cut this joint of a loop instead; may be repeated."),
    ] = None,
    type: Annotated[
        list[str] | None,
        typer.Option("--type", metavar="CUT=TYPE", help="Take another type for a cut at a pair of frames; repeatable."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FOLDER", help="Write loops.toml and robot.urdf there, a new folder."),
    ] = None,
    lenient: options.Lenient = False,
    json: options.Json = False,
) -> None:
    """Propose where to cut a robot with loops: frames that belong together, types of cuts, other joints to cut.

    FILE is a URDF with frames at which a loop closes (closing_X_1 and closing_X_2, X_closed_1 and X_closed_2, X_loop_a
    and X_loop_b, or ends that lie in one place at zero), or any file that has loops itself: a URDF in which a link has
    two parents, SDF, MJCF, USD, loops.toml.  Mobility and redundant rows are of the whole robot.

    Exit status: 0 if loops were found and close, 1 if nothing is there to close, 2 if the file is wrong or its loops
    do not close.
    """
    from cutjoint.drafting.cutting.proposing import propose
    from cutjoint.drafting.folder import write_description

    found = propose(file, cut or (), options.assigned("the type of a cut", "--type CUT=TYPE", type or ()), lenient)
    files = () if out is None or found.robot is None else write_description(found.robot, out, _head(file, found))
    if json:
        print_json(_data(file, found, files))
    else:
        _show(file, found)
        for one in files:
            say(f"wrote {one}")
        if out is not None and files:
            write(harmless(f"next: cutjoint check {options.as_argument(out)}"))
    if found.robot is None:
        raise typer.Exit(1)


def _head(file: str, found: Proposal) -> str:
    """What the file of cuts begins with: where it is from, and what is still to be decided."""
    from cutjoint.errors import shown

    lines = [f"Cut by `cutjoint cut` out of {shown(Path(file).name)}: what closes the tree of robot.urdf."]
    for one in found.cuts:
        others = [f"{choice.type} (mobility {choice.mobility})" for choice in one.choices[1:] if choice.closes]
        if others:
            lines.append(f"'{one.name}' is {one.type} (mobility {one.choices[0].mobility}); else {', '.join(others)}.")
    if found.chose_motors:
        lines.append("The actuators are a choice: name those that your robot has.")
    return "".join(f"# {line}\n" for line in lines)


def _data(file: str, found: Proposal, files: tuple[Path, ...]) -> dict[str, object]:
    def plain(one: object) -> dict[str, object]:
        return {key: getattr(one, key) for key in getattr(one, "__dataclass_fields__", ())}

    return {
        "file": file,
        "cuts": [plain(one) | {"choices": [plain(choice) for choice in one.choices]} for one in found.cuts],
        "actuators": [] if found.robot is None else list(found.robot.actuators),
        "actuators_chosen": found.chose_motors,
        "mobility": None if found.report is None else plain(found.report),
        "told": list(found.told),
        "ends": list(found.ends),
        "files": [str(one) for one in files],
    }


def _show(file: str, found: Proposal) -> None:
    from cutjoint.errors import shown

    if found.robot is None or found.report is None:
        say(f"{shown(file)}: nothing to close: no loop in the file, and no two frames that belong together")
        if found.ends:
            say(f"bodies that carry no other end at: {', '.join(found.ends)}")
        say("put a link without mass on a fixed joint at either end of a cut, such as loop_a and loop_b")
    else:
        for table in _tables(found):
            show(table)
        report = found.report
        say(
            f"mobility {report.mobility}, {report.rows} rows, {len(report.redundant_rows)} of them redundant; closed "
            f"to {report.gap[0]:.1e} m, {report.gap[1]:.1e} rad"
        )
        whose = "chosen here, the file names none that move it" if found.chose_motors else "as the file says"
        say(f"actuators ({whose}): {', '.join(found.robot.actuators) or 'none'}")
    for one in found.told:
        complain(f"note: {one}")


def _tables(found: Proposal) -> Iterator[TextTable]:
    rows = [(one.name, one.type, *one.frames, one.why, f"{one.distance:.3g}", f"{one.angle:.3g}") for one in found.cuts]
    columns = ("cut", "type", "frame on", "and on", "told by", "apart [m]", "turned [rad]")
    note = "Apart and turned: the two frames in the zero configuration, loops open."
    yield TextTable("cuts", columns, rows, right=columns[-2:], note=note)
    choices = [
        (
            one.name,
            choice.type,
            "proposed" if number == 0 else "",
            str(choice.mobility) if choice.closes else "open",
            str(choice.redundant) if choice.closes else "-",
        )
        for one in found.cuts
        for number, choice in enumerate(one.choices)
    ]
    if choices:
        heads = ("cut", "type", "", "mobility", "redundant rows")
        yield TextTable("types that these cuts may have", heads, choices, right=heads[-2:])
    instead = [(one.name, ", ".join(one.instead)) for one in found.cuts if one.instead]
    if instead:
        note = "Take one with --cut JOINT: mobility and redundant rows stay."
        yield TextTable("joints that may be cut instead, the best first", ("cut", "joints"), instead, note=note)
