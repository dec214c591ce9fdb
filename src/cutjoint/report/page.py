"""One HTML page that needs nothing else: no network, no script, pictures inside.  A terminal shows its tables too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from cutjoint.report.figures import Drawing
from cutjoint.reprs import line

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


STYLE = """
:root { color-scheme: light; --ink: #222; --soft: #5a5a5a; --line: #dcdcdc; --link: #0b5a8a; }
* { box-sizing: border-box; }
body { margin: 0; color: var(--ink); background: #fff; }
body { font: 16px/1.5 system-ui, "Segoe UI", Helvetica, Arial, sans-serif; }
main { max-width: 1120px; margin: 0 auto; padding: 28px 20px 80px; }
h1 { font-size: 1.75rem; line-height: 1.2; margin: 0 0 .4rem; }
h2 { font-size: 1.35rem; margin: 3rem 0 .6rem; padding-top: .8rem; border-top: 2px solid var(--ink); }
h3 { font-size: 1.05rem; margin: 2rem 0 .5rem; }
p, li { max-width: 46rem; }
.lead { color: var(--soft); margin-top: 0; }
a { color: var(--link); }
nav ul { list-style: none; padding: 0; margin: 1rem 0 0; columns: 18rem 2; }
nav li { break-inside: avoid; padding: .1rem 0; }
nav li.sub { padding-left: 1.1rem; font-size: .92rem; }
.scroll { overflow-x: auto; margin: .6rem 0 1.2rem; }
table { border-collapse: collapse; font-size: .9rem; line-height: 1.35; }
caption { text-align: left; font-weight: 600; padding: 0 0 .35rem; }
th, td { padding: .32rem .8rem .32rem 0; text-align: left; vertical-align: top; border-bottom: 1px solid var(--line); }
th { border-bottom: 1.5px solid var(--ink); font-weight: 600; vertical-align: bottom; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
td.n { white-space: nowrap; }
.note { color: var(--soft); font-size: .88rem; margin: -.8rem 0 1.4rem; }
.verdict { font-weight: 600; }
@media (min-width: 700px) { .verdict { white-space: nowrap; } }
.verdict::before { display: inline-block; width: 1.2em; }
.good { color: #00694c; } .good::before { content: "✓"; }
.half { color: #8a5a00; } .half::before { content: "◐"; }
.bad { color: #a33f00; } .bad::before { content: "✗"; }
figure { margin: 1.4rem 0; overflow-x: auto; }
figure svg { display: block; max-width: 100%; height: auto; }
figcaption { color: var(--soft); font-size: .9rem; max-width: 60rem; margin-top: .3rem; }
@media print { nav { display: none; } h2 { break-before: page; } figure, table { break-inside: avoid; } }
"""


@dataclass(frozen=True)
class Picture:
    """A drawing with its caption."""

    drawing: Drawing
    caption: str


@dataclass(frozen=True)
class Section:
    """A heading of level 2 or 3 with paragraphs (plain text), tables and pictures, in this order as given."""

    title: str
    parts: Sequence[str | ReportTable | Picture] = ()
    level: int = 3

    __repr__ = line("title", "parts")


def page(title: str, lead: str, sections: Sequence[Section]) -> str:
    """The whole page as HTML."""
    body, links = [], []
    pictures = 0
    for number, section in enumerate(sections):
        anchor = f"s{number}"
        kind = ' class="sub"' if section.level > 2 else ""
        links.append(f'<li{kind}><a href="#{anchor}">{escape(section.title)}</a></li>')
        body.append(f'<h{section.level} id="{anchor}">{escape(section.title)}</h{section.level}>')
        for part in section.parts:
            if isinstance(part, str):
                body.append(f"<p>{escape(part)}</p>")
            elif isinstance(part, ReportTable):
                body.append(_table(part))
            else:
                pictures += 1
                svg = part.drawing.svg(f"f{pictures}").replace(
                    '<svg role="img"', f'<svg role="img" aria-label="{escape(part.caption)}"', 1
                )
                body.append(f"<figure>{svg}<figcaption>{escape(part.caption)}</figcaption></figure>")
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n"
        f'<h1>{escape(title)}</h1>\n<p class="lead">{escape(lead)}</p>\n'
        f'<nav aria-label="Contents"><ul>{"".join(links)}</ul></nav>\n'
        + "\n".join(body)
        + "\n</main>\n</body>\n</html>\n"
    )


def _table(table: ReportTable) -> str:
    numbers = [column in table.right for column in table.columns]
    head = "".join(
        f'<th scope="col"{_class(number)}>{escape(column)}</th>'
        for column, number in zip(table.columns, numbers, strict=True)
    )
    rows = "".join(
        f"<tr>{''.join(_cell(cell, number) for cell, number in zip(row, numbers, strict=True))}</tr>\n"
        for row in table.rows
    )
    note = f'<p class="note">{escape(table.note)}</p>' if table.note else ""
    return (
        f'<div class="scroll"><table><caption>{escape(table.title)}</caption>\n<thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{rows}</tbody></table></div>{note}"
    )


def _class(number: bool) -> str:
    return ' class="n"' if number else ""


def _cell(text: str, number: bool) -> str:
    style = verdict_style(text)
    if style is not None:
        return f'<td><span class="verdict {style}">{escape(text)}</span></td>'
    return f"<td{_class(number)}>{escape(text)}</td>"
