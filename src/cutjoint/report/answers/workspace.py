"""The picture of a workspace: slices through three axes, one map over two, curves over one.

What is coloured is one map, bright where it is good; without a map what is reached.  The boundary of the region is a
line, drawn of the spread cells as its surface is.  Fitted shapes are outlined.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.arrays import Array, as_vector
from cutjoint.doors import door
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.report.answers.sheet import sheet
from cutjoint.report.figures import BLUE, COLOURS, DASHES, INK, Drawing, drawable
from cutjoint.simulation.panels import scaled
from cutjoint.workspace import FieldMap, FittedShape, GridAxis, Workspace
from cutjoint.workspace.grid_body import distances
from cutjoint.workspace.level import level_of
from cutjoint.workspace.region import volume_unit
from cutjoint.workspace.surface import AROUND, spread_cells

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

REACHED = "#9ecae8"
OUTLINE = "#D55E00"
PLANES = ((0, 1), (0, 2), (1, 2))
MOST_CURVES = 6
SAME = 1e-6
"""Part of its size by which a map varies at least, or it counts as constant."""
ODD = 2.0
"""Percent of the worst cells whose values may be beyond the scale of colours, such as those beside a singularity."""


@dataclass(frozen=True, eq=False)
class _Shown:
    """What a picture shows of a workspace."""

    space: Workspace
    field: FieldMap | None
    at: tuple[int, ...]
    shapes: tuple[FittedShape, ...]


@door
def workspace_picture(
    space: Workspace,
    what: str = "",
    *,
    through: Sequence[float] | Mapping[str, float] | None = None,
    shapes: Sequence[FittedShape] = (),
) -> Drawing:
    """Draw a workspace: over three axes three slices through a point, over two a map, over one curves.

    Args:
        space: the workspace.
        what: name of the map that gives the colours; default its first, if it has one.  Over one axis all maps are
            drawn unless one is named.
        through: the point that the slices go through, a coordinate an axis or some by name, [m] or [rad]; default the
            middle of the largest fitted shape, else the place that is furthest from the boundary.
        shapes: fitted shapes to outline; a slice that misses one leaves it out.

    Raises:
        UnknownNameError: there is no such map, or no such axis.
        InputError: no cell is reached, the point is outside of the grid, or shapes are of other axes.
        MissingPackageError: matplotlib is not installed.
    """
    if not space.inside.any():
        raise InputError(f"no cell of the workspace of {space.robot} is reached, so there is nothing to draw")
    if what and what not in space.maps:
        raise UnknownNameError("map", what, tuple(space.maps))
    names = tuple(axis.name for axis in space.axes)
    if odd := [one for one in shapes if one.names != names]:
        raise InputError(
            f"a {odd[0].kind} over {', '.join(odd[0].names)} is none of a workspace over {', '.join(names)}"
        )
    field = space.maps[what or next(iter(space.maps))] if space.maps else None
    shown = _Shown(space, field, _through(space, through, shapes), tuple(shapes))
    if len(names) == 1:
        return sheet(lambda drawn: _curves(drawn, shown, bool(what)), _title(space), (9.0, 5.4))
    if len(names) == 2:
        return sheet(lambda drawn: _flat(drawn, shown), _title(space), (9.0, 6.4))
    return sheet(lambda drawn: _slices(drawn, shown), _title(space), (13.0, _height(space)))


def _title(space: Workspace) -> str:
    what = ("reach", "area", "volume")[len(space.axes) - 1]
    held = "".join(f", {name} = {value:.4g}" for name, value in space.held.items())
    return f"{drawable(space.robot)}: workspace, {what} {space.extent:.4g} {space.unit}{held}"[:110]


def _through(
    space: Workspace, given: Sequence[float] | Mapping[str, float] | None, shapes: Sequence[FittedShape]
) -> tuple[int, ...]:
    """Numbers of the cells, one an axis, that the slices go through."""
    names = tuple(axis.name for axis in space.axes)
    if shapes:
        point = max(shapes, key=lambda one: one.extent).centre.copy()
    else:
        steps = np.array([axis.step for axis in space.axes])
        deep = distances(space.inside, steps)
        at = np.unravel_index(int((deep if deep.any() else space.inside).argmax()), deep.shape)
        point = np.array([axis.values[k] for axis, k in zip(space.axes, at, strict=True)])
    if isinstance(given, Mapping):
        for name, value in given.items():
            if name not in names:
                raise UnknownNameError("axis", name, names)
            point[names.index(name)] = as_vector(f"through {name}", [value], 1)[0]
    elif given is not None:
        point = as_vector("through", np.asarray(given), len(names))
    for axis, value in zip(space.axes, point, strict=True):
        low, high = axis.values[0] - axis.step / 2.0, axis.values[-1] + axis.step / 2.0
        if not low <= value <= high:
            grid = f"the grid, {low:.4g} to {high:.4g} {axis.unit}"
            raise InputError(f"through {axis.name} = {value:.6g} {axis.unit} is outside of {grid}")
    return tuple(int(np.abs(axis.values - value).argmin()) for axis, value in zip(space.axes, point, strict=True))


def _ratios(space: Workspace) -> list[float]:
    """Breadths of the three slices to each other."""
    if len({axis.unit for axis in space.axes}) > 1:
        return [1.0, 1.0, 1.0]
    spans = [high - low for low, high in (_span(space, k) for k in range(3))]
    ratios = [spans[i] for i, _ in PLANES]
    return [max(one, 0.45 * max(ratios)) for one in ratios]


def _height(space: Workspace) -> float:
    """Of the sheet of three slices [inch], so that there is little left around them."""
    if len({axis.unit for axis in space.axes}) > 1:
        return 5.6
    tallest = max(high - low for low, high in (_span(space, k) for k in (1, 2)))
    return float(np.clip(9.6 * tallest / sum(_ratios(space)) + 2.0, 4.6, 8.0))


def _slices(drawn: Figure, shown: _Shown) -> None:
    axes = shown.space.axes
    panels = drawn.subplots(1, 3, width_ratios=_ratios(shown.space))
    painted = None
    for panel, (i, j) in zip(panels, PLANES, strict=True):
        (k,) = {0, 1, 2} - {i, j}
        painted = _slice(panel, shown, i, j)
        cut = axes[k]
        factor, unit = _scale(cut, shown.space, k)
        panel.set_title(f"{cut.name} = {_rounded(factor * cut.values[shown.at[k]])} {unit}")
        for axis, line in ((i, panel.axvline), (j, panel.axhline)):
            factor, _ = _scale(axes[axis], shown.space, axis)
            line(factor * axes[axis].values[shown.at[axis]], color=INK, linewidth=0.9, linestyle=(0, (2, 3)), alpha=0.7)
    _colour_bar(drawn, shown, painted, list(panels))
    _legend(drawn, shown)


def _flat(drawn: Figure, shown: _Shown) -> None:
    panel = drawn.subplots()
    painted = _slice(panel, shown, 0, 1)
    _colour_bar(drawn, shown, painted, [panel])
    _legend(drawn, shown)


def _slice(panel: Axes, shown: _Shown, i: int, j: int) -> QuadMesh | None:
    """The plane of axes i and j through the chosen point."""
    space = shown.space
    pick = tuple(slice(None) if k in (i, j) else shown.at[k] for k in range(len(space.axes)))
    (x, x_unit), (y, y_unit) = (_scaled_axis(space, k) for k in (i, j))
    inside = space.inside[pick].T
    painted = None
    if shown.field is None:
        panel.pcolormesh(x, y, np.ma.masked_equal(inside, False), cmap=_one_colour(REACHED), rasterized=True)
    else:
        values = np.ma.masked_invalid(np.where(inside, shown.field.values[pick].T, np.nan))
        low, high = _limits(shown.field)
        colours = "viridis" if shown.field.best == "high" else "viridis_r"
        painted = panel.pcolormesh(x, y, values, cmap=colours, vmin=low, vmax=high, rasterized=True)
    around = _around(space, pick).T
    wide, tall = (np.concatenate([[2 * v[0] - v[1]], v, [2 * v[-1] - v[-2]]]) for v in (x, y))
    if inside.any():
        panel.contour(wide, tall, around, levels=[0.0], colors=[INK], linewidths=1.6)
    for shape, dash in zip(shown.shapes, DASHES, strict=False):
        _outline(panel, shown, shape, (i, j), dash)
    for k, unit, limit in ((i, x_unit, panel.set_xlim), (j, y_unit, panel.set_ylim)):
        factor, _ = _scale(space.axes[k], space, k)
        low, high = _span(space, k)
        limit(factor * low, factor * high)
        (panel.set_xlabel if k == i else panel.set_ylabel)(f"{space.axes[k].name} [{unit}]")
    panel.locator_params(nbins=5)
    panel.grid(False)
    if space.axes[i].unit == space.axes[j].unit:
        panel.set_aspect("equal")
    return painted


def _around(space: Workspace, pick: tuple[slice | int, ...]) -> Array:
    """Positive inside the region and negative outside, in a slice of cells, with one more cell at every side."""
    if space.ways is None:
        return spread_cells(space.inside[pick])[(slice(AROUND - 1, 1 - AROUND),) * 2] - 0.5
    return level_of(space)[tuple(one if isinstance(one, slice) else one + 1 for one in pick)]


def _outline(panel: Axes, shown: _Shown, shape: FittedShape, plane: tuple[int, int], dash: object) -> None:
    """The edge of a shape in a slice, where that meets it."""
    space = shown.space
    half, missed = shape.breadths / 2.0, 0.0
    for k in {*range(len(space.axes))} - {*plane}:
        off = (space.axes[k].values[shown.at[k]] - shape.centre[k]) / half[k]
        if abs(off) > 1.0:
            return
        if shape.kind == "sphere" or (shape.kind == "cylinder" and shape.names[k] != shape.upright):
            missed = off**2
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    round_here = shape.kind == "sphere" or (
        shape.kind == "cylinder" and shape.upright not in (shape.names[plane[0]], shape.names[plane[1]])
    )
    around = (
        np.array([np.cos(turn), np.sin(turn)]) if round_here else np.array([[-1, 1, 1, -1, -1], [-1, -1, 1, 1, -1]])
    )
    rows = []
    for k, part in zip(plane, around, strict=True):
        narrower = np.sqrt(1.0 - missed) if shape.names[k] != shape.upright else 1.0
        factor, _ = _scale(space.axes[k], space, k)
        rows.append(factor * (shape.centre[k] + half[k] * narrower * part))
    panel.plot(*rows, color="#ffffff", linewidth=4.0)
    panel.plot(*rows, color=OUTLINE, linewidth=2.2, linestyle=dash)


def _curves(drawn: Figure, shown: _Shown, one_map: bool) -> None:
    space = shown.space
    x, unit = _scaled_axis(space, 0)
    fields = [shown.field] if one_map or shown.field is None else list(space.maps.values())[:MOST_CURVES]
    panels = drawn.subplots(len(fields), 1, sharex=True, squeeze=False)[:, 0]
    breadth = x[1] - x[0]
    edges = x - breadth / 2.0
    for panel, field, colour in zip(panels, fields, COLOURS, strict=False):
        for start, end in _runs(space.inside):
            panel.axvspan(edges[start], edges[end - 1] + breadth, color=REACHED, alpha=0.45, linewidth=0)
        if field is None:
            panel.set_yticks([])
        else:
            panel.plot(x, field.values, color=colour if len(fields) > 1 else BLUE)
            panel.set_title(drawable(field.title))
            panel.set_ylabel(f"[{field.unit or '-'}]")
    panels[-1].set_xlabel(f"{space.axes[0].name} [{unit}]; reached where shaded")


def _runs(inside: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> list[tuple[int, int]]:
    """First and last (exclusive) of the cells in a row that are reached."""
    steps = np.diff(inside.astype(int), prepend=0, append=0)
    return list(zip(np.flatnonzero(steps == 1).tolist(), np.flatnonzero(steps == -1).tolist(), strict=True))


def _limits(field: FieldMap) -> tuple[float, float]:
    """Ends of the scale of colours: of all values but the few worst."""
    values = field.values[np.isfinite(field.values)]
    if not len(values):
        return 0.0, 1.0
    worst = ODD if field.best == "high" else 100.0 - ODD
    ends = np.array([np.percentile(values, worst), values.max() if field.best == "high" else values.min()])
    low, high = float(ends.min()), float(ends.max())
    size = max(abs(low), abs(high))
    # what varies by rounding alone, such as a condition number of 1 everywhere, has one colour
    return (low, high) if high - low > SAME * size else (low - 0.5 * size - 1e-300, high + 0.5 * size + 1e-300)


def _colour_bar(drawn: Figure, shown: _Shown, painted: QuadMesh | None, panels: list[Axes]) -> None:
    if painted is None or shown.field is None:
        return
    beyond = "min" if shown.field.best == "high" else "max"
    bar = drawn.colorbar(painted, ax=panels, extend=beyond, shrink=0.85, pad=0.02)
    good = "more is better" if shown.field.best == "high" else "less is better"
    bar.set_label(f"{drawable(_named(shown.field))}\n({good})")
    bar.outline.set_visible(False)


def _legend(drawn: Figure, shown: _Shown) -> None:
    from matplotlib.lines import Line2D

    rows = [Line2D([], [], color=INK, linewidth=1.6, label="boundary")]
    for shape, dash in zip(shown.shapes, DASHES, strict=False):
        margin = f", margin {shape.margin:.3g} {shape.units[0]}" if shape.margin else ""
        label = f"largest {shape.word}: {shape.extent:.4g} {volume_unit(shape.units)}{margin}"
        rows.append(Line2D([], [], color=OUTLINE, linewidth=2.2, linestyle=dash, label=label))
    drawn.legend(handles=rows, loc="outside lower center", ncols=2, handlelength=2.8)


def _named(field: FieldMap) -> str:
    return f"{field.title} [{field.unit or '-'}]"


def _one_colour(colour: str) -> Colormap:
    from matplotlib.colors import ListedColormap

    return ListedColormap([colour])


def _span(space: Workspace, k: int) -> tuple[float, float]:
    """What of an axis is drawn: the reached cells and a little around."""
    axis = space.axes[k]
    used = np.flatnonzero(space.inside.any(axis=tuple(other for other in range(space.inside.ndim) if other != k)))
    low, high = float(axis.values[used[0]]), float(axis.values[used[-1]])
    around = max(0.06 * (high - low), 1.5 * axis.step)
    return low - around, high + around


def _scale(axis: GridAxis, space: Workspace, k: int) -> tuple[float, str]:
    """Factor and unit in which an axis is drawn: the same for all axes of one unit."""
    ends = [value for other, one in enumerate(space.axes) if one.unit == axis.unit for value in _span(space, other)]
    if axis.unit == "rad":
        return float(np.degrees(1.0)), "deg"
    return scaled(np.array(ends), axis.unit)


def _scaled_axis(space: Workspace, k: int) -> tuple[Array, str]:
    factor, unit = _scale(space.axes[k], space, k)
    return np.asarray(factor * space.axes[k].values), unit


def _rounded(value: float) -> str:
    return f"{value:.4g}" if abs(value) > 1e-9 else "0"
