"""The surface of a workspace: closed, seen from outside, of the right volume; and as files."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from kit.regions import ball, random_region, region, ring

from cutjoint.errors import InputError
from cutjoint.workspace import Surface, surface, write_surface

BODIES = {
    "ball": (ball, 4.0 / 3.0 * math.pi, 2),
    "ring": (ring, 2.0 * math.pi**2 * 0.7 * 0.3**2, 0),
    "box": (lambda x, y, z: (np.abs(x) < 0.8) & (np.abs(y) < 0.6) & (np.abs(z) < 0.5), 8 * 0.8 * 0.6 * 0.5, 2),
    "beyond the grid": (lambda x, y, z: z < 0.2, 2.2 * 2.2 * 1.3, 2),
}


def is_closed(made: Surface) -> bool:
    """Whether every edge of a triangle is that of one other, the other way round, and no vertex is left alone."""
    faces = made.faces
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    there, back = {tuple(edge) for edge in edges.tolist()}, {tuple(edge) for edge in edges[:, ::-1].tolist()}
    return len(there) == len(edges) and there == back and len(np.unique(faces)) == len(made.vertices)


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("seed", [0, *(pytest.param(one, marks=pytest.mark.slow) for one in range(1, 5))])
def test_surfaces_are_closed_and_enclose_the_extent(name: str, seed: int) -> None:
    inside, volume, holes = BODIES[name]
    random = np.random.default_rng(seed)
    scale, at = 10.0 ** random.uniform(-3, 3), random.normal(size=3)
    cells = random.integers(19, 23 if seed == 0 else 60, size=3)
    space = region(inside, tuple(cells.tolist()), scale=scale, at=scale * at, extent=volume)
    made = surface(space)
    assert is_closed(made)
    assert made.volume == pytest.approx(volume * scale**3, rel=1e-3)  # positive: seen from outside
    assert made.unit == "m3"
    edges = {
        tuple(sorted(edge)) for face in made.faces.tolist() for edge in zip(face, face[1:] + face[:1], strict=True)
    }
    assert len(made.vertices) - len(edges) + len(made.faces) == holes  # Euler
    if name in ("ball", "ring"):
        x = (made.vertices - scale * at) / scale
        off = np.linalg.norm(x, axis=1) - 1.0 if name == "ball" else np.hypot(np.hypot(*x.T[:2]) - 0.7, x[:, 2]) - 0.3
        assert np.abs(off).max() < 1.2 * 2.2 / (cells.min() - 1)
        assert np.abs(off).mean() < 0.3 * 2.2 / (cells.min() - 1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_whatever_the_region_its_surface_is_closed(seed: int) -> None:
    space = random_region(seed, 3, most=12)
    made = surface(space)
    faces = made.faces
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    # of bodies that touch in an edge two pairs of triangles have it
    there, counts = np.unique(edges, axis=0, return_counts=True)
    back, as_many = np.unique(edges[:, ::-1], axis=0, return_counts=True)
    assert np.array_equal(there, back)
    assert np.array_equal(counts, as_many)
    assert made.volume == pytest.approx(space.extent, rel=0.2)


@pytest.mark.slow
def test_surfaces_are_written(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    made = surface(region(ball, 12, scale=0.1, at=3.0, extent=4.0 / 3.0 * math.pi))
    for suffix, exact in ((".stl", 1e-4), (".ply", 1e-12), (".OBJ", 1e-12)):
        path = write_surface(made, tmp_path / f"s{suffix}")
        found = trimesh.load(path, process=suffix == ".stl")
        assert found.is_watertight
        assert found.volume == pytest.approx(made.volume, rel=exact)
        if suffix != ".stl":
            assert np.array_equal(found.vertices, made.vertices)
            assert np.array_equal(found.faces, made.faces)
            assert b"m" in path.read_bytes()[:200]
        else:
            assert np.einsum("ij,ij->i", found.face_normals, found.triangles_center - 3.0).min() > 0.0
    with pytest.raises(InputError, match=r"\.stl, \.ply, \.obj"):
        write_surface(made, tmp_path / "s.dae")
    far = surface(region(ball, 12, scale=1e-3, at=1e5))
    with pytest.raises(InputError, match="32-bit"):
        write_surface(far, tmp_path / "far.stl")
    write_surface(far, tmp_path / "far.ply")


def test_what_has_no_surface_is_refused() -> None:
    with pytest.raises(InputError, match="three axes"):
        surface(region(ball, 12, axes=2))
    with pytest.raises(InputError, match="no cell"):
        surface(region(lambda x, y, z: x > 9.0, 6))
