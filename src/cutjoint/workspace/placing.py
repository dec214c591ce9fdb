"""Where the largest box, cylinder and sphere between the obstacles of a grid are, and how large.

Each begins where the grid alone would have it and then moves and grows while it keeps its margin from every obstacle.
Bodies are in units of about a step, and begin at 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.workspace.grid_body import TOUCHING, GridBody, distances, full_blocks
from cutjoint.workspace.largest_box import largest_box

NEAR = 6.0
"""Obstacles so many steps of the grid further away than those that are touched are looked at while a shape is moved."""
FINEST = 1e-3
"""Shortest step of a search for a better place, in steps of the grid."""
GAIN = 1e-6
"""Part of the volume or radius that a move must gain."""
MOST_MOVES = 100
Value = Callable[[Array], float]
Placed = tuple[Array, Array] | None
"""Centre and breadths of a shape, shapes (axes,)."""


def box_in(body: GridBody, margin: float, _: int) -> Placed:
    """The largest box along the axes, None where none fits."""
    found = [
        _grown(body, margin, low + inset, high - inset)
        for narrowed, inset in ((margin, 0.0), (0.0, margin))
        for low, high in _box_of_blocks(body, narrowed)
        if (high - low > 2.0 * inset).all()
    ]
    return max(found, key=lambda one: float(one[1].prod()), default=None)


def _box_of_blocks(body: GridBody, margin: float) -> list[tuple[Array, Array]]:
    """Lowest and highest coordinates of the largest box of blocks that keep a margin, if there is one."""
    corners = largest_box(full_blocks(body.narrowed(margin)))
    return [] if corners is None else [(np.array(corners[0]) * body.steps, np.array(corners[1]) * body.steps)]


def _grown(body: GridBody, margin: float, low: Array, high: Array) -> tuple[Array, Array]:
    """A box that keeps the margin, moved out side by side, first where it gains most, until none can be moved."""
    below, above = body.obstacles
    while True:
        best, gain = None, TOUCHING
        for axis in range(len(low)):
            others = np.arange(len(low)) != axis
            # how near an obstacle may come along this axis, by its gaps along the others
            gaps = np.maximum(np.maximum(below - high, low - above), 0.0)[:, others]
            beside = ((below < high - TOUCHING) & (above > low + TOUCHING))[:, others].all(axis=1)
            squares = (gaps**2).sum(axis=1)
            near = (squares < (margin - TOUCHING) ** 2) if margin > TOUCHING else beside
            room = np.sqrt(np.maximum(margin**2 - squares[near], 0.0))
            start, end = above[near, axis], below[near, axis]
            lower = (start + room)[start <= low[axis] + TOUCHING].max(initial=-np.inf)
            upper = (end - room)[end >= high[axis] - TOUCHING].min(initial=np.inf)
            for side, to, outward in ((low, lower, low[axis] - lower), (high, upper, upper - high[axis])):
                more = outward / (high[axis] - low[axis])
                if math.isfinite(to) and more > gain:
                    best, gain = (side, axis, to), more
        if best is None:
            return (low + high) / 2.0, high - low
        best[0][best[1]] = best[2]


def sphere_in(body: GridBody, margin: float, _: int) -> Placed:
    """The largest sphere, None where none fits."""
    at = np.unravel_index(int(body.distance.argmax()), body.distance.shape)
    starts = [np.array(at) * body.steps, *((low + high) / 2.0 for low, high in _box_of_blocks(body, 0.0))]

    def gaps_to(at: Array, below: Array, above: Array) -> Array:
        return np.asarray(np.linalg.norm(np.maximum(np.maximum(below - at, at - above), 0.0), axis=1))

    every = body.obstacles

    def radius(at: Array) -> float:
        return float(gaps_to(at, *every).min()) - margin

    def radius_near(at: Array) -> Value:
        gaps = gaps_to(at, *every)
        below, above = (one[gaps <= gaps.min() + NEAR] for one in every)
        return lambda to: float(gaps_to(to, below, above).min()) - margin

    found = [_settled(radius, radius_near, start, body.steps) for start in starts]
    centre = max(found, key=radius)
    size = radius(centre)
    return (centre, np.full(len(centre), 2.0 * size)) if size > 0.0 else None


@dataclass(frozen=True, eq=False)
class _Standing:
    """Cylinders along an axis between obstacles, told by their middle (2 numbers), low and high end."""

    below: Array
    above: Array
    margin: float
    axis: int

    def gaps(self, at: Array) -> tuple[Array, Array]:
        """From the axis of a cylinder to every obstacle: aside and along."""
        around = np.arange(3) != self.axis
        below, above = self.below[:, around], self.above[:, around]
        aside = np.linalg.norm(np.maximum(np.maximum(below - at[:2], at[:2] - above), 0.0), axis=1)
        return aside, np.maximum(self.below[:, self.axis] - at[3], at[2] - self.above[:, self.axis])

    def radius(self, at: Array) -> float:
        aside, along = self.gaps(at)
        near = along < self.margin - TOUCHING
        room = np.sqrt(self.margin**2 - np.maximum(along[near], 0.0) ** 2)
        return float((aside[near] - room).min(initial=np.inf))

    def volume(self, at: Array) -> float:
        size = self.radius(at) if at[3] > at[2] else -1.0
        return size * size * float(at[3] - at[2]) if size > 0.0 else -1.0

    def near(self, at: Array) -> _Standing:
        """Between those obstacles that a cylinder could soon meet."""
        aside, along = self.gaps(at)
        kept = (aside <= max(self.radius(at), 0.0) + self.margin + NEAR) & (along <= self.margin + NEAR)
        return _Standing(self.below[kept], self.above[kept], self.margin, self.axis)


def cylinder_in(body: GridBody, margin: float, axis: int) -> Placed:
    """The largest cylinder along an axis, None where none fits."""
    around = np.arange(3) != axis
    starts = _cylinder_of_layers(body, margin, axis)
    for low, high in _box_of_blocks(body, 0.0):
        starts.append(np.array([*((low + high) / 2.0)[around], low[axis] + margin, high[axis] - margin]))
    steps = np.concatenate([body.steps[around], body.steps[[axis, axis]]])
    every = _Standing(*body.obstacles, margin, axis)

    found = max(
        (_settled(every.volume, lambda at: every.near(at).volume, start, steps) for start in starts), key=every.volume
    )
    if every.volume(found) <= 0.0:
        return None
    centre, breadths = np.empty(3), np.empty(3)
    centre[around], centre[axis] = found[:2], (found[2] + found[3]) / 2.0
    breadths[around], breadths[axis] = 2.0 * every.radius(found), found[3] - found[2]
    return centre, breadths


def _cylinder_of_layers(body: GridBody, margin: float, axis: int) -> list[Array]:
    """The best cylinder about a centre of cells that ends at layers of them, if there is one: its middle (2 numbers),
    low and high end.

    The radius over a range of layers is at most that over a part of it, so ranges are taken from short to long, and
    those that can be no better than the best one are not measured.
    """
    layers = np.moveaxis(body.narrowed(margin), axis, 0)
    around = np.delete(body.steps, axis)
    step, count = float(body.steps[axis]), len(layers)
    most = np.full((count, count), np.inf)  # radius over the layers i to j, or what it is at most
    best, found = 0.0, list[Array]()
    for length in range(1, count):
        for i in range(count - length):
            j = i + length
            bound = min(most[i, j - 1], most[i + 1, j]) if length > 1 else np.inf
            most[i, j] = bound
            if bound**2 * (count - 1) * step <= best:  # nor can a longer one be
                most[i, j] = 0.0
            elif length == 1 or bound**2 * length * step > best:
                room = distances(np.asarray(layers[i : j + 1].all(axis=0)), around)
                at = np.unravel_index(int(room.argmax()), room.shape)
                most[i, j] = room[at]
                if most[i, j] ** 2 * length * step > best:
                    best = most[i, j] ** 2 * length * step
                    found = [np.array([*(np.array(at) * around), step * i, step * j])]
    return found


def _settled(value: Value, near: Callable[[Array], Value], at: Array, steps: Array) -> Array:
    """The place near `at` where `value` is largest; `near` gives it for a surrounding of `NEAR`, quicker to ask."""
    for _ in range(MOST_MOVES):
        to = _climbed(near(at), at, steps)
        if value(to) <= value(at):
            break
        moved, at = float(np.abs(to - at).max()), to
        if moved < FINEST:
            break
    return at


def _climbed(value: Value, start: Array, steps: Array) -> Array:
    """The place within half of `NEAR` where `value` is largest: by steps along axes and diagonals, halved where none
    helps."""
    at, size, best = start, 0.5, value(start)
    ways = [*np.eye(len(at))]
    ways += [a + sign * b for i, a in enumerate(np.eye(len(at))) for b in np.eye(len(at))[:i] for sign in (1.0, -1.0)]
    while size > FINEST and np.abs(at - start).max() < NEAR / 2.0:
        tried = [at + sign * size * way * steps for way in ways for sign in (1.0, -1.0)]
        values = [value(one) for one in tried]
        k = int(np.argmax(values))
        if values[k] > best + GAIN * abs(best):
            at, best = tried[k], values[k]
        else:
            size /= 2.0
    return at
