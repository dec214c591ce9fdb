"""Tables of text, as a value: a terminal, a notebook and a page of HTML show the same one.

A table is laid out for the width there is, and no row of short cells or numbers is ever folded.  What does not fit is
tried in this order: headings over several lines; a last column of prose wrapped at words in its place; prose on lines
of its own below its row; rows as columns; and bands one below the other, each with the first column again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from html import escape

from cutjoint.reprs import counted, listed, one_line, quoted
from cutjoint.texts import Cell, Paint, broad, cut, padded, plainly, wrapped

GAP = 3
"""Blanks between two columns."""
WIDTH = 80
INDENT = 4
"""Blanks before prose below its row."""
LEAST_PROSE = 30
"""Narrowest column that prose is wrapped in."""
A_FEW_WORDS = 24
"""Longest text that is never wrapped."""
MARKS = {"good": "✓", "half": "◐", "bad": "✗"}
"""What stands before a cell that is a verdict."""


@dataclass(frozen=True)
class TextTable:
    """Rows of text.

    Attributes:
        title: what it shows.
        columns: headings with units; all empty for a table without headings.
        rows: cells, plain text, as many a row as there are headings; one of a style is a `Cell`.
        right: headings of the columns that are flush right: numbers.
        note: what a reader must know to read it.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    right: Sequence[str] = ()
    note: str = ""

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(f"{self.title}: {len(row)} cells under {len(self.columns)} headings")

    def __repr__(self) -> str:
        headings = [one for one in self.columns if one] or [counted(len(self.columns), "column")]
        return one_line("TextTable", [quoted(self.title), counted(len(self.rows), "row"), listed(headings)])

    def __str__(self) -> str:
        return self.text()

    def text(self, width: int = WIDTH, paint: Paint = plainly) -> str:
        """The table as lines of at most `width` columns, as far as single words and cells of numbers allow; `paint`
        gives a text the look of a style."""
        shown = _shown(self)
        lines = [paint(line, "bold") for line in wrapped(shown.title, width)]
        if shown.rows:
            for number, layout in enumerate(_laid_out(shown, width)):
                lines += [*([""] if number else []), *layout.lines(paint)]
        lines += [paint(line, "dim") for line in wrapped(shown.note, width)]
        return "\n".join(lines)

    def turned(self) -> TextTable:
        """Columns as rows and rows as columns; the first column becomes the headings."""
        columns = [self.columns[0], *(row[0] for row in self.rows)]
        cells = zip(*(row[1:] for row in self.rows), strict=True)
        rows = [(name, *row) for name, row in zip(self.columns[1:], cells, strict=True)]
        return replace(self, columns=columns, rows=rows, right=columns[1:])

    def html(self) -> str:
        """The table as HTML; numbers are of class `n`, verdicts of class `verdict`, the note is a paragraph behind."""
        numbers = [column in self.right for column in self.columns]
        head = "".join(
            f'<th scope="col"{_class(number)}>{_escaped(column)}</th>'
            for column, number in zip(self.columns, numbers, strict=True)
        )
        rows = "".join(
            f"<tr>{''.join(_html_cell(cell, number) for cell, number in zip(row, numbers, strict=True))}</tr>\n"
            for row in self.rows
        )
        heads = f"<thead><tr>{head}</tr></thead>\n" if any(self.columns) else ""
        note = f'<p class="note">{_escaped(self.note)}</p>' if self.note else ""
        return f"<table><caption>{_escaped(self.title)}</caption>\n{heads}<tbody>\n{rows}</tbody></table>{note}"

    def _repr_html_(self) -> str:
        return self.html()


def _escaped(text: str) -> str:
    """A text as HTML, on one line: a page shows the end of a line as a blank anyway."""
    return escape(" ".join(text.splitlines()))


def _class(number: bool) -> str:
    return ' class="n"' if number else ""


def _html_cell(cell: str, number: bool) -> str:
    style = getattr(cell, "style", "")
    if style in MARKS:
        return f'<td><span class="verdict {style}">{_escaped(cell)}</span></td>'
    return f"<td{_class(number)}>{_escaped(cell)}</td>"


def _shown(table: TextTable) -> TextTable:
    """The table as it is printed: nothing in it moves a terminal's cursor, and verdicts have their marks."""

    def marked(cell: str) -> Cell:
        style = getattr(cell, "style", "")
        return Cell(f"{MARKS[style]} {cut(cell)}" if style in MARKS and cell else cut(cell), style)

    rows = [[marked(cell) for cell in row] for row in table.rows]
    columns, right = [cut(one) for one in table.columns], [cut(one) for one in table.right]
    return TextTable(cut(table.title), columns, rows, right, cut(table.note))


