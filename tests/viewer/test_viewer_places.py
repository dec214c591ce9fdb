"""A workspace beside the robot: where it is in the world, and what the page says of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from kit.regions import ball, region

from cutjoint import load
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Pose
from cutjoint.mechanism.rotations import turned
from cutjoint.mechanism.task import Task
from cutjoint.viewer import LiveView, Places, show
from cutjoint.viewer.picture.figure import Figure
from cutjoint.viewer.picture.places import legend_of, show_places
from cutjoint.workspace import in_world

TURNED = turned(np.array([0.3, -0.5, 1.1]))


@pytest.mark.parametrize("names", [("x", "y", "z"), ("z", "x"), ("y",)])
@pytest.mark.parametrize("axes", ["world", "tool"])
def test_cells_are_where_the_task_has_them(names: tuple[str, ...], axes: str) -> None:
    task = Task(("x", "y", "z"), Pose(np.array([1.0, 2.0, 3.0]), TURNED), "drawn", axes)  # type: ignore[arg-type]
    space = region(ball, 8, axes=len(names), names=names, scale=0.1, at=0.4)
    found = in_world(space, task, "condition")
    wanted = [task.pose(dict(zip(names, row, strict=True))).position for row in space.points]
    np.testing.assert_allclose(found.points, wanted, atol=1e-12)
    np.testing.assert_array_equal(found.values, space.maps["condition"].values[space.inside])
    if len(names) == 1:
        assert len(found.faces) == 0
        return
    corners = found.vertices[found.faces.astype(int)]
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    if len(names) == 2:  # the squares of all cells, all seen from one side
        assert np.linalg.norm(sides, axis=1).sum() / 2.0 == pytest.approx(space.inside.sum() * space.cell)
        assert (sides @ sides[0] > 0.0).all()
    else:
        volume = float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6.0
        assert volume == pytest.approx(space.extent, rel=0.02)


def test_many_cells_are_thinned() -> None:
    task = Task(("x", "y", "z"), Pose(np.zeros(3), np.eye(3)), "drawn")
    space = region(ball, 200, axes=2)
    found = in_world(space, task)
    assert 5_000 < len(found.points) <= 20_000
    assert {tuple(one) for one in found.points[:, :2]} <= {tuple(one) for one in space.points}


def test_what_has_no_place_is_refused() -> None:
    task = Task(("x", "y", "z"), Pose(np.zeros(3), np.eye(3)), "drawn")
    with pytest.raises(InputError, match="rz has no place"):
        in_world(region(ball, 6, names=("x", "y", "rz")), task)
    with pytest.raises(UnknownNameError, match="colour"):
        in_world(region(ball, 6), task, "colour")
    with pytest.raises(InputError, match="no cell"):
        in_world(region(lambda x: x > 9.0, 6, axes=1), task)
    one = np.zeros((1, 3))
    for wrong in (
        {"points": np.zeros((1, 2))},
        {"points": one * np.nan},
        {"points": one, "values": [1.0, 2.0]},
        {"points": one, "values": [np.nan]},
        {"vertices": one, "faces": [[0, 0, 1]]},
        {"vertices": one, "faces": [[0, 0, 0.5]]},
    ):
        with pytest.raises(InputError):
            Places("wrong", **wrong)


def test_colours_go_from_the_worst_to_the_best() -> None:
    values = np.linspace(1.0, 9.0, 201)
    for low_is_good in (True, False):
        places = Places("Workspace", np.zeros((201, 3)), values, "condition number [-]", low_is_good)
        dark, yellow = places.ends
        assert (dark > yellow) == low_is_good
        assert yellow == (1.0 if low_is_good else 9.0)
        rows = legend_of(places)
        assert [row["colour"] for row in rows] == ["#440154", "#fde725"]
        assert rows[1]["text"] == f"condition number [-]: {yellow:.3g}"


def test_the_picture_has_room_for_it() -> None:
    chain = load("fivebar")
    beside = chain.task.home.position + np.array([[0.3, 0.0, 0.0], [0.31, 0.0, 0.1], [0.3, 0.0, 0.1]])
    places = Places("Workspace", beside, vertices=beside, faces=[[0, 1, 2]])
    figure, plain = (Figure(chain, chain.home, beside=one) for one in (places.all_points, None))
    show_places(figure, places)
    assert {"Workspace: points": False, "Workspace: surface": True}.items() <= {
        title: shown for title, (_, shown) in figure.toggles.items()
    }.items()
    assert {"robot/places/cloud", "robot/places/surface"} <= set(figure.scene.paths())
    assert figure.radius == plain.radius
    page = show(chain, places=places).html
    assert "Workspace: surface" in page


@pytest.mark.slow
def test_live_views_show_it() -> None:
    chain = load("fivebar")
    places = Places("Workspace", chain.task.home.position[None] + np.eye(3))
    with LiveView(chain, port=0, places=places) as view:
        (_, controls, _) = view._greet(0)
        assert {"title": "Workspace: points", "paths": ["robot/places/cloud"], "shown": True} in controls["toggles"]


@pytest.mark.slow
def test_points_and_surface_are_seen(
    tmp_path: Path, chromium: str, differing: Callable[[np.ndarray, np.ndarray], int]
) -> None:
    image = pytest.importorskip("PIL.Image")
    chain = load("cpm")
    home = chain.task.home.position
    shape = in_world(region(ball, 14, scale=0.15, at=home), chain.task)
    shown = (
        Places("Workspace"),
        Places("Workspace", shape.points),
        Places("Workspace", vertices=shape.vertices, faces=shape.faces),
    )
    pictures = []
    for k, places in enumerate(shown):
        show(chain, places=places).picture(tmp_path / f"{k}.png", width=480, height=320)
        pictures.append(np.asarray(image.open(tmp_path / f"{k}.png").convert("RGB")).astype(int))
    assert differing(pictures[0], pictures[1]) > 300
    assert differing(pictures[0], pictures[2]) > 1000
