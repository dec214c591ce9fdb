"""Pictures of a stiffness: how far the tool goes for a force from any side, and which parts that is due to; or the
stiffness along a motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.arrays import Array
from cutjoint.report.answers.sheet import sheet
from cutjoint.report.figures import BLUE, DASHES, GREY, INK, LIMBS, ORANGE, Drawing, drawable
from cutjoint.stiffness import PushedTool, ToolStiffness
from cutjoint.stiffness.telling import told
from cutjoint.units import handy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_BARS = 12
FEWEST_BARS = 6
"""Room for so many, so that one bar is no wall."""
PLANES = ((0, 1), (0, 2), (1, 2))


def draw_stiffness(found: ToolStiffness, pushed: tuple[str, PushedTool]) -> Drawing:
    """Displacements for a force of 1 N from any side, in three planes, and the parts of the deflection by loads:
    what they are, in words, and what they do.

    Raises:
        MissingPackageError: matplotlib is not installed.
    """

    def draw(figure: Figure) -> None:
        halves = figure.add_gridspec(1, 2, width_ratios=(1.0, 1.15))
        left, right = (figure.add_subfigure(halves[0, k]) for k in (0, 1))
        grid = left.subplots(2, 2)
        factor, unit = handy(float(np.abs(found.compliance[:3, :3]).max()), "m/N")
        reach = 1.15 * factor * max(_half(found, plane).max() for plane in PLANES)
        for ax, plane in zip(grid.flat, PLANES, strict=False):
            _ellipse(ax, found, plane, factor, unit, reach or 1.0)
        grid.flat[3].axis("off")
        _legend(grid.flat[3], found)
        _bars(right.subplots(), *pushed)

    return sheet(draw, f"Stiffness of {found.robot}")


def draw_course(times: Array, found: Sequence[ToolStiffness]) -> Drawing:
    """Principal stiffness against forces and moments at instants [s] of a motion."""
    forces = np.array([one.translation.stiffness for one in found])
    moments = np.array([one.rotation.stiffness for one in found])

    def draw(figure: Figure) -> None:
        for ax, values, unit, title in zip(
            figure.subplots(1, 2),
            (forces, moments),
            ("N/m", "N m/rad"),
            ("against forces", "against moments"),
            strict=True,
        ):
            finite = values[np.isfinite(values)]
            factor, shown = handy(float(finite.max(initial=0.0)), unit)
            for k, name in enumerate(("softest direction", "between", "hardest direction")):
                colour, _ = LIMBS[k]
                if np.isfinite(values[:, k]).any():
                    ax.plot(times, factor * values[:, k], color=colour, linestyle=DASHES[k], label=name)
            if finite.size:
                ax.set_ylim(bottom=0.0)
                ax.legend(loc="best")
            else:
                ax.text(0.5, 0.5, "rigid", transform=ax.transAxes, ha="center", color=GREY)
            ax.set_title(title)
            ax.set_xlabel("time [s]")
            ax.set_ylabel(f"stiffness [{shown}]")

    return sheet(draw, f"Stiffness of {found[0].robot} along a motion")


def _half(found: ToolStiffness, plane: tuple[int, int]) -> Array:
    """Half the sides of the box around an ellipse [m/N]."""
    return np.asarray(np.linalg.norm(found.compliance[list(plane), :3], axis=1))


def _ellipse(ax: Axes, found: ToolStiffness, plane: tuple[int, int], factor: float, unit: str, reach: float) -> None:
    """Where a force of 1 N from any side takes the tool, seen along the third axis."""
    rows = factor * found.compliance[list(plane), :3]
    values, axes = np.linalg.eigh(rows @ rows.T)
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    round_ = axes @ (np.sqrt(np.maximum(values, 0.0))[:, None] * np.array([np.cos(angle), np.sin(angle)]))
    ax.fill(*round_, color=BLUE, alpha=0.2)
    ax.plot(*round_, color=BLUE)
    for k in range(3):
        colour, dash = LIMBS[k]
        ax.plot([0.0, rows[0, k]], [0.0, rows[1, k]], color=colour, linestyle=dash)
    ax.set_xlim(-reach, reach)
    ax.set_ylim(-reach, reach)
    ax.set_aspect("equal")
    ax.locator_params(nbins=4)
    ax.set_xlabel(f"{'xyz'[plane[0]]} [{unit}]")
    ax.set_ylabel(f"{'xyz'[plane[1]]} [{unit}]")


def _legend(ax: Axes, found: ToolStiffness) -> None:
    """What the lines mean, and the principal stiffness, in words."""
    for k, axis in enumerate("xyz"):
        colour, dash = LIMBS[k]
        ax.plot([], [], color=colour, linestyle=dash, label=f"by 1 N along {axis}")
    ax.fill([], [], color=BLUE, alpha=0.3, label="by 1 N from any side")
    ax.legend(loc="upper center", fontsize=10)
    principal = []
    for value in found.translation.stiffness:
        factor, unit = handy(value, "N/m")
        principal.append("rigid" if np.isinf(value) else f"{factor * value:.4g} {unit}")
    words = ["tool [m] at", told(found.position.tolist(), found.length), "principal stiffness", *principal]
    ax.text(0.5, 0.0, "\n".join(words), transform=ax.transAxes, ha="center", fontsize=10)


def _bars(ax: Axes, title: str, pushed: PushedTool) -> None:
    """Shares of a deflection, the largest on top."""
    parts = pushed.parts
    shown = [one for one in parts if one.share][:MOST_BARS]
    rest = 1.0 - sum(one.share for one in shown)
    names = [drawable(f"{one.name} ({one.kind})" if one.kind != "balance" else one.name) for one in shown]
    shares = [100.0 * one.share for one in shown]
    if len(parts) > len(shown) and abs(rest) > 1e-6 and shown:
        names.append("all others")
        shares.append(100.0 * rest)
    places = np.arange(len(names))[::-1]
    ax.barh(places, shares, color=[BLUE if one >= 0.0 else ORANGE for one in shares], height=0.65)
    for place, share in zip(places, shares, strict=True):
        ax.annotate(
            f"{share:.3g} %",
            (max(share, 0.0), place),
            (4, 0),
            textcoords="offset points",
            va="center",
            color=INK,
            fontsize=10,
        )
    ax.set_yticks(places, names)
    ax.margins(x=0.16)
    ax.set_axisbelow(True)
    ax.set_ylim(min(-0.6, len(places) - FEWEST_BARS), len(places) - 0.4)
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("part of the deflection [%]")
    whole = float(np.linalg.norm(pushed.deflection[:3]))
    factor, unit = handy(whole, "m")
    ax.set_title(f"{drawable(title)}\nmoves the tool by {factor * whole:.4g} {unit}", fontsize=11.5)
