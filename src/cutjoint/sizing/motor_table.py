"""Motors from a table: a CSV file whose headings tell quantity and unit, such as `rated_torque [N m]`.

Separators are commas, semicolons or tabs, whichever the headings have.  Blank lines and lines that start with # are
passed over.  A table is of motors that turn (torques, inertias) or of motors that slide (forces, masses).  All that is
wrong is told with file, line and column.
"""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple, NoReturn, cast

from cutjoint.doors import door
from cutjoint.errors import FileError, InputError, nearest, shown
from cutjoint.files import read_file
from cutjoint.sizing.motor import ServoMotor
from cutjoint.units import UNITS, Kind, factor, kinds_of

LARGEST = 10_000_000
"""Bytes."""
MOST_MOTORS = 2000
"""More take minutes to compare."""
DECIMAL_COMMA = re.compile(r"\d+,\d+")
HEADING = re.compile(r"(?P<name>[^\[\]]+?)\s*(?:\[(?P<unit>[^\[\]]*)\])?\s*")


class ColumnMeaning(NamedTuple):
    """What a column tells: a field of `ServoMotor`, its quantity in a table of motors that turn, and that slide; None
    where such a table does not have it."""

    field: str
    turning: Kind | None
    sliding: Kind | None


COLUMNS: Mapping[str, ColumnMeaning] = {
    "rated_torque": ColumnMeaning("rated", "torque", None),
    "rated_force": ColumnMeaning("rated", None, "force"),
    "peak_torque": ColumnMeaning("peak", "torque", None),
    "peak_force": ColumnMeaning("peak", None, "force"),
    "max_speed": ColumnMeaning("max_speed", "speed of rotation", "speed"),
    "rotor_inertia": ColumnMeaning("rotor", "inertia", None),
    "mover_mass": ColumnMeaning("rotor", None, "mass"),
    "rated_speed": ColumnMeaning("rated_speed", "speed of rotation", "speed"),
    "knee_speed": ColumnMeaning("knee_speed", "speed of rotation", "speed"),
    "brake_torque": ColumnMeaning("brake", "torque", None),
    "brake_force": ColumnMeaning("brake", None, "force"),
    "resistance": ColumnMeaning("resistance", "resistance", "resistance"),
    "torque_constant": ColumnMeaning("constant", "torque constant", None),
    "force_constant": ColumnMeaning("constant", None, "force constant"),
    "thermal_resistance": ColumnMeaning("thermal_resistance", "thermal resistance", "thermal resistance"),
    "max_temperature": ColumnMeaning("max_temperature", "temperature", "temperature"),
}
"""Heading without its unit -> what it means; a column `name` stands beside."""
NEEDED = {
    "rotation": ("rated_torque", "peak_torque", "max_speed", "rotor_inertia"),
    "translation": ("rated_force", "peak_force", "max_speed", "mover_mass"),
}


class Column(NamedTuple):
    """A column of a table: where it stands, its heading, and how many SI units its unit is."""

    number: int
    heading: str
    field: str
    factor: float


@door
def motors_from_file(path: str | os.PathLike[str]) -> tuple[ServoMotor, ...]:
    """The motors of a table.

    Raises:
        InputError: no such file, a heading that is not known, twice there or missing, a unit that does not fit its
            quantity, a name that is there twice, or a cell that is no number > 0; with file, line and column.
    """
    name = os.fspath(path)
    rows = _rows(name)
    line, headings = rows[0]
    kind, columns = _columns(name, line, headings)
    at_name = [one.strip().casefold() for one in headings].index("name")
    motors: list[ServoMotor] = []
    lines: dict[str, int] = {}
    for line, cells in rows[1:]:
        if len(cells) != len(headings):
            _refuse(name, line, f"found {len(cells)} cells; expected {len(headings)}, one a heading")
        called = cells[at_name].strip()
        if not called:
            _refuse(name, line, "found no name; expected the motor's name", at_name, headings)
        if called in lines:
            told = f"motor '{shown(called)}' is there twice, first on line {lines[called]}; expected every name once"
            _refuse(name, line, told, at_name, headings)
        lines[called] = line
        numbers = {one.field: _number(name, line, one, cells[one.number], headings, kind) for one in columns}
        try:
            motors.append(ServoMotor(called, kind, **numbers))  # type: ignore[arg-type]
        except InputError as error:
            _refuse(name, line, str(error))
        if len(motors) > MOST_MOTORS:
            _refuse(name, line, f"found more than {MOST_MOTORS} motors; choose some before")
    if not motors:
        _refuse(name, rows[0][0], "found headings and no motor; expected a row a motor")
    return tuple(motors)


