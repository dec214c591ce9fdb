"""One look for all plots: colours that everybody can tell apart, the same colour and dash for a limb everywhere.

Colours from M. Okabe, K. Ito: Color Universal Design (2008).
"""

from __future__ import annotations

BLUE, ORANGE, GREEN = "#0072B2", "#E69F00", "#009E73"
PURPLE = "#CC79A7"
INK, GREY = "#222222", "#8a8a8a"

LIMBS = ((BLUE, "-"), (ORANGE, (0, (6, 1.5))), (GREEN, (0, (2, 1.2))))
"""Colour and dash of limb 1, 2 and 3 (and of the axes x, y and z); the robots under urdf/ wear the same colours."""

DESIRED, ACTUAL = GREY, PURPLE

SETTINGS = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.5,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "svg.fonttype": "path",
    "svg.hashsalt": "cutjoint",
    "path.simplify_threshold": 0.3,
}
