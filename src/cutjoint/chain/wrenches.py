"""Forces in the cut joints: the multipliers of the closure's rows as wrenches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, Values, readonly
from cutjoint.chain.closure import Cut, CutFrames
from cutjoint.description.model import CutType


@dataclass(frozen=True, eq=False)
class Wrench(Values):
    """What body A of a cut exerts on body B: force (3,) [N], moment (3,) [N m] at the origin of frame b, world axes."""

    force: Array
    moment: Array


def wrenches(cuts: tuple[Cut, ...], frames: CutFrames, multipliers: Array) -> dict[str, Wrench]:
    """Multipliers of all rows of the cuts, one after another, as wrenches on body B at frame b, world axes."""
    found: dict[str, Wrench] = {}
    row = 0
    for index, cut in enumerate(cuts):
        a, b = frames.axes_a[index], frames.axes_b[index]
        part = multipliers[row : row + cut.rows]
        row += cut.rows
        moment = np.zeros(3)
        if cut.type is CutType.PRISMATIC:
            force, moment = a[:, :2] @ part[:2], part[2:5]
        else:
            force = part[:3]
        if cut.type is CutType.FIXED:
            moment = part[3:6]
        elif cut.type is CutType.REVOLUTE:
            z = b[:, 2]
            moment = part[3] * np.cross(z, a[:, 0]) + part[4] * np.cross(z, a[:, 1])
        elif cut.type is CutType.UNIVERSAL:
            moment = part[3] * np.cross(b[:, 1], a[:, 0])
        found[cut.name] = Wrench(readonly(force), readonly(moment))
    return found
