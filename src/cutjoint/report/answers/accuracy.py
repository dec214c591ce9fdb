"""The picture of an error budget: which numbers the error of the tool is due to, and where the tool is by chance."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cutjoint.accuracy import Accuracy
from cutjoint.arrays import Array
from cutjoint.report.answers.sheet import sheet
from cutjoint.report.figures import BLUE, GREEN, GREY, INK, ORANGE, Drawing, drawable
from cutjoint.stiffness.telling import told
from cutjoint.units import handy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

MOST_BARS = 12
FEWEST_BARS = 6
"""Room for so many, so that one bar is no wall."""
MOST_DOTS = 3000
REACH = 3.3
"""Standard deviations from the middle to the edge."""
LONG = 34
PLANES = ((0, 1), (0, 2), (1, 2))
SIZE = np.sqrt(5.991)
"""Mahalanobis radius of the ellipse that holds 95 % of a normal scatter in a plane (chi squared, two degrees)."""


def draw_accuracy(found: Accuracy) -> Drawing:
    """Ranked bars of the numbers, and the scatter of the samples in the planes of the world with 95 % ellipses.

    Raises:
        MissingPackageError: matplotlib is not installed.
    """

    def draw(figure: Figure) -> None:
        halves = figure.add_gridspec(1, 2, width_ratios=(1.2, 1.0))
        left, right = (figure.add_subfigure(halves[0, k]) for k in (0, 1))
        _bars(left, found)
        grid = right.subplots(2, 2)
        reach = REACH * float(found.sigma[:3].max())
        factor, unit = handy(reach, "m")
        for ax, plane in zip(grid.flat, PLANES, strict=False):
            _scatter(ax, found, plane, factor, unit, factor * reach or 1.0)
        grid.flat[3].axis("off")
        _words(grid.flat[3], found)

    return sheet(draw, f"Accuracy of {found.robot}")


def _bars(part: SubFigure, found: Accuracy) -> None:
    """How far each number moves the tool at its bound, the largest share on top."""
    ax = part.subplots()
    ranked = [one for one in found.ranked if one.bound.any()]
    shown, rest = ranked[:MOST_BARS], ranked[MOST_BARS:]
    sizes = np.array([np.linalg.norm(one.bound[:3]) for one in shown])
    factor, unit = handy(float(sizes.max(initial=0.0)), "m")
    places = np.arange(len(shown))[::-1]
    ax.barh(places, factor * sizes, color=[ORANGE if one.strained else BLUE for one in shown], height=0.65)
    for where, size, one in zip(places, factor * sizes, shown, strict=True):
        ax.annotate(
            f"{100.0 * one.share:.3g} %",
            (size, where),
            (4, 0),
            textcoords="offset points",
            va="center",
            fontsize=10,
            color=INK,
        )
    ax.set_yticks(places, [_short(drawable(one.name)) for one in shown], fontsize=10)
    ax.margins(x=0.16)
    ax.set_axisbelow(True)
    ax.set_ylim(min(-0.6, len(places) - FEWEST_BARS), len(places) - 0.4)
    ax.grid(axis="y", visible=False)
    ax.set_xlabel(f"tool moves at the bound of the number [{unit}]")
    share = sum(one.share for one in rest)
    more = f"; {len(rest)} more have {100.0 * share:.2g} %" if rest else ""
    ax.set_title(f"Causes, and their part of the variance{more}", fontsize=11.5)
    if any(one.strained for one in shown):
        from matplotlib.patches import Patch

        patches = [Patch(color=BLUE, label="joints follow"), Patch(color=ORANGE, label="joints must give")]
        part.legend(handles=patches, loc="outside lower center", ncols=2)


def _scatter(ax: Axes, found: Accuracy, plane: tuple[int, int], factor: float, unit: str, reach: float) -> None:
    first, second = plane
    some = found.errors[:MOST_DOTS, :3] * factor
    if len(some):
        ax.plot(some[:, first], some[:, second], ".", color=GREY, markersize=2.0, alpha=0.35, rasterized=True)
    ax.plot(*_ellipse(found.covariance[np.ix_(plane, plane)] * factor**2), color=BLUE)
    worst = factor * found.worst
    if max(worst[first], worst[second]) < reach:
        x, y = worst[first], worst[second]
        ax.plot([-x, x, x, -x, -x], [-y, -y, y, y, -y], color=GREEN, linewidth=1.2, linestyle=(0, (4, 2)))
    ax.set_xlim(-reach, reach)
    ax.set_ylim(-reach, reach)
    ax.set_aspect("equal")
    ax.locator_params(nbins=4)
    ax.set_xlabel(f"error {'xyz'[first]} [{unit}]")
    ax.set_ylabel(f"error {'xyz'[second]} [{unit}]")


def _ellipse(covariance: Array) -> Array:
    values, axes = np.linalg.eigh(covariance)
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    return np.asarray(
        axes @ (SIZE * np.sqrt(np.maximum(values, 0.0))[:, None] * np.array([np.cos(angle), np.sin(angle)]))
    )


def _words(ax: Axes, found: Accuracy) -> None:
    ax.plot([], [], ".", color=GREY, label=f"{min(len(found.errors), MOST_DOTS)} samples")
    ax.plot([], [], color=BLUE, label="95 % (normal)")
    if np.sort(found.worst[:3])[1] < REACH * found.sigma[:3].max():  # a box is drawn where there is room for it
        ax.plot([], [], color=GREEN, linewidth=1.2, linestyle=(0, (4, 2)), label="worst case")
    ax.legend(loc="upper center", fontsize=10)
    lines = ["tool [m] at", told(found.position.tolist(), float(np.abs(found.position).max()))]
    if len(found.errors):
        for percent in (95.0, 99.7):
            away, turned = found.within(percent)
            (a, metres), (b, radians) = handy(away, "m"), handy(turned, "rad")
            lines.append(f"{percent:g} % within\n{a * away:.3g} {metres}, {b * turned:.3g} {radians}")
    ax.text(0.5, 0.05, "\n".join(lines), transform=ax.transAxes, ha="center", fontsize=10)


def _short(name: str) -> str:
    return name if len(name) <= LONG else f"{name[: LONG - 3]}..."
