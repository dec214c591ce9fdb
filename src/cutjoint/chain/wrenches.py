"""Forces in the cut joints: the multipliers of the closure's rows as wrenches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, Values, readonly
from cutjoint.chain.bound import BoundCut
from cutjoint.chain.closure import CutFrames
from cutjoint.description.cuts import Equation, Kind


@dataclass(frozen=True, eq=False)
class Wrench(Values):
    """What body A of a cut exerts on body B: force (3,) [N], moment (3,) [N m] at the origin of frame b, world axes."""

    force: Array
    moment: Array


def wrenches(cuts: tuple[BoundCut, ...], frames: CutFrames, multipliers: Array) -> dict[str, Wrench]:
    """Multipliers of all rows of the cuts, one after another, as wrenches on body B at frame b, world axes."""
    found: dict[str, Wrench] = {}
    row = 0
    for index, cut in enumerate(cuts):
        force, moment = np.zeros(3), np.zeros(3)
        for equation in cut.type.equations:
            pull, turn = _wrench(equation, frames.axes_a[index], frames.axes_b[index], multipliers[row:])
            force, moment, row = force + pull, moment + turn, row + equation.rows
        found[cut.name] = Wrench(readonly(force), readonly(moment))
    return found


def _wrench(equation: Equation, a: Array, b: Array, f: Array) -> tuple[Array | float, Array | float]:
    """Force and moment of one equation between frames with these axes (3, 3), from its multipliers, which `f` starts
    with."""
    match equation.kind:
        case Kind.POINT:
            return f[:3], 0.0
        case Kind.LOCK:
            return 0.0, f[:3]
        case Kind.SLIDE:
            return a[:, equation.axes[0]] * f[0], 0.0
        case Kind.HINGE:
            z = b[:, 2]
            return 0.0, f[0] * np.cross(z, a[:, 0]) + f[1] * np.cross(z, a[:, 1])
        case Kind.DOT:
            i, j = equation.axes
            return 0.0, f[0] * np.cross(b[:, j], a[:, i])
