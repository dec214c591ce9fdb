"""The picture of a workspace: every number of it has a name and unit, shapes stand where they are, nothing overlaps."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from kit.regions import ball, region, ring
from matplotlib.figure import Figure
from matplotlib.text import Text

from cutjoint.errors import InputError, UnknownNameError
from cutjoint.report.answers.sheet import write_sheet
from cutjoint.report.answers.workspace import workspace_picture
from cutjoint.report.figures import Panel, figure
from cutjoint.workspace import Workspace, largest


def texts(drawn: Figure) -> list[Text]:
    return [one for one in drawn.findobj(Text) if one.get_visible() and one.get_text().strip()]


def drawn_of(space: Workspace, *args: object, **named: object) -> Figure:
    return workspace_picture(space, *args, **named)._figure  # type: ignore[arg-type]


def check(drawn: Figure) -> None:
    """What holds of all: every axis names its quantity and unit, all texts are on the sheet, no two of them overlap."""
    for panel in drawn.axes:
        named = [one for one in (panel.get_xlabel(), panel.get_ylabel()) if one]
        assert named
        assert all("[" in one and "]" in one for one in named)
    sheet = drawn.bbox
    boxes = []
    for one in texts(drawn):
        assert "$" not in one.get_text()
        box = one.get_window_extent()
        ticks = one.get_text().lstrip("\u2212").replace(".", "").isdecimal()
        if not ticks or (sheet.x0 <= box.x0 and box.x1 <= sheet.x1):
            boxes.append((one.get_text(), box))
        if not ticks:
            assert sheet.x0 <= box.x0
            assert box.x1 <= sheet.x1, one.get_text()
            assert sheet.y0 <= box.y0
            assert box.y1 <= sheet.y1, one.get_text()
    long = [(text, box) for text, box in boxes if len(text) > 6]
    for i, (text, box) in enumerate(long):
        for other, beside in long[:i]:
            assert not box.overlaps(beside), (text, other)


@pytest.mark.parametrize("axes", [1, 2, pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize("scale", [pytest.param(1e-3, marks=pytest.mark.slow), 1.0])
def test_pictures_tell_names_and_units(axes: int, scale: float) -> None:
    space = region(ball, 16, axes=axes, scale=scale, at=scale)
    shapes = [largest(space, kind) for kind in ("box", "sphere")]
    drawn = drawn_of(space, shapes=shapes)
    check(drawn)
    said = " | ".join(one.get_text() for one in texts(drawn))
    assert "condition number" in said
    assert ("x [mm]" if scale < 0.01 else "x [m]") in said
    assert "rz = 0.25" in said
    if axes > 1:
        assert ("largest disc", "largest sphere")[axes - 2] in said
    bare = dataclasses.replace(space, maps={})
    check(drawn_of(bare))


@pytest.mark.slow
def test_slices_go_through_the_point_that_is_asked_for() -> None:
    space = region(ring, (20, 24, 12), scale=0.2)
    drawn = drawn_of(space, "speed", through={"z": 0.03, "x": -0.14})
    check(drawn)
    titles = [panel.get_title(loc="left") for panel in drawn.axes[:3]]
    step = space.axes[2].step
    assert abs(float(titles[0].split()[2]) - 0.03) <= step / 2.0 + 1e-4
    assert titles[2].startswith("x = -0.1")
    values = drawn.axes[0].collections[0].get_array()
    k = int(np.abs(space.axes[2].values - 0.03).argmin())
    assert values is not None
    np.testing.assert_array_equal(np.ma.filled(values, np.nan), space.maps["speed"].values[:, :, k].T)


@pytest.mark.slow
def test_outlines_are_those_of_the_shapes() -> None:
    space = region(ball, 20)
    for kind in ("box", "cylinder", "sphere"):
        shape = largest(space, kind)
        drawn = drawn_of(space, shapes=[shape])
        for panel, (i, j) in zip(drawn.axes[:3], ((0, 1), (0, 2), (1, 2)), strict=True):
            (k,) = {0, 1, 2} - {i, j}
            row = np.asarray([line for line in panel.lines if len(line.get_xdata()) > 3][-1].get_xydata())
            at = space.axes[k].values[np.abs(space.axes[k].values - shape.centre[k]).argmin()]
            points = np.empty((len(row), 3))
            points[:, [i, j]], points[:, k] = row, at
            assert shape.holds(points).all()
            outward = shape.centre + (points - shape.centre) * (1.0 + 1e-6)
            assert not shape.holds(outward).any()


def test_extents_stay_in_titles_and_constant_maps_have_one_colour() -> None:
    space = region(ball, 8, axes=2)
    held = dict.fromkeys(("z", "rx", "ry", "rz"), 0.123456)
    noise = np.where(space.inside, 1.0 + 1e-10 * np.arange(8), np.nan)
    same = {"condition": dataclasses.replace(space.maps["condition"], values=noise)}
    drawn = drawn_of(dataclasses.replace(space, held=held, maps=same))
    assert drawn._suptitle is not None  # type: ignore[attr-defined]
    assert f"area {space.extent:.4g} m2" in drawn._suptitle.get_text()  # type: ignore[attr-defined]
    low, high = drawn.axes[0].collections[0].get_clim()
    assert high - low > 0.5


def test_what_cannot_be_drawn_is_refused(tmp_path: Path) -> None:
    space = region(ball, 8, axes=2)
    for wrong, error, told in (
        (lambda: workspace_picture(space, "spede"), UnknownNameError, "spede"),
        (lambda: workspace_picture(space, through={"w": 0.0}), UnknownNameError, "w"),
        (lambda: workspace_picture(space, through=[0.0, 9.0]), InputError, "outside of the grid"),
        (lambda: workspace_picture(space, through=[0.0]), InputError, "shape"),
        (lambda: workspace_picture(space, shapes=[largest(region(ball, 8), "box")]), InputError, "is none of"),
        (lambda: workspace_picture(region(lambda x, y: x > 9.0, 6, axes=2)), InputError, "no cell"),
    ):
        with pytest.raises(error, match=told):
            wrong()
    with pytest.raises(InputError, match=r"\.png or \.svg"):
        write_sheet(workspace_picture(space), tmp_path / "w.gif")


def test_numbers_at_axes_are_no_source_of_formulas() -> None:
    time = np.linspace(0.0, 1.0, 5)
    drawn = figure(Panel("title", time, 1e7 * time[:, None], "N", "force", ["one"]))._figure
    assert not [one.get_text() for one in texts(drawn) if "$" in one.get_text()]
