"""Curves that can be read off and enlarged, as one self-contained page of HTML: nothing is fetched, and no other script
runs than those whose hashes the page's policy names."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Sequence
from importlib import resources

from cutjoint.simulation.charts import POINTS, Chart, charts_json

SAMPLES, FEWEST = 200_000, 200
"""Samples of all curves of a page together, so that it stays small, and of one curve at least."""

START = """"use strict";
for (const element of document.querySelectorAll("[data-curves]")) {
  const panels = JSON.parse(document.getElementById(element.dataset.curves).textContent);
  element.drawn = drawCurves(element, panels);
}
document.documentElement.dataset.ready = "yes";
"""


def curves(charts: Sequence[Chart], key: str) -> str:
    """A part of a page that shows charts; `key` is told apart from those of other parts."""
    points = min(max(SAMPLES // max(sum(len(chart.curves) for chart in charts), 1), FEWEST), POINTS)
    data = json.dumps(charts_json(charts, points), allow_nan=False, separators=(",", ":"))
    data = data.replace("<", "\\u003c")
    return (
        f'<div class="charts" data-curves="{key}"></div>\n'
        f'<script id="{key}" type="application/json">{data}</script>\n'
        "<noscript><p>The curves need JavaScript, which is switched off.</p></noscript>"
    )


def page_of(title: str, body: str, mark: str, frames: Sequence[str] = ()) -> str:
    """A whole page around `body`, HTML that may hold `curves`, and pages in frames, which `frames` are; `mark` says
    what made it."""
    scripts = [_file("viewer/page/curves.js"), START]
    hashes = [f"'sha256-{base64.b64encode(hashlib.sha256(one.encode()).digest()).decode()}'" for one in scripts]
    # a page in a frame is under the policy of the one around it too
    hashes += [one for frame in frames for one in re.findall(r"'sha256-[^']+'", html.unescape(frame[:8000]))]
    policy = (
        f"default-src 'none'; script-src {' '.join(hashes)}; style-src 'unsafe-inline'; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'"
    )
    text = (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<meta name="generator" content="{mark}">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{html.escape(policy)}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(title)}</title>\n<style>{_file('report/run_page.css')}</style>\n</head>\n"
        f"<body>\n<main>\n{body}\n</main>\n"
        + "\n".join(f"<script>{one}</script>" for one in scripts)
        + "\n</body>\n</html>\n"
    )
    return text.encode("utf-8", "backslashreplace").decode()  # a file's name may have bytes that are no character


def _file(name: str) -> str:
    return (resources.files("cutjoint") / name).read_text(encoding="utf-8")
