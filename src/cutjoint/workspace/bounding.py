"""The lattice of a workspace: how far it goes, found out by coarse fillings, and how fine it is to be."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.errors import InputError
from cutjoint.workspace.filling import Filled
from cutjoint.workspace.goals import Goals
from cutjoint.workspace.lattice import Lattice

COARSE = 25
"""Cells along an axis of a coarse filling."""
FEWEST = 9
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

    def fill(self, lattice: Lattice, *, coarse: bool) -> Filled:
        """The cells that are reached."""


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
                f"the range of {name}, {low:g} to {high:g} {unit}, does not hold the start, at {here:.6g} {unit}; widen "
                "it, or start from a posture in it"
            )
        found[name] = (low, high)
    return found


def lattice_for(filler: Filler, goals: Goals, limits: Mapping[str, Range], cells: int, stride: Array) -> Lattice:
    """A lattice over all that is reached, `cells` along its longest axis (of the places, and of the turns).

    Args:
        limits: what bounds it from outside.
        stride: breadth of a cell to begin with, shape (axes,), [m] or [rad].

    Raises:
        InputError: it goes on without end, nothing is reached, or it would not fit into memory.
    """
    ranges = [limits.get(name) for name in goals.names]
    return _fine(filler, goals, _found(filler, goals, ranges, stride), limits, cells)


def _found(
    filler: Filler, goals: Goals, limits: Sequence[Range | None], stride: Array
) -> list[Range]:
    """How far it goes along every axis, a cell of a coarse filling wider than was reached."""
    stride = np.array(stride)
    for axis, one in enumerate(limits):
        if one is not None:
            stride[axis] = (one[1] - one[0]) / COARSE
    for _ in range(TRIES):
        lattice = _coarse(filler.at, limits, stride)
        filled = filler.fill(lattice, coarse=True)
        if not filled.inside.any():
            stride *= 0.5
            continue
        low, high = _box(filled)
        across = np.round((high - low) / stride).astype(int) + 1
        touched = filled.touched
        if touched.any():
            stride[touched] *= 2.0
            continue
        thin = (across < FEWEST) & (np.array([one is None for one in limits]) | (across < 3))
        if not thin.any():
            return _widened(low, high, stride, limits)
        stride[thin] *= np.maximum(across[thin] + 2.0, 2.0) / (2.0 * FEWEST)
    raise InputError(
        f"the workspace of {goals.task.robot} has no end along {', '.join(goals.names)} that could be found, or is too "
        "thin; say the range of every coordinate"
    )


def _coarse(at: Array, limits: Sequence[Range | None], stride: Array) -> Lattice:
    free = Lattice.around(at, stride, COARSE)
    first, shape, ends = np.array(free.first), list(free.shape), list(free.ends)
    for axis, one in enumerate(limits):
        if one is not None:
            count = max(int(round((one[1] - one[0]) / stride[axis])), 3)
            stride[axis] = (one[1] - one[0]) / count
            first[axis], shape[axis], ends[axis] = one[0] + 0.5 * stride[axis], count, True
    return Lattice(first, stride, tuple(shape), tuple(ends))


def _box(filled: Filled) -> tuple[Array, Array]:
    """Least and largest coordinates of what is reached."""
    at = filled.lattice.coordinates(np.flatnonzero(filled.inside))
    return np.asarray(at.min(axis=0)), np.asarray(at.max(axis=0))


def _widened(low: Array, high: Array, stride: Array, limits: Sequence[Range | None]) -> list[Range]:
    found = []
    for axis, one in enumerate(limits):
        a, b = float(low[axis] - stride[axis]), float(high[axis] + stride[axis])
        found.append((a, b) if one is None else (max(a, one[0]), min(b, one[1])))
    return found


def _fine(
    filler: Filler, goals: Goals, ranges: Sequence[Range], limits: Mapping[str, Range], cells: int
) -> Lattice:
    breadths = np.array([high - low for low, high in ranges])
    steps = np.zeros(len(ranges))
    for unit in set(goals.units):
        of_it = [one == unit for one in goals.units]
        steps[of_it] = breadths[of_it].max() / cells
    shape = np.maximum(np.ceil(breadths / steps - 1e-9), 3.0)
    needed = float(np.prod(shape)) * filler.size / 2.0**30
    if needed > MOST:
        raise InputError(
            f"{cells} cells along the longest axis are {np.prod(shape):.3g} in all, which take {needed:.3g} GiB; the "
            f"most is {MOST:g} GiB: ask for about {int(cells * (MOST / needed) ** (1.0 / len(ranges)))}"
        )
    steps = breadths / shape
    first = np.array([low for low, _ in ranges]) + 0.5 * steps
    ends = tuple(
        name in limits and (low, high) == limits[name] for name, (low, high) in zip(goals.names, ranges, strict=True)
    )
    return Lattice(first, steps, tuple(int(one) for one in shape), ends)


def filled_whole(filler: Filler, lattice: Lattice) -> Filled:
    """The cells that are reached; where they come to an end of the lattice that is none, of one that goes further."""
    filled = filler.fill(lattice, coarse=False)
    for _ in range(TRIES):
        touched = filled.touched
        if not touched.any():
            break
        block = filled.inside.reshape(lattice.shape)
        first, shape, ends = np.array(lattice.first), list(lattice.shape), list(lattice.ends)
        for axis in np.flatnonzero(touched).tolist():
            more = max(shape[axis] // 10, 2)
            if block.take(0, axis).any():
                first[axis] -= more * lattice.steps[axis]
                shape[axis] += more
            if block.take(-1, axis).any():
                shape[axis] += more
        lattice = replace(lattice, first=first, shape=tuple(shape), ends=tuple(ends))
        filled = filler.fill(lattice, coarse=False)
    return filled
