"""`cutjoint export`: a robot in another file format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cutjoint import interrupts
from cutjoint.commands import completing, options, output
from cutjoint.commands.failing import complain


def command(
    robot: options.Robot,
    to: Annotated[
        str,
        typer.Option(
            help="mjcf (MuJoCo), urdf (with the proposed <constraint>) or loops (loops.toml and URDF).",
            autocompletion=completing.formats,
        ),
    ] = "mjcf",
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="File, or folder for loops; default ROBOT in the working folder.")
    ] = None,
    variant: options.Variant = None,
    lenient: options.Lenient = False,
) -> None:
    """Write a robot in another format.  Reading the file back gives the same robot.

    What of its dampers, springs, stops and the like other programs will not find in the file is told on stderr, and so
    are shapes that are left out.
    """
    from cutjoint.description import load_description
    from cutjoint.description.formats import WRITERS, left_out, unsaid, write
    from cutjoint.errors import InputError, UnknownNameError, shown
    from cutjoint.files import path_name

    if to not in WRITERS:
        raise UnknownNameError("format", to, tuple(WRITERS))
    description = load_description(robot, variant, lenient)
    path = WRITERS[to].place(description.name) if out is None else out
    path_name(path)
    if path.is_dir() and not WRITERS[to].folder:
        raise InputError(f"{shown(str(path))} is a folder, and {WRITERS[to].name} is written to a file: name one in it")
    with interrupts.keeping():
        try:
            files = write(description, path, to)
        except OSError as error:
            raise InputError(f"cannot write {shown(str(path))}: {error.strerror or error}") from error
        for written in files:
            output.write_path(written)
    for lost in unsaid(description, to):
        complain(f"warning: {WRITERS[to].name} has no word for {lost}; only cutjoint reads it back")
    for lost in left_out(description, to):
        complain(f"warning: left out, since programs that read {WRITERS[to].name} cannot draw it: {lost}")
