"""A table that a page and a terminal both show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

GOOD = ("holds", "yes")
HALF = ("holds with the inferred code only", "holds with equation (39) only")
BAD = ("does not hold", "no")

GAP = 3
"""Columns between two columns of a table on a terminal."""


@dataclass(frozen=True)
class ReportTable:
    """Rows of text.

    Attributes:
        title: what it shows.
        columns: headings; those in `right` are flush right.
        rows: cells.
        right: headings of numbers.
        note: what a reader must know to read it.
        wide: for the page only; a terminal has no room for it.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    right: Sequence[str] = ()
    note: str = ""
    wide: bool = False

    def __post_init__(self) -> None:
        for row in self.rows:
            assert len(row) == len(self.columns), f"{self.title}: {len(row)} cells under {len(self.columns)} headings"

    @property
    def is_text(self) -> bool:
        """Whether no column holds numbers: such rows read better as paragraphs where a line is short."""
        return not self.right

    @property
    def least_width(self) -> int:
        """Columns of a terminal that it needs if no word is broken."""
        columns = zip(self.columns, *self.rows, strict=True)
        words = [max((len(word) for cell in column for word in cell.split()), default=0) for column in columns]
        return 2 + sum(words) + GAP * (len(words) - 1)

    def turned(self) -> ReportTable:
        """Columns as rows and rows as columns; the first column becomes the headings."""
        columns = [self.columns[0], *(row[0] for row in self.rows)]
        cells = zip(*(row[1:] for row in self.rows), strict=True)
        rows = [(name, *row) for name, row in zip(self.columns[1:], cells, strict=True)]
        return ReportTable(self.title, columns, rows, columns[1:], self.note, self.wide)

    def fitting(self, width: int) -> ReportTable:
        """The table as it is where `width` columns of a terminal hold it with no word broken, else the narrower way."""
        if self.least_width <= width or not self.rows:
            return self
        return min(self, self.turned(), key=lambda table: table.least_width)


def verdict_style(text: str) -> str | None:
    """`good`, `half` or `bad` for a cell that is a verdict, else None."""
    styles = {"good": GOOD, "half": HALF, "bad": BAD}
    return next((style for style, texts in styles.items() if text in texts), None)


MARKS = {"good": "✓", "half": "◐", "bad": "✗"}
"""What stands beside a verdict."""
