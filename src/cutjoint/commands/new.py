"""`cutjoint new`: a folder with a robot of a template, to begin with."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint.commands import options
from cutjoint.commands.failing import complain
from cutjoint.commands.output import print_json, say, width, write
from cutjoint.drafting.folder import ALUMINIUM
from cutjoint.drafting.templates import DEFAULT, TEMPLATES
from cutjoint.texts import broad, harmless, padded

if TYPE_CHECKING:
    from cutjoint.drafting import NewRobot

NEXT = (
    ("check", "what is wrong after a change, and the mobility"),
    ("view", "in the browser, with a slider per motor"),
    ("simulate", "under a controller"),
)
"""What one does with a new robot, and why."""
KINDS = "; ".join(f"{name} ({row.about})" for name, row in TEMPLATES.items())


def with_sizes(command: options.Command) -> options.Command:
    """`command`, whose `**sizes` become an option for every size of every template, with a help that says whose it
    is."""
    takers: dict[str, list[str]] = {}
    for template, row in TEMPLATES.items():
        for name, size in row.sizes.items():
            takers.setdefault(name, []).append(f"{template}: {size.about} ({size.default:g})")
    helps = {name: f"{'; '.join(about)}." for name, about in takers.items()}
    return options.with_options(command, helps, "M", "Sizes in metres, by template")


@with_sizes
def command(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the robot: letters, digits, _ and -.")],
    template: Annotated[str, typer.Option("--template", "-t", metavar="KIND", help=f"{KINDS}.")] = DEFAULT,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FOLDER", help="The folder to make; default NAME.")
    ] = None,
    density: Annotated[
        str, typer.Option(metavar="KG/M3", help="Density of the links, which gives their masses; aluminium.")
    ] = f"{ALUMINIUM:g}",
    json: options.Json = False,
    **sizes: str | None,
) -> None:
    """Make a folder with a new robot that closes, moves and weighs something: a template in the sizes you say.

    The folder gets robot.urdf (the open tree), loops.toml (what closes it, motors, tool, home) and a README.md, all
    with comments.  It must be new or empty; it is written whole or not at all.

    Exit status: 0 if it was written, 2 if it cannot be: the name, a size, or sizes that do not close.
    """
    from cutjoint.drafting import draft, write_draft

    given = {one: _number(f"--{one}", text, "metres", 0.12) for one, text in sizes.items() if text is not None}
    made = draft(name, template, given, _number("--density", density, "kg/m3", ALUMINIUM))
    folder = Path(name) if out is None else out
    files = write_draft(made, folder)
    if json:
        print_json(_data(made, folder, files))
    else:
        _show(made, folder)


def _number(option: str, text: str, unit: str, example: float) -> float:
    from cutjoint.errors import InputError, shown

    try:
        return float(text)
    except ValueError:
        raise InputError(f"{option} must be a number of {unit}, such as {example:g}; found '{shown(text)}'") from None


def _data(made: NewRobot, folder: Path, files: tuple[Path, ...]) -> dict[str, object]:
    return {
        "name": made.name,
        "template": made.template,
        "folder": str(folder),
        "files": [str(one) for one in files],
        "sizes": dict(made.sizes),
        "density": made.density,
        "mobility": made.report.mobility,
        "actuators": made.report.actuators,
        "warnings": list(made.told),
    }


def _show(made: NewRobot, folder: Path) -> None:
    report = made.report
    ways, motors = ("way", "ways")[report.mobility > 1], ("motor", "motors")[report.actuators > 1]
    say(f"made {folder}: {made.title}, moves in {report.mobility} {ways}, {report.actuators} {motors}")
    if made.sizes:
        say(", ".join(f"{name} {value:g} m" for name, value in made.sizes.items()), first="  ")
    for one in made.told:
        complain(f"warning: {one}")
    path = options.as_argument(folder)
    say()
    say("next:")
    lines = [(harmless(f"cutjoint {action} {path}"), about) for action, about in NEXT]
    room = max(broad(line) for line, _ in lines)
    beside = 2 + room + max(len(about) for _, about in lines) + len("  # ") <= width()
    for line, about in lines:
        write(f"  {padded(line, room)}  # {about}" if beside else f"  # {about}\n  {line}")
