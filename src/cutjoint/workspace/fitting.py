"""The largest box, cylinder and sphere that fit into a workspace and keep a margin from its boundary.

A shape is looked for among the full blocks of the grid (`grid_body`): the box exactly by number of blocks, the cylinder
over all ranges of layers and the sphere by distances from the centres of cells.  Then its place and size change freely
while it keeps the margin from every obstacle, which is tested exactly: with g the gaps between shape and obstacle along
the axes, sqrt(sum g^2) >= margin.  So the shape is inside as far as the grid tells, and every point of it has the
margin to all that is not.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.doors import door
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.reprs import line
from cutjoint.workspace.grid_body import TOUCHING, GridBody, Mask, body_of, distances, full_blocks
from cutjoint.workspace.largest_box import largest_box
from cutjoint.workspace.region import Workspace

Kind = Literal["box", "cylinder", "sphere"]
KINDS: tuple[Kind, ...] = get_args(Kind)
ROUNDING = 1e-9
FINEST = 1e-3
"""Shortest step of a search for a better place, in steps of the grid."""


@dataclass(frozen=True, eq=False)
class FittedShape(Frozen):
    """A box along the axes, an upright cylinder or a sphere inside a workspace; over two axes a rectangle or a disc,
    over one a stretch.

    Attributes:
        kind: "box", "cylinder" or "sphere".
        names: of the axes.
        units: of the axes, m or rad.
        centre: its middle, shape (axes,), in `units`.
        breadths: from end to end along every axis, shape (axes,), in `units`.
        extent: its length, area or volume, in the product of `units`.
        margin: that it keeps from the boundary, in the unit of the axes.
        steps: between the centres of cells, shape (axes,), in `units`: what the boundary is known to.
        upright: name of the axis that a cylinder stands along; empty for others.
    """

    kind: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    centre: Array
    breadths: Array
    extent: float
    margin: float
    steps: Array
    upright: str = ""

    __repr__ = line("kind", "centre", "breadths", "extent", "margin")

    @property
    def low(self) -> Array:
        """Its lowest coordinates, shape (axes,)."""
        return self.centre - self.breadths / 2.0

    @property
    def high(self) -> Array:
        """Its highest coordinates, shape (axes,)."""
        return self.centre + self.breadths / 2.0

    @property
    def radius(self) -> float | None:
        """Of a cylinder or sphere; None for a box."""
        if self.kind == "box":
            return None
        return float(next(b for b, name in zip(self.breadths, self.names, strict=True) if name != self.upright)) / 2.0

    def holds(self, points: Array) -> Mask:
        """Whether points (count, axes) are in it, those on its boundary included."""
        gaps = np.abs(np.asarray(points, dtype=float) - self.centre) / (self.breadths / 2.0)
        held = (gaps <= 1.0 + ROUNDING).all(axis=1)
        if self.kind != "box":
            around = [name != self.upright for name in self.names]
            held &= (gaps[:, around] ** 2).sum(axis=1) <= 1.0 + ROUNDING
        return np.asarray(held)


@door
def largest(space: Workspace, kind: str = "box", *, margin: float = 0.0, upright: str = "") -> FittedShape:
    """The largest box, cylinder or sphere inside `space`, by volume.

    Args:
        space: the workspace; of what lies beyond its grid nothing is known, so it counts as not reached.
        kind: "box" (edges along the axes), "cylinder" or "sphere".  Over two axes "sphere" is a disc and "box" a
            rectangle; over one both are a stretch.
        margin: least distance between shape and boundary, in the unit of the axes, which are then all in m or all in
            rad; 0 or more.
        upright: axis that the cylinder stands along; default z if it is one of them, else the last.

    Raises:
        UnknownNameError: no such kind, or no such axis.
        InputError: the margin is negative or not finite; a round shape or a margin over axes in m and rad; a cylinder
            over fewer than three axes; or nothing fits.
    """
    if kind not in KINDS:
        raise UnknownNameError("shape", kind, KINDS)
    names, units = tuple(axis.name for axis in space.axes), tuple(axis.unit for axis in space.axes)
    if not (math.isfinite(margin) and margin >= 0.0):
        raise InputError(f"margin must be a length of 0 or more [{units[0]}], found {margin!r}")
    stands = upright or ("z" if "z" in names else names[-1])
    if stands not in names:
        raise UnknownNameError("axis", upright, names)
    _check_axes(kind, names, units, margin, names.index(stands))
    body = body_of(space)
    if not body.full.any():
        raise InputError(
            f"the region of {space.robot} is nowhere two cells thick along every axis, so that nothing is known to "
            "fit; use more cells"
        )
    # in steps of the grid nothing is too small or too large to be squared
    unit = float(body.steps.max())
    scaled = GridBody(body.inside, np.zeros(len(names)), body.steps / unit)  # which begins at 0
    axis = names.index(stands) if kind == "cylinder" else -1
    found = {"box": _box, "cylinder": _cylinder, "sphere": _sphere}[kind](scaled, margin / unit, axis)
    if found is None:
        widest = float(scaled.distance.max()) * unit
        raise InputError(
            f"no {kind} with a margin of {margin:g} {units[0]} fits into the region of {space.robot}: "
            f"no place in it is further than {widest:.4g} {units[0]} from what is not known to be inside; "
            "take a smaller margin or more cells"
        )
    centre, breadths = found[0] * unit + body.start, found[1] * unit
    extent = _extent(kind, breadths, axis)
    return FittedShape(
        kind, names, units, centre, breadths, extent, margin, body.steps, stands if kind == "cylinder" else ""
    )


def _check_axes(kind: str, names: tuple[str, ...], units: tuple[str, ...], margin: float, upright: int) -> None:
    if kind == "cylinder" and len(names) < 3:
        raise InputError(f"a cylinder needs three axes, found {', '.join(names)}; 'box' and 'sphere' fit there")
    told = ", ".join(f"{name} [{unit}]" for name, unit in zip(names, units, strict=True))
    if margin > 0.0 and len(set(units)) > 1:
        raise InputError(f"a margin is a distance, which axes in m and rad do not have: {told}; leave it out")
    around = [unit for k, unit in enumerate(units) if kind == "sphere" or k != upright]
    if kind != "box" and len(set(around)) > 1:
        raise InputError(f"a {kind} over axes in m and rad is not round: {told}; fit a box")


def _extent(kind: str, breadths: Array, upright: int) -> float:
    if kind == "box":
        return float(breadths.prod())
    if kind == "cylinder":
        return math.pi / 4.0 * float(breadths.prod())
    d = len(breadths)
    return float(math.pi ** (d / 2.0) / math.gamma(d / 2.0 + 1.0) * float(breadths[0] / 2.0) ** d)


Placed = tuple[Array, Array] | None
"""Centre and breadths of a shape, shapes (axes,)."""


def _box(body: GridBody, margin: float, _: int) -> Placed:
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


def _sphere(body: GridBody, margin: float, _: int) -> Placed:
    at = np.unravel_index(int(body.distance.argmax()), body.distance.shape)
    starts = [np.array(at) * body.steps, *((low + high) / 2.0 for low, high in _box_of_blocks(body, 0.0))]
    below, above = body.obstacles

    def radius(at: Array) -> float:
        gaps = np.maximum(np.maximum(below - at, at - above), 0.0)
        return math.sqrt(float((gaps**2).sum(axis=1).min())) - margin

    centre = max((_climbed(radius, start, body.steps) for start in starts), key=radius)
    size = radius(centre)
    return (centre, np.full(len(centre), 2.0 * size)) if size > 0.0 else None


def _cylinder(body: GridBody, margin: float, axis: int) -> Placed:
    below, above = body.obstacles
    around = np.arange(3) != axis

    def radius(at: Array) -> float:
        gap = np.maximum(below[:, axis] - at[3], at[2] - above[:, axis])
        near = gap < margin - TOUCHING
        room = np.sqrt(margin**2 - np.maximum(gap[near], 0.0) ** 2)
        gaps = np.maximum(np.maximum(below[near][:, around] - at[:2], at[:2] - above[near][:, around]), 0.0)
        return float((np.sqrt((gaps**2).sum(axis=1)) - room).min(initial=np.inf))

    def volume(at: Array) -> float:
        size = radius(at) if at[3] > at[2] else -1.0
        return size * size * float(at[3] - at[2]) if size > 0.0 else -1.0

    starts = _cylinder_of_layers(body, margin, axis)
    for low, high in _box_of_blocks(body, 0.0):
        starts.append(np.array([*((low + high) / 2.0)[around], low[axis] + margin, high[axis] - margin]))
    steps = np.concatenate([body.steps[around], body.steps[[axis, axis]]])
    found = max((_climbed(volume, start, steps) for start in starts), key=volume)
    if volume(found) <= 0.0:
        return None
    centre, breadths = np.empty(3), np.empty(3)
    centre[around], centre[axis] = found[:2], (found[2] + found[3]) / 2.0
    breadths[around], breadths[axis] = 2.0 * radius(found), found[3] - found[2]
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


def _climbed(value: Callable[[Array], float], at: Array, steps: Array) -> Array:
    """The place near `at` where `value` is largest: by steps along axes and diagonals, halved where none helps."""
    size, best = 0.5, value(at)
    ways = [*np.eye(len(at))]
    ways += [a + sign * b for i, a in enumerate(np.eye(len(at))) for b in np.eye(len(at))[:i] for sign in (1.0, -1.0)]
    while size > FINEST:
        tried = [at + sign * size * way * steps for way in ways for sign in (1.0, -1.0)]
        values = [value(one) for one in tried]
        k = int(np.argmax(values))
        if values[k] > best:
            at, best = tried[k], values[k]
        else:
            size /= 2.0
    return at
