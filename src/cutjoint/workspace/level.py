"""How far inside or outside the cells of a workspace are, by the parts of ways between them that are reached.

On a way from a cell that is reached to one that is not, the boundary is at the part f of it: f of a step from the one,
1 - f from the other.  A cell that is reached has the distance to the plane through the places where its ways end,
1 / sqrt(sum 1 / d_k^2); one that is not has the least of its distances, which is rather too far.  So the places where
the level changes its sign, cells interpolated, lie on the boundary or a little inside.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.workspace.region import Workspace

NEAREST = 0.01
"""Of a step: a boundary does not run through the centre of a cell."""


def level_of(space: Workspace) -> Array:
    """Positive inside and negative outside, [m] or [rad], with one more cell at every side of the grid; 0 at the
    boundary.  Where the parts of ways are not known the boundary is midway."""
    inside = np.pad(space.inside, 1)
    steps = [axis.step for axis in space.axes]
    far = max(steps)
    inverse, least = np.zeros(inside.shape), np.full(inside.shape, far)
    ways = parts_of(space)
    for axis, step in enumerate(steps):
        near = np.full(inside.shape, np.inf)
        for back in (0, 1):
            beside = np.roll(inside, -1 if back == 0 else 1, axis)  # nothing is reached at the ends
            part = ways[2 * axis + back]
            ends = inside & ~beside
            near[ends] = np.minimum(near[ends], step * part[ends])
            other = np.roll(ends, 1 if back == 0 else -1, axis)
            least[other] = np.minimum(least[other], step * (1.0 - np.roll(part, 1 if back == 0 else -1, axis)[other]))
        inverse += 1.0 / near**2
    return np.where(inside, 1.0 / np.sqrt(np.maximum(inverse, 1.0 / far**2)), -least)


def parts_of(space: Workspace) -> Array:
    """The parts of ways to the next cells that are reached, 1/2 where they are not known, between `NEAREST` and 1 less
    that; with one more cell at every side of the grid, shape (2 axes, ...)."""
    given = np.full((2 * len(space.axes), *space.inside.shape), 0.5) if space.ways is None else space.ways
    around = [(0, 0), *([(1, 1)] * len(space.axes))]
    return np.asarray(np.pad(np.clip(given, NEAREST, 1.0 - NEAREST), around, constant_values=0.5))
