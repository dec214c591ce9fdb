"""A sheet: the drawing of one engineering answer in the look of all, with letters that can be read on a slide.

Maps are drawn in `viridis` and `cividis`, which everybody can read and which survive in grey; what is not reached is
left white.  Every axis names its quantity and unit.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from cutjoint.errors import InputError, shown
from cutjoint.extras import needed
from cutjoint.files import check_place, write_whole
from cutjoint.report.figures import SETTINGS, Drawing, plotting

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SLIDE = {"font.size": 12, "axes.titlesize": 12.5, "legend.fontsize": 11, "lines.linewidth": 2.0}
SUFFIXES = (".png", ".svg")
DPI = 150
LETTER = 0.135
"""Breadth of a letter of a title [inch], as a rule."""


def sheet(draw: Callable[[Figure], None], title: str, size: tuple[float, float] = (11.0, 6.2)) -> Drawing:
    """A drawing that `draw` fills; `size` is its breadth and height in inches.

    Raises:
        MissingPackageError: matplotlib is not installed.
    """
    mpl = plotting()
    from matplotlib.figure import Figure

    with mpl.rc_context(SETTINGS | SLIDE):
        drawn = Figure(figsize=size, layout="constrained")
        drawn.suptitle(shown(title, int(size[0] / LETTER)), x=0.01, ha="left", fontweight="bold")
        draw(drawn)
        drawn.draw_without_rendering()
        drawn.set_layout_engine("none")
        return Drawing(drawn)


def check_picture(path: Path) -> None:
    """Look at the place of a picture before the work begins.

    Raises:
        InputError: the suffix is no format of a picture, or nothing can be written there.
        MissingPackageError: matplotlib is not installed.
    """
    needed("matplotlib", "a picture")
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"'{path}': pictures are written as {' or '.join(SUFFIXES)}, found '{path.suffix}'")
    check_place(path)


def write_sheet(drawing: Drawing, path: str | os.PathLike[str]) -> Path:
    """Write a drawing; the suffix picks the format: .png or .svg.

    Raises:
        InputError: as of `check_picture`.
    """
    path = Path(path)
    check_picture(path)
    if path.suffix.lower() == ".svg":
        return write_whole(path, drawing.svg_file().encode())
    return write_whole(path, drawing.png(DPI))
