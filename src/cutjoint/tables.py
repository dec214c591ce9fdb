"""Tables of text, as a value: a terminal, a notebook and a page of HTML show the same one.

A table is laid out for the width there is and never folded: where its columns do not fit, they are split into bands
one below the other, each with the first column again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

GAP = 3
"""Blanks between two columns."""
WIDTH = 80


@dataclass(frozen=True)
class TextTable:
    """Rows of text.

    Attributes:
        title: what it shows.
        columns: headings with units; all empty for a table without headings.
        rows: cells, plain text, as many a row as there are headings.
        right: headings of the columns that are flush right: numbers.
        note: what a reader must know to read it.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    right: Sequence[str] = ()
    note: str = ""

    def __str__(self) -> str:
        return self.text()

    def text(self, width: int = WIDTH) -> str:
        """The table as lines of at most `width` columns, as far as single cells allow."""
        return "\n".join([self.title, *(line for band in self._bands(width) for line in self._lines(band)), self.note])

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{escape(one)}</th>" for one in self.columns)
        rows = "".join("<tr>" + "".join(f"<td>{escape(one)}</td>" for one in row) + "</tr>" for row in self.rows)
        return f"<table><caption>{escape(self.title)}</caption><tr>{head}</tr>{rows}</table>"

    def _widths(self) -> list[int]:
        return [max(map(len, cells), default=0) for cells in zip(self.columns, *self.rows, strict=True)]

    def _bands(self, width: int) -> list[list[int]]:
        """Columns of each band, by number."""
        widths, bands = self._widths(), [[0]]
        for i, own in list(enumerate(widths))[1:]:
            if len(bands[-1]) > 1 and sum(widths[j] + GAP for j in bands[-1]) + own > width:
                bands.append([0])
            bands[-1].append(i)
        return bands

    def _lines(self, band: Sequence[int]) -> list[str]:
        widths = self._widths()
        lines = []
        for row in (self.columns, *self.rows) if any(self.columns) else self.rows:
            cells = [
                row[i].rjust(widths[i]) if self.columns[i] in self.right else row[i].ljust(widths[i]) for i in band
            ]
            lines.append((" " * GAP).join(cells).rstrip())
        return lines
