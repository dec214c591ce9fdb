"""How commands print: tables and texts for the width there is, colour on a terminal alone, plain JSON for machines."""

from __future__ import annotations

import contextlib
import json
import math
import os
import shutil
import sys
from itertools import groupby
from typing import TextIO

import numpy as np
import typer

from cutjoint.tables import WIDTH, TextTable
from cutjoint.texts import harmless, wrapped

LEAST_WIDTH = 20
COLOURS = {
    "bold": {"bold": True},
    "dim": {"dim": True},
    "caution": {"fg": "yellow"},
    "good": {"fg": "green"},
    "half": {"fg": "yellow"},
    "bad": {"fg": "red", "bold": True},
}


def width() -> int:
    """Columns to print in: `COLUMNS`, else those of the terminal, else 80, also where the output is piped."""
    return max(LEAST_WIDTH, shutil.get_terminal_size((WIDTH, 24)).columns)


def is_terminal(stream: TextIO | None) -> bool:
    """Whether somebody looks at it who can do with a cursor that moves."""
    try:
        return stream is not None and stream.isatty() and os.environ.get("TERM") != "dumb"
    except ValueError:  # it is closed
        return False


def paint(text: str, style: str) -> str:
    """The text in the look of a style, where standard output shows colours and `NO_COLOR` does not forbid them."""
    if style not in COLOURS or os.environ.get("NO_COLOR") or not is_terminal(sys.stdout):
        return text
    return typer.style(text, **COLOURS[style])  # type: ignore[arg-type]


def show(table: TextTable) -> None:
    """Print a table and a blank line."""
    write(table.text(width(), paint) + "\n")


def write(text: str) -> None:
    """Write a text and a line break to standard output as they are, or nowhere if nobody reads any more (`| head`).

    Raises:
        OSError: nothing can be written there.
    """
    try:
        if sys.stdout is not None:
            print(text, flush=True)
    except BrokenPipeError:
        with contextlib.suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        raise OSError(error.errno, error.strerror, "standard output") from error


def write_path(path: os.PathLike[str]) -> None:
    """Write a path on a line: as it is for programs, on a terminal with nothing in it that moves the cursor."""
    text = os.fspath(path)
    write(harmless(text) if is_terminal(sys.stdout) else text)


def say(*parts: str, first: str = "") -> None:
    """Print a line, wrapped at words; parts of it may be a `Cell` with a style.  `first` stands before it, and
    as many blanks before further lines; nothing in it moves the cursor."""
    texts = [(harmless(part), getattr(part, "style", "")) for part in parts]
    styled = iter([(one, style) for text, style in ((first, ""), *texts) for one in text if one != " "])
    for line in wrapped("".join(text for text, _ in texts), width(), first, " " * len(first)) or [""]:
        looks = [(" ", "") if one == " " else next(styled) for one in line]
        runs = (("".join(one for one, _ in run), style) for style, run in groupby(looks, lambda look: look[1]))
        write("".join(paint(text, style) for text, style in runs))


def print_json(value: object) -> None:
    """Print `value` as JSON; arrays become lists, numbers that are not finite become null."""
    write(json.dumps(plain(value), indent=2))


def plain(value: object) -> object:
    """`value` as JSON knows it: arrays as lists, numbers that are not finite as None."""
    if isinstance(value, dict):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
