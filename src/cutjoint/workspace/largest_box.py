"""The largest box of full blocks in a grid, by number of blocks, exactly.

For every range of layers along the third axis the blocks that are full in all of them are a picture in the plane, and
its largest rectangle is looked for: over all ranges of rows, the shortest of the runs that end at a column.  All ranges
of layers take these steps together; those that could not beat the best one found, by their number of full blocks, are
left out.
"""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import numpy.typing as npt

from cutjoint.workspace.grid_body import Mask

MOST_WORK = 2_000_000_000
"""Steps over single blocks above which a coarser grid is searched."""
TOGETHER = 2**21
"""Blocks of the pictures that are looked at together."""
Corners = tuple[tuple[int, ...], tuple[int, ...]]
NOTHING: Corners = ((0, 0, 0), (0, 0, 0))


def largest_box(full: Mask) -> Corners | None:
    """First and last block (exclusive) along every axis of the largest box of blocks; None where none is full.

    Where the search would be too long, blocks are taken together by twos, threes and so on: the box found is inside,
    and by at most as many blocks a side shorter.
    """
    if not full.any():
        return None
    axes = range(full.ndim)
    used = [np.flatnonzero(full.any(axis=tuple(other for other in axes if other != axis))) for axis in axes]
    first = [int(one[0]) for one in used]
    part = full[tuple(slice(one[0], one[-1] + 1) for one in used)]
    group = 1
    while _work(grouped := _together(part, group)) > MOST_WORK and grouped.any():
        group += 1
    if not grouped.any():
        return None
    solid = grouped.reshape(grouped.shape + (1,) * (3 - full.ndim))
    order = np.argsort(-np.array(solid.shape), kind="stable")  # the most layers are the cheapest as columns
    low, high = _search(solid.transpose(order))
    back = np.argsort(order)
    lows, highs = (
        tuple(one + group * end[at] for one, at in zip(first, back[: full.ndim], strict=True)) for end in (low, high)
    )
    return lows, highs


def _work(full: Mask) -> float:
    columns, rows, layers = sorted((*full.shape, 1, 1)[:3], reverse=True)
    return float(columns * rows**2 * layers**2) / 4.0


def _together(full: Mask, group: int) -> Mask:
    """Groups of blocks that are all full; what is left over at the ends is left out."""
    if group == 1:
        return full
    for axis in range(full.ndim):
        count = full.shape[axis] // group
        shape = (*full.shape[:axis], count, group, *full.shape[axis + 1 :])
        full = np.asarray(full.take(range(count * group), axis).reshape(shape).all(axis=axis + 1))
    return full


def _search(full: Mask) -> Corners:
    """The largest box of full blocks, of which there are some; shape (columns, rows, layers)."""
    columns, rows, layers = full.shape
    below = np.zeros((columns, rows, layers + 1), dtype=np.int32)
    np.cumsum(full, axis=2, out=below[:, :, 1:])
    ranges = np.array([(a, b + 1) for a, b in combinations_with_replacement(range(layers), 2)])
    bounds = np.zeros(len(ranges), dtype=np.int64)
    size = max(1, TOGETHER // (columns * rows))
    for i in range(0, len(ranges), size):
        bounds[i : i + size] = _pictures(below, ranges[i : i + size]).sum(axis=(0, 1))
    bounds *= ranges[:, 1] - ranges[:, 0]
    best, found = 0, NOTHING
    order = np.argsort(-bounds, kind="stable")
    for i in range(0, len(order), size):
        some = order[i : i + size]
        some = some[bounds[some] > best]
        if not len(some):
            break
        of_these, corners = _widest(_pictures(below, ranges[some]), ranges[some], best)
        if of_these > best:
            best, found = of_these, corners
    return found


def _pictures(below: npt.NDArray[np.int32], ranges: npt.NDArray[np.int64]) -> Mask:
    """Whether a column and row is full over a range of layers, shape (columns, rows, ranges)."""
    low, high = ranges.T
    return np.asarray(below[:, :, high] - below[:, :, low] == high - low)


def _widest(pictures: Mask, ranges: npt.NDArray[np.int64], best: int) -> tuple[int, Corners]:
    """The largest rectangle of all pictures, times their layers, if it has more than `best` blocks."""
    columns, rows, count = pictures.shape
    runs = np.zeros((columns + 1, rows, count), dtype=np.int16)  # of full blocks, that end at a column
    for column in range(columns):
        np.add(runs[column], 1, out=runs[column + 1], where=pictures[column])
    layers, found = ranges[:, 1] - ranges[:, 0], NOTHING
    longest = int(layers.max()) * int(runs.max())
    by_row = np.ascontiguousarray(runs[1:].transpose(1, 0, 2))
    for first in range(rows):
        if (rows - first) * longest <= best:
            break
        least = by_row[first].copy()
        for last in range(first, rows):
            if last > first:
                np.minimum(least, by_row[last], out=least)
            sizes = least.max(axis=0) * layers * (last - first + 1)
            k = int(sizes.argmax())
            if sizes[k] > best:
                best, column = int(sizes[k]), int(least[:, k].argmax()) + 1
                found = (
                    (column - int(least[column - 1, k]), first, int(ranges[k, 0])),
                    (column, last + 1, int(ranges[k, 1])),
                )
    return best, found
