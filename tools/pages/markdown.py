"""Markdown as a checkout shows it, to Markdown as MkDocs takes it: fences, links out of docs/, formulas."""

from __future__ import annotations

import html
import posixpath
import re

from latex2mathml.converter import convert

FENCE = re.compile(r"^(?P<fence>```+)(?P<language>\w+)[ \t]+(?P<info>[\w=./ -]+?)[ \t]*$", re.MULTILINE)
LINK = re.compile(
    r"^(?P<code>```+).*?^(?P=code)[ \t]*$|`[^`\n]+`"  # what stands in code is no link
    r"|(?P<open>!?)\[(?P<text>[^\]]*)\]\((?P<target>[^)\s#]+)(?P<anchor>#[^)\s]*)?\)",
    re.MULTILINE | re.DOTALL,
)
FORMULA = re.compile(r'<(?P<tag>span|div) class="arithmatex">\\[(\[](?P<tex>.*?)\\[)\]]</(?P=tag)>', re.DOTALL)
MATRIX = re.compile(r"<mo>&#x0005B;</mo>(<mtable>.*?</mtable>)<mo>&#x0005D;</mo>")
"""Brackets grow with what they hold only in a font for formulas, which not every machine has: docs/assets/site.css."""

ROOT_PAGES = {"README.md": "overview.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
"""Documents of the top folder -> the pages that they become."""


def titled_fences(text: str) -> str:
    """Fences whose info string says where the block goes (tests/kit/exercise.py), with a title that tells it."""

    def titled(match: re.Match[str]) -> str:
        said = dict((*word.split("=", 1), "")[:2] for word in match["info"].split())
        title = _title(said)
        return f"{match['fence']}{match['language']}" + (f' title="{title}"' if title else "")

    return FENCE.sub(titled, text)


def _title(said: dict[str, str]) -> str:
    if "new" in said:
        return f"src/cutjoint/{said['new']} (new)"
    if "row" in said:
        return f"src/cutjoint/{said['row']}, in {said['table']}"
    if "import" in said:
        return f"src/cutjoint/{said['import']}, imports"
    return said.get("file", "")


def links_within(text: str, source: str, api: set[str]) -> str:
    """The links of a document at `source` (from the top folder, with slashes), made to lead from page to page.

    A link to a document of the top folder leads to the page it becomes, one into docs/ is counted from there, and one
    to a module to the page of its room in `api`.  Other files have no page: of links to them the text stays.
    """
    folder = posixpath.dirname(source)
    page = ROOT_PAGES.get(source, source.removeprefix("docs/"))

    def within(match: re.Match[str]) -> str:
        target = match["target"]
        if target is None or re.match(r"[a-z]+:", target):
            return match[0]
        there = posixpath.normpath(posixpath.join(folder, target))
        if there == "docs":
            there = "docs/README.md"
        found = ROOT_PAGES.get(there)
        if there.startswith("docs/"):
            found = there.removeprefix("docs/")
        elif there.startswith("src/cutjoint/"):
            room = there.removeprefix("src/cutjoint/").split("/")[0].removesuffix(".py")
            found = f"api/{room}.md" if room in api else None
        if found is None:
            return match["text"]
        back = posixpath.relpath(found, posixpath.dirname(page) or ".")
        return f"{match['open']}[{match['text']}]({back}{match['anchor'] or ''})"

    return LINK.sub(within, text)


def formulas(page: str) -> str:
    """A page of HTML with its formulas as MathML, which browsers show by themselves."""

    def drawn(match: re.Match[str]) -> str:
        display = "block" if match["tag"] == "div" else "inline"
        made = convert(html.unescape(match["tex"]), display=display)
        return MATRIX.sub(r'<mrow class="matrix">\1</mrow>', made)

    return FORMULA.sub(drawn, page)