def _rows(path: str) -> list[tuple[int, list[str]]]:
    """The rows with their line numbers, the headings first."""
    try:
        text = read_file(path, LARGEST).decode("utf-8-sig")
    except FileError as error:
        raise InputError(f"table of motors {error}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{shown(path)}: this is no text in UTF-8; expected comma-separated values") from error
    if "\0" in text:
        _refuse(path, text.count("\n", 0, text.index("\0")) + 1, "found a zero byte, so it is no text")
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise InputError(
            f"{shown(path)}: found no line but blank ones and comments; expected headings, such as {_example()}"
        )
    separator = next((one for one in ";\t" if one in lines[0][1]), ",")
    try:
        return [(number, next(csv.reader([line], delimiter=separator))) for number, line in lines]
    except csv.Error as error:
        raise InputError(f"{shown(path)}: this is no table of comma-separated values: {error}") from error


def _columns(
    path: str, line: int, headings: Sequence[str]
) -> tuple[Literal["rotation", "translation"], list[Column]]:  # fmt: skip
    """Whether the motors turn, and what the columns tell."""
    parts = [HEADING.fullmatch(one.strip()) for one in headings]
    names = []
    for number, (part, heading) in enumerate(zip(parts, headings, strict=True)):
        called = part["name"].strip().casefold() if part else ""
        if called != "name" and called not in COLUMNS:
            near = nearest(called, ["name", *COLUMNS])
            hint = f"; did you mean '{near[0]}'?" if near else f". Known: name, {', '.join(COLUMNS)}"
            _refuse(path, line, f"unknown column '{shown(heading.strip(), 60)}'{hint}", number)
        if called in names:
            _refuse(path, line, f"column '{called}' is there twice", number, headings)
        names.append(called)
    turning = [one for one in names if one in COLUMNS and COLUMNS[one].sliding is None]
    sliding = [one for one in names if one in COLUMNS and COLUMNS[one].turning is None]
    if turning and sliding:
        told = f"found {turning[0]}, of a motor that turns, and {sliding[0]}, of one that slides; expected one kind"
        _refuse(path, line, told)
    kind = "translation" if sliding else "rotation"
    missing = [one for one in ("name", *NEEDED[kind]) if one not in names]
    if missing:
        _refuse(path, line, f"column {', '.join(missing)} is missing; expected such as {_example(kind)}")
    columns = []
    for number, (part, called) in enumerate(zip(parts, names, strict=True)):
        if called == "name":
            continue
        meaning = COLUMNS[called]
        quantity = meaning.sliding if kind == "translation" else meaning.turning
        assert part is not None
        assert quantity is not None
        scale = _factor(path, line, headings, number, part["unit"], quantity)
        columns.append(Column(number, called, meaning.field, scale))
    return cast("Literal['rotation', 'translation']", kind), columns


def _factor(
    path: str, line: int, headings: Sequence[str], number: int, unit: str | None, quantity: Kind
) -> float:  # fmt: skip
    """How many SI units the unit of a column is."""
    known = ", ".join(UNITS[quantity])
    if unit is None or not unit.strip():
        _refuse(path, line, f"the heading tells no unit; expected one of {known}, in [ ]", number, headings)
    scale = factor(unit, quantity)
    if scale is None:
        measures = kinds_of(unit)
        found = f"which is a unit of {' and '.join(measures)}" if measures else "which is not known"
        told = f"found the unit '{shown(unit.strip(), 30)}', {found}; expected a unit of {quantity}: {known}"
        _refuse(path, line, told, number, headings)
    return scale


def _number(
    path: str, line: int, column: Column, cell: str, headings: Sequence[str], kind: str
) -> float | None:  # fmt: skip
    """A cell in SI units; None where it is empty and may be."""
    text = cell.strip()
    if not text:
        if column.heading in NEEDED[kind]:
            _refuse(path, line, "found an empty cell; expected a number for every motor", column.number, headings)
        return None
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    allowed = value > 0.0 or (column.field == "rotor" and value == 0.0)
    if "_" in text or not (allowed and value < float("inf")):
        mend = f", with a point: {text.replace(',', '.')}" if DECIMAL_COMMA.fullmatch(text) else ""
        _refuse(path, line, f"found '{shown(text, 40)}'; expected a number > 0{mend}", column.number, headings)
    return value * column.factor


def _example(kind: str = "rotation") -> str:
    return {
        "rotation": "name,rated_torque [N m],peak_torque [N m],max_speed [rpm],rotor_inertia [kg cm2]",
        "translation": "name,rated_force [N],peak_force [N],max_speed [m/s],mover_mass [kg]",
    }[kind]


def _refuse(
    path: str, line: int, found: str, column: int | None = None, headings: Sequence[str] | None = None
) -> NoReturn:  # fmt: skip
    """Raises InputError with file, line and column."""
    where = f"{shown(path)}:{line}"
    if column is not None:
        where += f", column {column + 1}"
        if headings is not None:
            where += f" '{shown(headings[column].strip(), 40)}'"
    raise InputError(f"{where}: {found}")
