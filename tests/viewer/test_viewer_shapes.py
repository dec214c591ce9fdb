from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from cutjoint.description.model import Shape
from cutjoint.errors import InputError
from cutjoint.viewer.picture import shapes
from cutjoint.viewer.picture.figure import css, turn_down
from cutjoint.viewer.picture.shapes import along

RED = (1.0, 0.0, 0.0, 1.0)
TURNED = np.array([[0.0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])


def mesh_shape(path: Path, scale: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Shape:
    return Shape("mesh", scale, mesh=path)


@pytest.mark.parametrize(
    ("kind", "size", "mesh"),
    [
        ("box", (0.1, 0.2, 0.3), trimesh.creation.box((0.1, 0.2, 0.3))),
        ("sphere", (0.2,), trimesh.creation.icosphere(4, 0.2)),
        ("cylinder", (0.1, 0.5), trimesh.creation.cylinder(0.1, 0.5)),
        ("capsule", (0.1, 0.5), trimesh.creation.capsule(0.5, 0.1)),
    ],
)
def test_boxes_around_primitives_agree_with_trimesh(kind: str, size: tuple[float, ...], mesh: trimesh.Trimesh) -> None:
    found = shapes.corners(Shape(kind, size, placement=TURNED))
    mesh.apply_transform(TURNED)
    np.testing.assert_allclose([found.min(axis=0), found.max(axis=0)], mesh.bounds, atol=2e-3)
    assert shapes.parts(Shape(kind, size), RED)


def test_a_cylinder_stands_along_z_though_meshcat_has_it_along_y() -> None:
    (part,) = shapes.parts(Shape("cylinder", (0.1, 0.5), placement=TURNED), RED)
    np.testing.assert_allclose(np.abs(part.placement[:3, 1]), np.abs(TURNED[:3, 2]))
    np.testing.assert_allclose(part.placement[:3, 3], TURNED[:3, 3])


def test_a_mesh_is_scaled_and_every_material_of_it_is_drawn(tmp_path: Path) -> None:
    (tmp_path / "two.mtl").write_text("newmtl one\nKd 1 0 0\nnewmtl two\nKd 0 0 1\n")
    (tmp_path / "two.obj").write_text(
        "mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl one\nf 1 2 3\nusemtl two\nf 1 2 4\n"
    )
    found = shapes.parts(mesh_shape(tmp_path / "two.obj", (2.0, 1.0, 1.0)), RED)
    assert {part.thing.material.color for part in found} == {0xFF0000, 0x0000FF}
    assert shapes.corners(mesh_shape(tmp_path / "two.obj", (2.0, 1.0, 1.0))).max(axis=0).tolist() == [2.0, 1.0, 1.0]


def test_a_mesh_cannot_read_files_outside_its_folder(tmp_path: Path) -> None:
    secret = tmp_path / "secret.mtl"
    secret.write_text("newmtl one\nKd 0 1 0\n")
    inside = tmp_path / "meshes"
    inside.mkdir()
    (inside / "a.obj").write_text("mtllib ../secret.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl one\nf 1 2 3\n")
    (part,) = shapes.parts(mesh_shape(inside / "a.obj"), RED)
    assert part.thing.material.color != 0x00FF00


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("missing.stl", None, "not there"),
        ("a.txt", b"solid", "unknown kind"),
        ("cut.stl", b"\x00" * 90, "cannot be read|no triangles"),
        ("empty.obj", b"", "cannot be read|no triangles"),
        ("nan.obj", b"v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n", "finite|no triangles"),
    ],
)
def test_a_bad_mesh_is_refused_with_its_name(tmp_path: Path, name: str, content: bytes | None, message: str) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=message) as error:
        shapes.parts(mesh_shape(tmp_path / name), RED)
    assert name in str(error.value)


def test_a_tube_keeps_its_radius_and_the_order_of_its_points() -> None:
    t = np.linspace(0, 4, 50)
    path = np.column_stack([np.cos(t), np.sin(t), 0.2 * t])
    geometry = shapes.tube(path, 0.01, shapes.material(RED), sides=5).geometry
    rings = geometry.vertices.reshape(50, 5, 3)
    np.testing.assert_allclose(np.linalg.norm(rings - path[:, None], axis=2), 0.01, atol=1e-6)
    assert geometry.faces.shape == (49 * 5 * 2, 3)
    assert (np.diff(geometry.faces.reshape(49, -1).min(axis=1)) > 0).all()


def test_a_tube_survives_points_that_coincide_and_turn_back() -> None:
    path = np.array([[0, 0, 0], [0, 0, 0], [1, 0, 0], [1, 0, 0], [0, 0, 0.0]])
    assert np.isfinite(shapes.tube(path, 0.01, shapes.material(RED)).geometry.vertices).all()


@pytest.mark.parametrize("gravity", [[0, 0, -9.81], [0, 0, 9.81], [9.81, 0, 0], [1, -2, 3.0]])
def test_gravity_points_down_on_screen(gravity: list[float]) -> None:
    turn = turn_down(np.array(gravity))
    np.testing.assert_allclose(turn @ gravity, [0, 0, -np.linalg.norm(gravity)], atol=1e-12)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) > 0


def test_without_gravity_nothing_turns() -> None:
    assert (turn_down(np.zeros(3)) == np.eye(3)).all()


def test_along_is_a_rotation_that_takes_z_there() -> None:
    for direction in np.vstack([np.eye(3), -np.eye(3), [[1, 2, -3]]]):
        turn = along(direction)[:3, :3]
        np.testing.assert_allclose(turn[:, 2], direction / np.linalg.norm(direction), atol=1e-12)
        np.testing.assert_allclose(turn.T @ turn, np.eye(3), atol=1e-12)
        assert np.linalg.det(turn) > 0


def test_colours_of_a_page_keep_their_opacity() -> None:
    assert css((0.0, 0.5, 1.0, 1.0)) == "#0080ff"
    assert css((0.0, 0.0, 1.0, 0.4)) == "#0000ff66"
