"""The lattice of a workspace: how far it goes, found out by coarse fillings, and how fine it is to be."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import InputError
from cutjoint.workspace.filling import Filled
from cutjoint.workspace.goals import Goals
from cutjoint.workspace.lattice import Lattice

COARSE, SLOW_COARSE = 25, 11
"""Cells along an axis of a coarse filling; of a robot that is asked posture by posture."""
FEWEST = 5
"""Cells across a workspace from which on a coarse filling tells how far it goes."""
TRIES = 24
"""Coarse fillings at most, each twice as coarse or fine as the one before."""
MOST = 2.0
"""Memory that a workspace may take [GiB]."""
Range = tuple[float, float]
Region = Mapping[str, Range]
"""Coordinate -> (least, largest), [m] or [rad]."""


class Filler(Protocol):
    """Fills lattices.

    Attributes:
        at: coordinates that the workspace is joined with, shape (axes,).
        size: bytes that are kept of one cell.
    """

    at: Array
    size: int

    def fill(self, lattice: Lattice, *, coarse: bool, begun: Filled | None = None) -> Filled:
        """The cells that are reached; `begun` has those of a part of the lattice."""


def bounded(goals: Goals, given: Region, at: Array) -> dict[str, Range]:
    """What bounds a workspace from outside: what is given, and whole turns.

    Raises:
        InputError: a range is empty, of a coordinate that does not vary, or does not hold the start.
    """
    found: dict[str, Range] = {}
    for name, unit, here in zip(goals.names, goals.units, at.tolist(), strict=True):
        if name not in given:
            if unit == "rad":
                found[name] = (-math.pi, math.pi)
            continue
        low, high = given[name]
        if not (math.isfinite(low) and math.isfinite(high) and low < high):
            raise InputError(f"the range of {name} must be two growing numbers [{unit}], found {low:g} to {high:g}")
        if not low <= here <= high:
            raise InputError(
                f"the range of {name}, {low:g} to {high:g} {unit}, does not hold the start, at {here:.6g} {unit}; "
                "widen it, or start from a posture in it"
            )
        found[name] = (low, high)
    return found


THINNEST = 0.01
"""What part of its box a workspace may be, where memory is looked at before anything is known of it."""


def check_memory(filler: Filler, axes: int, cells: int) -> None:
    """Look at what a grid would take before any work.

    Raises:
        InputError: it would not fit into memory, even if it were a hundred times as thin as long.
    """
    _check(filler, cells, float(cells) ** axes, axes, THINNEST)


def _check(filler: Filler, cells: int, count: float, axes: int, part: float = 1.0) -> None:
    needed = part * count * filler.size / 2.0**30
    if needed > MOST:
        fewer = max(int(cells * (MOST / needed) ** (1.0 / axes)), 3)
        raise InputError(
            f"{cells} cells along the longest axis are up to {count:.3g} in all, which take {needed:.3g} GiB or more; "
            f"the most is {MOST:g} GiB: ask for {fewer} or fewer"
        )


def lattice_for(
    filler: Filler, goals: Goals, limits: Mapping[str, Range], cells: int, stride: Array, coarse: int = COARSE
) -> Lattice:
    """A lattice over all that is reached, `cells` along its longest axis (of the places, and of the turns).

    Args:
        limits: what bounds it from outside.
        stride: breadth of a cell to begin with, shape (axes,), [m] or [rad].
        coarse: cells along an axis of the coarse fillings.

    Raises:
        InputError: it goes on without end, nothing is reached, or it would not fit into memory.
    """
    bounds = [limits.get(name, (-math.inf, math.inf)) for name in goals.names]
    ranges = _found(filler, goals, bounds, stride, coarse)
    breadths = np.array([high - low for low, high in ranges])
    steps = np.zeros(len(ranges))
    for unit in set(goals.units):
        of_it = np.array([one == unit for one in goals.units])
        steps[of_it] = breadths[of_it].max() / cells
    shape = np.maximum(np.ceil(breadths / steps - 1e-9), 3.0)
    _check(filler, cells, float(np.prod(shape)), len(ranges))
    return _over(ranges, bounds, shape.astype(int).tolist())


def _found(filler: Filler, goals: Goals, bounds: Sequence[Range], stride: Array, coarse: int) -> list[Range]:
    """How far it goes along every axis, a cell of a coarse filling wider than was reached."""
    half = 0.5 * coarse * stride
    ranges = [
        (low, high) if math.isfinite(low) else (here - one, here + one)
        for (low, high), here, one in zip(bounds, filler.at.tolist(), half.tolist(), strict=True)
    ]
    for _ in range(TRIES):
        filled = filler.fill(_over(ranges, bounds, [coarse] * len(ranges)), coarse=True)
        steps, touched = filled.lattice.steps, filled.touched
        if not filled.inside.any():
            ranges = [
                (0.5 * (low + here), 0.5 * (high + here)) for (low, high), here in zip(ranges, filler.at, strict=True)
            ]
            continue
        at = filled.lattice.coordinates(np.flatnonzero(filled.inside))
        low, high = at.min(axis=0), at.max(axis=0)
        fine = (high - low) / steps + 1.5 >= FEWEST
        for axis, (first, last) in enumerate(ranges):
            more = 0.75 * (last - first) if touched[axis] else steps[axis]
            if touched[axis] or not touched.any():
                ranges[axis] = (max(low[axis] - more, bounds[axis][0]), min(high[axis] + more, bounds[axis][1]))
        if not touched.any() and fine.all():
            return ranges
    raise InputError(
        f"the workspace of {goals.task.robot} has no end along {', '.join(goals.names)} that could be found, or is too "
        "thin; say the range of every coordinate"
    )


def _over(ranges: Sequence[Range], bounds: Sequence[Range], shape: Sequence[int]) -> Lattice:
    """So many cells along every axis over ranges, with ends where a range ends at a bound on both sides."""
    steps = np.array([(high - low) / count for (low, high), count in zip(ranges, shape, strict=True)])
    first = np.array([low for low, _ in ranges]) + 0.5 * steps
    ends = tuple((low, high) == bound for (low, high), bound in zip(ranges, bounds, strict=True))
    return Lattice(first, steps, tuple(shape), ends)


def filled_whole(filler: Filler, lattice: Lattice, begun: Filled | None = None) -> Filled:
    """The cells that are reached; where they come to an end of the lattice that is none, of one that goes further."""
    filled = filler.fill(lattice, coarse=False) if begun is None else begun
    for _ in range(TRIES):
        touched = filled.touched
        if not touched.any():
            break
        block = filled.inside.reshape(lattice.shape)
        first, shape, ends = np.array(lattice.first), list(lattice.shape), list(lattice.ends)
        for axis in np.flatnonzero(touched).tolist():
            more = max(shape[axis] // 3, 2)
            if block.take(0, axis).any():
                first[axis] -= more * lattice.steps[axis]
                shape[axis] += more
            if block.take(-1, axis).any():
                shape[axis] += more
        lattice = replace(lattice, first=first, shape=tuple(shape), ends=tuple(ends))
        filled = filler.fill(lattice, coarse=False, begun=filled)
    return filled
