"""How commands print: one look for tables, plain JSON for machines, and the mobility report."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import typer

if TYPE_CHECKING:
    from rich.console import Console

    from cutjoint.chain import ClosedChain, MobilityReport
    from cutjoint.chain.modes import Modes


class TerminalTable:
    """A table that a terminal shows well and a pipe keeps readable; columns named in `right` are flush right."""

    def __init__(self, title: str, columns: Sequence[str], right: Sequence[str] = ()) -> None:
        from rich import box
        from rich.markup import escape
        from rich.table import Table as RichTable

        self._title = title
        self._table = RichTable(box=box.SIMPLE_HEAD, pad_edge=False, show_header=any(columns))
        for column in columns:
            # a unit such as [s] is no markup
            self._table.add_column(escape(column), justify="right" if column in right else "left", overflow="fold")

    def add_row(self, *cells: str) -> None:
        """Append a row; cells may hold rich's markup."""
        self._table.add_row(*cells)

    def print(self) -> None:
        """Write the table to standard output."""
        from rich.markup import escape

        out = console()
        self._keep_words_whole(out.width)
        out.print(f"[bold]{escape(self._title)}[/]")
        out.print(self._table)

    def _keep_words_whole(self, width: int) -> None:
        """Share `width` among the columns so that no number and no word is broken, as far as there is room."""
        from rich.text import Text

        columns = self._table.columns
        texts = [[Text.from_markup(str(cell)).plain for cell in (one.header, *one.cells)] for one in columns]
        natural = [max(map(len, column)) for column in texts]
        words = [max((len(word) for text in column for word in text.split()), default=0) for column in texts]
        numbers = [
            max(word, *map(len, column[1:])) if one.justify == "right" and len(column) > 1 else word
            for one, column, word in zip(columns, texts, words, strict=True)
        ]
        # A blank at either edge and three between two columns.
        room = width - 2 - 3 * (len(columns) - 1)
        widths = numbers if sum(numbers) <= room else words
        if sum(natural) <= room or sum(widths) > room:
            return
        for _ in range(room - sum(widths)):
            widths[max(range(len(widths)), key=lambda i: natural[i] - widths[i])] += 1
        for column, share in zip(columns, widths, strict=True):
            column.width = share


def console() -> Console:
    """Standard output; a pipe gets lines of 120 columns."""
    import sys

    from rich.console import Console

    return Console(highlight=False, width=None if sys.stdout.isatty() else 120)


def print_json(value: object) -> None:
    """Print `value` as JSON; arrays become lists, numbers that are not finite become null."""
    typer.echo(json.dumps(plain(value), indent=2))


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


def show_mobility(report: MobilityReport) -> None:
    """Print the mobility at home as a table."""
    from rich.markup import escape

    table = report.table()
    facts = TerminalTable("mobility at home", table.columns)
    for row in table.rows:
        facts.add_row(*map(escape, row))
    facts.print()


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
    from rich.markup import escape

    from cutjoint.errors import InputError

    if chain.description.tool is None:
        return
    try:
        task = chain.task
    except InputError as error:
        console().print(f"task: [yellow]{escape(str(error))}[/]", soft_wrap=True)
        return
    origin = "declared" if chain.description.task else "found at home"
    console().print(f"task: [bold]{task}[/] ({origin})", soft_wrap=True)
    places = zip(task.names, task.coordinates(task.home).tolist(), task.units, strict=True)
    home = ", ".join(f"{name} {value if abs(value) > 1e-12 else 0.0:.6g} {unit}" for name, value, unit in places)
    console().print(f"[dim]at home: {home}[/]", soft_wrap=True)


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
