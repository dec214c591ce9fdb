"""The picture of a certified box: its sub-boxes in the colour of their margin, what is not proven, the counter-example.

A box over three axes or more is cut by planes through its middle, or through the counter-example, two axes each.
"""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.arrays import Array
from cutjoint.doors import door
from cutjoint.report.answers.sheet import sheet
from cutjoint.report.figures import INK, Drawing, drawable
from cutjoint.workspace.certified import Certificate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RED = "#D55E00"
MOST_AXES = 3
"""Axes of which planes are drawn."""
AROUND = 0.08
"""Part of the box that is left free around it."""


@door
def certificate_picture(certificate: Certificate) -> Drawing:
    """Draw a box with the sub-boxes of its proof.

    Raises:
        MissingPackageError: matplotlib is not installed.
    """
    planes = list(combinations(range(min(len(certificate.names), MOST_AXES)), 2)) or [(0, -1)]
    titles = {"certified": "certified", "refused": "refused", "open": f"open, {certificate.part:.2%} proven"}
    title = f"{drawable(certificate.robot)}: a box of the tool, {titles[certificate.status]}"
    if certificate.counter_example is not None:
        one = certificate.counter_example
        title += f": {one.why}{f' of {drawable(one.joint)}' if one.joint else ''}"

    def draw(drawn: Figure) -> None:
        frames = drawn.subplots(1, len(planes), squeeze=False).ravel()
        for ax, (across, up) in zip(frames, planes, strict=True):
            _plane(ax, certificate, across, up)
        if certificate.proven.any():
            _scale(drawn, list(frames))
        _legend(drawn, certificate)

    breadth = {1: 9.0, 3: 14.5}[len(planes)]
    return sheet(draw, title[:110], (breadth, 4.0 if planes[0][1] < 0 else 6.0))


def _plane(ax: Axes, certificate: Certificate, across: int, up: int) -> None:
    """The sub-boxes that a plane through the counter-example, or the middle, meets."""
    from matplotlib.collections import PatchCollection
    from matplotlib.patches import Rectangle

    c, through = certificate, _through(certificate)
    others = [k for k in range(len(c.names)) if k not in (across, up)]
    met = ((c.lows[:, others] <= through[others]) & (through[others] < c.highs[:, others])).all(axis=1)
    flat = up < 0
    rows = np.flatnonzero(met)
    heights = [(0.0, 1.0)] * len(rows) if flat else list(zip(c.lows[rows, up], c.highs[rows, up], strict=True))
    patches = [
        Rectangle((c.lows[k, across], low), c.highs[k, across] - c.lows[k, across], high - low)
        for k, (low, high) in zip(rows.tolist(), heights, strict=True)
    ]
    for good in (True, False):
        some = [patch for patch, k in zip(patches, rows.tolist(), strict=True) if bool(c.proven[k]) is good]
        if not some:
            continue
        edge = 0.4 if len(rows) < 2000 else 0.0
        drawn = PatchCollection(some, linewidths=edge, edgecolors=INK if edge else "face")
        if good:
            drawn.set_array(c.margins[rows[c.proven[rows]]])
            drawn.set(cmap="viridis", clim=(0.0, 1.0))
        else:
            drawn.set(facecolor="white", hatch="////", edgecolor="#8a8a8a")
        ax.add_collection(drawn)
    _frame(ax, certificate, across, up)
    if others:
        held = ", ".join(f"{c.names[k]} = {through[k]:.4g} {c.units[k]}" for k in others)
        ax.set_title(f"at {held}", fontweight="normal")


def _frame(ax: Axes, certificate: Certificate, across: int, up: int) -> None:
    """The outline of the box, the counter-example, and names of the axes."""
    from matplotlib.patches import Rectangle

    c = certificate
    low, high = (0.0, 1.0) if up < 0 else (float(c.lower[up]), float(c.upper[up]))
    breadth = float(c.upper[across] - c.lower[across])
    outline = Rectangle((float(c.lower[across]), low), breadth, high - low, fill=False, edgecolor=INK, linewidth=2.0)
    ax.add_patch(outline)
    if c.counter_example is not None:
        at = c.counter_example.at
        place = at[c.names[across]], 0.5 if up < 0 else at[c.names[up]]
        ax.plot(*place, "X", color=RED, markersize=13, markeredgecolor="white", clip_on=False, zorder=5)
    ax.set_xlim(float(c.lower[across]) - AROUND * breadth, float(c.upper[across]) + AROUND * breadth)
    ax.set_ylim(low - AROUND * (high - low), high + AROUND * (high - low))
    ax.set_xlabel(f"{c.names[across]} [{c.units[across]}]")
    ax.grid(visible=False)
    narrow = up >= 0 and c.units[across] == c.units[up] and breadth < 0.6 * (high - low)
    ax.locator_params(nbins=5)
    if narrow:
        ax.set_xticks([float(c.lower[across]), float(c.upper[across])])
    if up < 0:
        ax.set_yticks([])
        return
    ax.set_ylabel(f"{c.names[up]} [{c.units[up]}]")
    if c.units[across] == c.units[up]:
        ax.set_aspect("equal")


def _through(certificate: Certificate) -> Array:
    """The point that the planes go through."""
    c = certificate
    if c.counter_example is not None:
        return np.array([c.counter_example.at[name] for name in c.names]) - 1e-9 * (c.upper - c.lower)
    if not c.proven.all() and len(c.lows):
        worst = int(np.argmin(np.where(c.proven, np.inf, c.margins)))
        return np.asarray(0.5 * (c.lows[worst] + c.highs[worst]))
    return np.asarray(0.5 * (c.lower + c.upper))


def _scale(drawn: Figure, frames: list[Axes]) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    bar = drawn.colorbar(ScalarMappable(Normalize(0.0, 1.0), "viridis"), ax=frames, fraction=0.04, pad=0.02)
    bar.set_label("margin of a sub-box (0: not proven)")


def _legend(drawn: Figure, certificate: Certificate) -> None:
    """What is not in the scale of colours."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    shown: list[Patch | Line2D] = []
    if not certificate.proven.all():
        shown.append(Patch(facecolor="white", edgecolor="#8a8a8a", hatch="////", label="not proven"))
    if certificate.counter_example is not None:
        at = [
            f"{name} = {value:.4g}"
            for name, value in certificate.counter_example.at.items()
            if name in certificate.names
        ]
        shown.append(
            Line2D(
                [], [], marker="X", linestyle="", color=RED, markersize=11, label=f"counter-example: {', '.join(at)}"
            )
        )
    if shown:
        drawn.legend(handles=shown, loc="outside lower left", ncols=2)
