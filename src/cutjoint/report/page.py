"""One HTML page that needs nothing else: no network, no script, pictures inside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from cutjoint.report.figures import Drawing, dark_variables
from cutjoint.reprs import line
from cutjoint.tables import TextTable

STYLE = """
:root { color-scheme: light; --ink: #222; --soft: #5a5a5a; --line: #dcdcdc; --link: #0b5a8a; --back: #fff;
  --good: #00694c; --half: #8a5a00; --bad: #a33f00; }
@media screen and (prefers-color-scheme: dark) {
  :root { color-scheme: dark; --ink: #e8eaed; --soft: #a5adb8; --line: #363c45; --link: #7cc4f0; --back: #16191d;
    --good: #4fd3a5; --half: #f0c060; --bad: #ff9a6b; FIGURES }
}
* { box-sizing: border-box; }
body { margin: 0; color: var(--ink); background: var(--back); }
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
.note { color: var(--soft); font-size: .88rem; margin: .4rem 0 0; }
.verdict { font-weight: 600; }
@media (min-width: 700px) { .verdict { white-space: nowrap; } }
.verdict::before { display: inline-block; width: 1.2em; }
.good { color: var(--good); } .good::before { content: "✓"; }
.half { color: var(--half); } .half::before { content: "◐"; }
.bad { color: var(--bad); } .bad::before { content: "✗"; }
figure { margin: 1.4rem 0; overflow-x: auto; }
figure svg { display: block; max-width: 100%; height: auto; }
figcaption { color: var(--soft); font-size: .9rem; max-width: 60rem; margin-top: .3rem; }
@media print { nav { display: none; } h2 { break-before: page; } figure, table { break-inside: avoid; } }
""".replace("FIGURES", dark_variables())


@dataclass(frozen=True)
class Picture:
    """A drawing with its caption."""

    drawing: Drawing
    caption: str


@dataclass(frozen=True)
class Section:
    """A heading of level 2 or 3 with paragraphs (plain text), tables and pictures, in this order as given.

    Attributes:
        printed: whether its tables are for a terminal too, which has no room for very long texts.
    """

    title: str
    parts: Sequence[str | TextTable | Picture] = ()
    level: int = 3
    printed: bool = True

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
            elif isinstance(part, TextTable):
                body.append(f'<div class="scroll">{part.html()}</div>')
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
