"""Loads from outside on the command line: LINK:FX,FY,FZ or LINK:FX,FY,FZ,MX,MY,MZ, the tool by the name `tool`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import numpy as np
import typer

from cutjoint.errors import InputError
from cutjoint.mechanism import Load

OutsideLoads = Annotated[
    list[str] | None,
    typer.Option(
        metavar="LINK:FX,FY,FZ[,MX,MY,MZ]",
        help="Force [N] and moment [N m] from outside, world axes, such as tool:0,0,-10; may be repeated.",
    ),
]
TOOL = "tool"
"""What stands for the tool, also where a link is called so."""


def loads_of(texts: Sequence[str]) -> list[Load]:
    """Loads as they are written: forces [N] and moments [N m] along the axes of the world, at the origin of the link or
    tool.

    Raises:
        InputError: something else is written.
    """
    found = []
    for text in texts:
        link, colon, rest = text.rpartition(":")
        try:
            numbers = [float(part) for part in rest.split(",")]
        except ValueError:
            numbers = []
        if not colon or len(numbers) not in (3, 6):
            raise InputError(
                f"--load wants LINK:FX,FY,FZ or LINK:FX,FY,FZ,MX,MY,MZ, such as tool:0,0,-10 in [N] and [N m]; found "
                f"{text!r}"
            )
        force, moment = np.array(numbers[:3]), np.array(numbers[3:] or [0.0, 0.0, 0.0])
        found.append(Load(force, moment, None if link == TOOL else link))
    return found