@dataclass(frozen=True)
class _Layout:
    """Some columns of a table side by side.

    Attributes:
        table: whose.
        columns: their numbers.
        widths: their widths; longer headings, and cells of the last column, are wrapped at words.
        below: columns whose cells stand on lines of their own below the row.
        width: of such lines.
    """

    table: TextTable
    columns: Sequence[int]
    widths: Sequence[int]
    below: Sequence[int]
    width: int

    def lines(self, paint: Paint) -> list[str]:
        """All lines: headings, a rule, rows."""
        table, lines = self.table, []
        if any(table.columns):
            lines += self._row([Cell(one, "") for one in table.columns], plainly)
            rules = [("-" if table.columns[i] else " ") * w for i, w in zip(self.columns, self.widths, strict=True)]
            lines.append((" " * GAP).join(rules).rstrip())
        rows = [self._row(row, paint) for row in table.rows]
        apart = any(len(row) > 2 for row in rows) and bool(self.below)
        for number, row in enumerate(rows):
            lines += [*([""] if apart and number else []), *row]
        return lines

    def _row(self, cells: Sequence[str], paint: Paint) -> list[str]:
        parts = [wrapped(cells[i], width) or [""] for i, width in zip(self.columns, self.widths, strict=True)]
        lines = []
        for number in range(max(map(len, parts))):
            line = []
            for i, width, part in zip(self.columns, self.widths, parts, strict=True):
                text = part[number] if number < len(part) else ""
                flush = padded(text, width, right=self.table.columns[i] in self.table.right)
                line.append(flush.replace(text, paint(text, getattr(cells[i], "style", "")), 1) if text else flush)
            lines.append((" " * GAP).join(line).rstrip())
        for i in self.below:
            style = getattr(cells[i], "style", "")
            lines += [" " * INDENT + paint(line, style) for line in wrapped(cells[i], self.width - INDENT)]
        return lines


def _laid_out(table: TextTable, width: int) -> list[_Layout]:
    """The layouts, one below the other, that show the whole table."""
    every = list(range(len(table.columns)))
    natural, tight = _natural(table), _tight(table)
    if _sum(natural) <= width:
        return [_Layout(table, every, natural, (), width)]
    prose = [i for i in every[1:] if _is_prose(table, i)]
    found = _beside(table, every, tight, (), width)
    if found is None and every[-1] in prose:
        least = [*tight[:-1], max(LEAST_PROSE, _word_of(table, every[-1]))]
        found = _beside(table, every, least, (), width)
    taken = sorted(prose, key=lambda i: natural[i], reverse=True)
    for count in range(1, len(taken) + 1):
        below = sorted(taken[:count])
        found = found or _beside(table, [i for i in every if i not in below], tight, below, width)
    if found is None and table.right and not prose:
        turned = table.turned()
        found = _beside(turned, list(range(len(turned.columns))), _tight(turned), (), width)
    return [found] if found else _bands(table, prose, tight, width)


def _beside(
    table: TextTable, columns: Sequence[int], least: Sequence[int], below: Sequence[int], width: int
) -> _Layout | None:
    """These columns side by side, if there is room; what is left over goes to those that would wrap most."""
    natural, widths = _natural(table), [least[i] for i in columns]
    left = width - _sum(widths)
    if left < 0:
        return None
    for _ in range(left):
        most = max(range(len(columns)), key=lambda k: natural[columns[k]] - widths[k])
        widths[most] += natural[columns[most]] > widths[most]
    return _Layout(table, columns, widths, below, width)


def _bands(table: TextTable, prose: Sequence[int], widths: Sequence[int], width: int) -> list[_Layout]:
    """Bands of columns, each with the first one again; prose, and what is broader than that leaves room for, in a last
    one: beside the first column or below it."""
    least = [min(own, width) for own in widths]
    others = [i for i in range(1, len(least)) if i in prose or _sum([least[0], least[i]]) > width]
    bands: list[list[int]] = []
    for i in [one for one in range(1, len(least)) if one not in others]:
        if not bands or _sum([least[j] for j in (*bands[-1], i)]) > width:
            bands.append([0])
        bands[-1].append(i)
    found = [layout for band in bands if (layout := _beside(table, band, least, (), width))]
    room = width - GAP - least[0]
    if len(others) == 1 and room >= max(LEAST_PROSE, _word_of(table, others[0])):
        found.append(_Layout(table, [0, *others], [least[0], min(room, _natural(table)[others[0]])], (), width))
    elif others or not found:
        found.append(_Layout(table, [0], least[:1], others, width))
    return found


def _is_prose(table: TextTable, i: int) -> bool:
    """Whether a column holds texts that may be wrapped: not numbers, nor a few words."""
    cells = [row[i] for row in table.rows]
    return table.columns[i] not in table.right and any(broad(one) > A_FEW_WORDS and " " in one for one in cells)


def _sum(widths: Sequence[int]) -> int:
    return sum(widths) + GAP * (len(widths) - 1)


def _natural(table: TextTable) -> list[int]:
    """Widths of the columns as they are."""
    return [max(map(broad, cells)) for cells in zip(table.columns, *table.rows, strict=True)]


def _tight(table: TextTable) -> list[int]:
    """Widths of the columns with headings over several lines."""
    return [max(_word(head), *map(broad, cells)) for head, *cells in zip(table.columns, *table.rows, strict=True)]


def _word(text: str) -> int:
    return max(map(broad, text.split()), default=0)


def _word_of(table: TextTable, i: int) -> int:
    """The longest word of a column."""
    return max(_word(table.columns[i]), *(_word(row[i]) for row in table.rows))
