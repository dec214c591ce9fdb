"""A table of numbers in a text file: comma-separated values with a line of headings (RFC 4180), read whole and checked.

Separators are commas, semicolons or tabs, whichever the headings have.  Blank lines and lines that start with # are
passed over.  Whatever is wrong is told with file, line and column.
"""

from __future__ import annotations

import os
from array import array
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.errors import FileError, MotionFileError
from cutjoint.files import read_file

LARGEST = 200_000_000
"""Bytes; a file that is larger is refused before it is read."""
MOST = 1e100
"""A number beyond that is a slip of the pen."""


@dataclass(frozen=True, eq=False)
class NumberTable(Frozen):
    """Named columns of finite numbers.

    Attributes:
        path: the file.
        headings: as they are written, without spaces and quotes around them.
        values: shape (rows, columns).
        lines: number of the line of every row, from 1, as floats; and of the headings, before them.
    """

    path: str
    headings: tuple[str, ...]
    values: Array
    lines: Array

    def fault(self, found: str, row: int | None = None, column: int | None = None) -> MotionFileError:
        """The error that tells what was found in a row, or in the headings (-1), and in a column."""
        line = None if row is None else int(self.lines[row + 1])
        return _fault(self.path, found, line, None if column is None else _called(self.headings[column], column))


def read_table(path: str | os.PathLike[str]) -> NumberTable:
    """The table in a file.

    Raises:
        MotionFileError: no such file, too large, no text, no headings or rows, or a cell that is no finite number.
    """
    name = os.fspath(path)
    lines = enumerate(_text(name).split("\n"), start=1)
    filled = ((number, line) for number, line in lines if line and not line.isspace() and line.lstrip()[0] != "#")
    number, line = next(filled, (0, ""))
    if not number:
        raise _fault(name, "found no line but blank ones and comments; expected headings, such as t,x,y,z, and rows")
    separator = next((one for one in ";\t" if one in line), ",")
    headings = tuple(one.strip().strip('"').strip() for one in line.split(separator))
    _check_headings(name, number, headings)
    values, numbers = array("d"), array("d", [number])
    for number, line in filled:
        cells = line.split(separator)
        try:
            row = [*map(float, cells)]
        except ValueError:
            row = []
        # The quick way is for what is right; what is not, or may not be, is looked at cell by cell.
        if len(row) != len(headings) or "_" in line:
            row = _numbers(name, number, headings, cells)
        values.extend(row)
        numbers.append(number)
    if len(numbers) < 3:
        found = "no row" if len(numbers) == 1 else "one row"
        raise _fault(name, f"found {found} of numbers; expected two or more", number)
    table = NumberTable(name, headings, np.reshape(values, (-1, len(headings))), np.array(numbers))
    wrong = np.argwhere(~(np.abs(table.values) <= MOST))
    if len(wrong):
        row_number, column = map(int, wrong[0])
        found = f"found {table.values[row_number, column]:g}; expected a finite number, of at most {MOST:g}"
        raise table.fault(found, row_number, column)
    return table


def _text(path: str) -> str:
    """The text of a file, with \\n as ends of lines."""
    try:
        content = read_file(path, LARGEST)
    except FileError as error:
        raise _fault(path, f"{error.why}{error.mend and f' ({error.mend})'}") from error
    if b"\0" in content:
        line = content.count(b"\n", 0, content.index(b"\0")) + 1
        raise _fault(path, "found a zero byte, so it is no text in UTF-8; expected comma-separated values", line)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise _fault(
            path, f"found the byte 0x{content[error.start]:02x}, which is no UTF-8; save it so", line
        ) from error
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


def _check_headings(path: str, line: int, headings: tuple[str, ...]) -> None:
    if all(_is_number(one) for one in headings):
        raise _fault(
            path,
            f"found numbers, {_short(', '.join(headings))}; expected headings first, such as t,x,y,z (a line that "
            "starts with # is a comment: numpy.savetxt writes headings with comments='')",
            line,
        )
    if len(headings) == 1:
        raise _fault(
            path, f"found one heading, '{_short(headings[0])}'; expected several with commas, ; or tabs between", line
        )
    if "" in headings:
        raise _fault(path, f"column {headings.index('') + 1} of {len(headings)} has no heading", line)


def _numbers(path: str, line: int, headings: tuple[str, ...], cells: list[str]) -> list[float]:
    """The numbers of a row that is not as a rule: quoted ones are taken, anything else is refused."""
    if len(cells) != len(headings):
        hint = " (a decimal comma is none: write 0.5)" if len(cells) > len(headings) else ""
        raise _fault(path, f"found {len(cells)} cells; expected {len(headings)}, one a heading{hint}", line)
    row = []
    for column, cell in enumerate(cells):
        word, called = cell.strip().strip('"').strip(), _called(headings[column], column)
        if not word:
            raise _fault(
                path, "found an empty cell; expected a number in every row (leave the whole row out)", line, called
            )
        if not _is_number(word):
            raise _fault(path, f"found '{_short(word)}'; expected a number", line, called)
        row.append(float(word))
    return row


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return "_" not in word


def _short(text: str) -> str:
    return text if len(text) <= 60 else text[:57] + "..."


def _called(heading: str, column: int) -> str:
    return f"{column + 1} '{_short(heading)}'"


def _fault(path: str, found: str, line: int | None = None, column: str | None = None) -> MotionFileError:
    where = f"{path}:{line}" if line else path
    if column is not None:
        where += f", column {column}"
    return MotionFileError(f"{where}: {found}", path=path, line=line, column=column)
