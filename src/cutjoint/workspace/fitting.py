"""The largest box, cylinder and sphere that fit into a workspace and keep a margin from its boundary.

A shape is looked for among the full blocks of the grid (`grid_body`): the box exactly by number of blocks, the cylinder
over all ranges of layers and the sphere by distances from the centres of cells.  Then its place and size change freely
while it keeps the margin from every obstacle, which is tested exactly: with g the gaps between shape and obstacle along
the axes, sqrt(sum g^2) >= margin.  So the shape is inside as far as the grid tells, and every point of it has the
margin to all that is not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.doors import door
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.reprs import line
from cutjoint.workspace.grid_body import GridBody, Mask, body_of
from cutjoint.workspace.placing import box_in, cylinder_in, sphere_in
from cutjoint.workspace.region import Workspace

Kind = Literal["box", "cylinder", "sphere"]
KINDS: tuple[Kind, ...] = get_args(Kind)
WORDS = {"box": ("stretch", "rectangle", "box"), "sphere": ("stretch", "disc", "sphere"), "cylinder": ("cylinder",) * 3}
"""A shape over one, two and three axes."""
ROUNDING = 1e-9
"""A point on the boundary of a shape is in it."""


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
    def word(self) -> str:
        """What it is called over so many axes: a box is a rectangle over two."""
        return WORDS[self.kind][len(self.names) - 1]

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
    check_kinds((kind,), margin)
    names, units = tuple(axis.name for axis in space.axes), tuple(axis.unit for axis in space.axes)
    stands = upright or ("z" if "z" in names else names[-1])
    if stands not in names:
        raise UnknownNameError("axis", upright, names)
    _check_axes(kind, names, units, margin, names.index(stands))
    body, steps = body_of(space), np.array([axis.step for axis in space.axes])
    if not body.full.any():
        raise InputError(
            f"the region of {space.robot} is nowhere two cells thick along every axis, so that nothing is known to "
            "fit; use more cells"
        )
    # in steps of the grid nothing is too small or too large to be squared
    unit = float(body.steps.max())
    scaled = GridBody(body.inside, np.zeros(len(names)), body.steps / unit)  # which begins at 0
    axis = names.index(stands) if kind == "cylinder" else -1
    found = {"box": box_in, "cylinder": cylinder_in, "sphere": sphere_in}[kind](scaled, margin / unit, axis)
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
        kind, names, units, centre, breadths, extent, margin, steps, stands if kind == "cylinder" else ""
    )


def check_kinds(kinds: Sequence[str], margin: float) -> None:
    """Look at kinds of shapes, and the margin that they keep.

    Raises:
        UnknownNameError: no such kind.
        InputError: the margin is negative or not finite.
    """
    for kind in kinds:
        if kind not in KINDS:
            raise UnknownNameError("shape", kind, KINDS)
    if not (math.isfinite(margin) and margin >= 0.0):
        raise InputError(f"margin must be a length of 0 or more [m or rad], found {margin!r}")


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
