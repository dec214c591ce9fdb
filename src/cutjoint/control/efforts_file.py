"""Efforts over time from a CSV file.

The first line names the columns: `t`, and every actuator that is not locked.  A heading may have its unit behind it,
`t [s]`, `arm1 [N m]`, which must be the right one.  Commas part the cells; empty lines and such that begin with # are
passed over.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from cutjoint.control.given import EffortTable, GivenEfforts
from cutjoint.doors import door
from cutjoint.errors import FileError, InputError, UnknownNameError
from cutjoint.files import read_file
from cutjoint.mechanism import Actuator

LARGEST = 200_000_000
"""Largest file that is read [bytes]: some millions of rows."""
HEADING = re.compile(r"\s*(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\]]*)\])?\s*")


@door
def efforts_from_csv(path: str | Path, actuators: Sequence[Actuator], locked: Sequence[str] = ()) -> GivenEfforts:
    """The efforts in a CSV file, linear between its rows.

    Args:
        path: of the file.
        actuators: of the robot.
        locked: names of those that brakes hold; the file has no columns of them.

    Raises:
        InputError: no such file, or what is wrong in it, with line and column.
        UnknownNameError: a heading is no actuator.
    """
    source = Path(path)
    rows = _rows(source)
    try:
        line, headings = next(rows)
    except StopIteration:
        raise InputError(f"{source} is empty; its first line names the columns: {_wanted(actuators, locked)}") from None
    places = _columns(f"{source}:{line}", headings, actuators, locked)
    numbers = [_numbers(f"{source}:{line}", cells, headings) for line, cells in rows]
    if len(numbers) < 2:
        raise InputError(f"{source} has {len(numbers)} rows of numbers, expected two or more")
    table = np.array(numbers)
    efforts = np.zeros((len(table), len(actuators)))
    for actuator, column in places.items():
        efforts[:, actuator] = table[:, column]
    try:
        return GivenEfforts(EffortTable(table[:, [_bare(one) for one in headings].index("t")], efforts))
    except InputError as error:
        raise InputError(f"{source}: {error}") from error


def _rows(source: Path) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of every line that is neither empty nor a remark."""
    try:
        text = read_file(source, LARGEST).decode("utf-8-sig")
        reader = csv.reader(io.StringIO(text, newline=""), strict=True)
        for cells in reader:
            if any(cell.strip() for cell in cells) and not cells[0].lstrip().startswith("#"):
                yield reader.line_num, cells
    except FileError as error:
        why = f"there is no file {source}" if error.missing else f"{source} cannot be read: {error.why}"
        raise InputError(why) from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{source} cannot be read as CSV text in UTF-8: {error}") from error


def _columns(
    place: str, headings: Sequence[str], actuators: Sequence[Actuator], locked: Sequence[str]
) -> dict[int, int]:
    """Number of an actuator -> number of its column."""
    found = [_bare(one) for one in headings]
    units = {"t": "s", **{one.name: one.effort_unit for one in actuators if one.name not in locked}}
    for name, heading in zip(found, headings, strict=True):
        if name in locked:
            raise InputError(f"{place}: '{name}' is locked, so nothing is asked of it; leave its column out")
        if name not in units:
            told = UnknownNameError("column", name, list(units))
            raise InputError(f"{place}: {told}; expected {_wanted(actuators, locked)}")
        if found.count(name) > 1:
            raise InputError(f"{place}: column '{name}' is there twice")
        match = HEADING.fullmatch(heading)
        unit = match["unit"] if match else None
        if unit is not None and unit.replace(" ", "").lower() != units[name].replace(" ", "").lower():
            raise InputError(f"{place}: column '{name}' is in [{unit}], expected [{units[name]}]")
    if missing := [name for name in units if name not in found]:
        raise InputError(
            f"{place}: no column {', '.join(missing)}; expected {_wanted(actuators, locked)}, with zeros where nothing "
            "is asked"
        )
    return {i: found.index(one.name) for i, one in enumerate(actuators) if one.name in found}


def _numbers(place: str, cells: Sequence[str], headings: Sequence[str]) -> list[float]:
    if len(cells) != len(headings):
        raise InputError(f"{place}: {len(cells)} cells, expected {len(headings)} ({', '.join(map(_bare, headings))})")
    found = []
    for cell, heading in zip(cells, headings, strict=True):
        try:
            found.append(float(cell))
        except ValueError:
            raise InputError(f"{place}: column '{_bare(heading)}' has '{cell.strip()}', expected a number") from None
        if not np.isfinite(found[-1]):
            raise InputError(f"{place}: column '{_bare(heading)}' has '{cell.strip()}', expected a finite number")
    return found


def _bare(heading: str) -> str:
    match = HEADING.fullmatch(heading)
    return match["name"] if match else heading.strip()


def _wanted(actuators: Sequence[Actuator], locked: Sequence[str]) -> str:
    return ", ".join(["t [s]", *(f"{one.name} [{one.effort_unit}]" for one in actuators if one.name not in locked)])
