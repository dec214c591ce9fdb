"""Whether a page is laid out well: nothing off screen, nothing over text, all within reach, all to be read.

    assert_laid_out(tab.page)

holds a page to it at four sizes, light and dark.  What is looked at is the page as it stands: boxes, computed styles.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

SIZES = ((1280, 800), (1920, 1080), (390, 844), (844, 390))
THEMES = ("light", "dark")
CONTRAST = 4.5
TOUCH = 40
"""Least height of what is touched on a phone, in CSS pixels."""

FAULTS = (Path(__file__).parent / "looks.js").read_text(encoding="utf-8")
SETTLED = """
() => new Promise((done) => {
  let frames = 4;
  const next = () => (frames-- ? requestAnimationFrame(next) : done());
  next();
})
"""
"""Some frames later: sizes are observed, labels are placed."""


def faults_of(page: Any, sizes: Sequence[tuple[int, int]] = SIZES, themes: Sequence[str] = THEMES) -> list[str]:
    """What is wrong with a page as it stands, each with size and theme; the page is left at the last of them."""
    found = []
    for width, height in sizes:
        page.set_viewport_size({"width": width, "height": height})
        for theme in themes:
            page.emulate_media(color_scheme=theme)
            page.evaluate(SETTLED)
            faults = page.evaluate(FAULTS, [CONTRAST, TOUCH])
            found += [f"{width}x{height} {theme}: {fault}" for fault in dict.fromkeys(faults)]
    return found


def assert_laid_out(page: Any, sizes: Sequence[tuple[int, int]] = SIZES, themes: Sequence[str] = THEMES) -> None:
    """That nothing is wrong with a page of playwright, as it stands, at these sizes (width, height) and themes."""
    found = faults_of(page, sizes, themes)
    assert not found, "\n".join([f"{len(found)} faults", *found[:40]])
