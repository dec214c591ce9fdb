"""The page of the gallery, from what tools/gallery.py made."""

from __future__ import annotations

import html
import json
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[2] / "out" / "gallery"
LIST = FOLDER / "gallery.json"
HEAD = """\
---
hide: [toc]
---

# Gallery

The robots that come with cutjoint, and mechanisms of every template of `cutjoint new`. A picture opens the motion as
a page of its own: one file, to be turned, played and sent to others.

"""


def page() -> str:
    """The page, as Markdown; before there is a gallery, how to make it."""
    if not LIST.is_file():
        return f"{HEAD}These pages were made without it: `make gallery docs` makes it, and then the pages with it.\n"
    cards = "\n".join(_card(**robot) for robot in json.loads(LIST.read_text(encoding="utf-8")))
    return f'{HEAD}<div class="gallery">\n{cards}\n</div>\n'


def _card(name: str, mobility: str, line: str, page: str, picture: str) -> str:
    shown = f'<img src="gallery/{picture}" alt="{html.escape(name)}" loading="lazy">' if picture else ""
    return (
        f'<figure><a href="gallery/{page}">{shown}</a>'
        f'<figcaption><a href="gallery/{page}"><b>{html.escape(name)}</b></a>, {html.escape(mobility)}<br>'
        f"<code>{html.escape(line)}</code></figcaption></figure>"
    )


def files() -> list[Path]:
    """Pictures and pages of the gallery."""
    return sorted([*FOLDER.glob("*.png"), *FOLDER.glob("*.html")])
