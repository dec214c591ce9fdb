"""The largest box, cylinder and sphere in a workspace: inside, with their margin, and none is larger."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from kit.regions import ball, random_region, region, ring

from cutjoint.errors import InputError, UnknownNameError
from cutjoint.workspace import FittedShape, Workspace, largest
from cutjoint.workspace.grid_body import body_of
from cutjoint.workspace.largest_box import largest_box

KINDS = ("box", "cylinder", "sphere")


def seeds(quick: int, slow: int) -> list[object]:
    """Seeds of a family, of which the first ones are run each time."""
    return [*range(quick), *(pytest.param(one, marks=pytest.mark.slow) for one in range(quick, slow))]


def distance_to(shape: FittedShape, points: np.ndarray) -> np.ndarray:
    """From a fitted shape to points outside of it."""
    gaps = np.abs(points - shape.centre) - shape.breadths / 2.0
    if shape.kind == "box":
        return np.linalg.norm(np.maximum(gaps, 0.0), axis=1)
    round_ones = [name != shape.upright for name in shape.names]
    around = np.linalg.norm((points - shape.centre)[:, round_ones], axis=1) - shape.breadths[round_ones][0] / 2.0
    along = gaps[:, [not one for one in round_ones]]
    return np.linalg.norm(np.maximum(np.column_stack([around, along]), 0.0), axis=1)


def unknown(space: Workspace) -> np.ndarray:
    """Centres of cells that are not reached, those around the grid too."""
    axes = [np.concatenate([[v[0] - a.step], v, [v[-1] + a.step]]) for a in space.axes for v in [a.values]]
    every = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    return every[~np.pad(space.inside, 1)]


@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("seed", seeds(2, 12))
def test_no_box_of_full_blocks_is_larger(axes: int, seed: int) -> None:
    full = body_of(random_region(seed, axes, most=7)).full
    low, high = largest_box(full)
    assert full[tuple(slice(a, b) for a, b in zip(low, high, strict=True))].all()
    best = 0
    for ends in itertools.product(*(itertools.combinations(range(n + 1), 2) for n in full.shape)):
        if full[tuple(slice(*one) for one in ends)].all():
            best = max(best, math.prod(b - a for a, b in ends))
    assert math.prod(b - a for a, b in zip(low, high, strict=True)) == best


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", seeds(2, 40))
def test_shapes_are_inside_and_keep_their_margin(kind: str, seed: int) -> None:
    axes = 3 if kind == "cylinder" else 2 + seed % 2
    space = random_region(seed, axes)
    step = min(axis.step for axis in space.axes)
    for margin in (0.0, 0.3 * step):
        try:
            shape = largest(space, kind, margin=margin, upright="xyz"[seed % 3] if kind == "cylinder" else "")
        except InputError as error:
            assert margin > 0.0 or "two cells" in str(error)  # noqa: PT017
            continue
        assert distance_to(shape, unknown(space)).min() >= margin - 1e-9 * step
        assert (shape.low >= [axis.values[0] + margin - 1e-9 * step for axis in space.axes]).all()
        assert (shape.high <= [axis.values[-1] - margin + 1e-9 * step for axis in space.axes]).all()
        corners = np.array(list(itertools.product(*zip(shape.low, shape.high, strict=True))))
        assert shape.holds(corners).all() == (kind == "box")
        assert shape.holds(shape.centre[None]).all()


@pytest.mark.parametrize("seed", seeds(1, 12))
def test_shapes_of_a_ball_are_those_of_geometry(seed: int) -> None:
    random = np.random.default_rng(seed)
    scale, at = 10.0 ** random.uniform(-3, 3), random.normal(size=3)
    space = region(
        ball, tuple(random.integers(17, 22 if seed == 0 else 42, size=3).tolist()), scale=scale, at=at * scale
    )
    step = max(axis.step for axis in space.axes)
    for margin in (0.0, 0.2 * scale):
        r = scale - margin
        wanted = {
            "sphere": 4.0 / 3.0 * math.pi * r**3,
            "box": (2.0 * r / math.sqrt(3.0)) ** 3,
            "cylinder": 4.0 * math.pi / 3.0**1.5 * r**3,
        }
        for kind, most in wanted.items():
            shape = largest(space, kind, margin=margin)
            # a box grown by a margin has round corners, so that it is a little larger than in a smaller ball
            assert shape.extent <= most * (1.0 + 1e-9) or (margin > 0.0 and kind != "sphere")
            assert shape.extent >= most * (1.0 - 2.0 * step / r) ** 3
            assert np.abs(shape.centre - at * scale).max() < 1.5 * step


def test_shapes_of_a_ring_are_those_of_geometry() -> None:
    space = region(ring, (31, 31, 15))
    step = max(axis.step for axis in space.axes)
    sphere = largest(space, "sphere")
    assert 0.3 - 2.0 * step < sphere.radius <= 0.3 + step**2 / 0.3
    assert math.hypot(*sphere.centre[:2]) == pytest.approx(0.7, abs=step)
    disc = largest(region(ring, 60, axes=2), "sphere")
    assert 0.25 < disc.radius <= 0.301
    assert disc.extent == pytest.approx(math.pi * disc.radius**2)
    flat = largest(region(lambda x, y: (np.abs(x) < 0.8) & (np.abs(y) < 0.31), 81, axes=2), "box")
    assert flat.breadths == pytest.approx([1.6, 0.62], abs=0.06)
    assert flat.radius is None


def test_a_margin_only_takes_away_from_a_box() -> None:
    space = region(lambda x, y, z: (np.abs(x) < 0.9) & (np.abs(y) < 0.5) & (np.abs(z) < 0.7), (23, 21, 25))
    plain = largest(space, "box")
    for margin in (0.03, 0.1, 0.17, 0.3):
        assert largest(space, "box", margin=margin).breadths == pytest.approx(plain.breadths - 2.0 * margin)
    stands = largest(space, "cylinder", upright="y")
    assert stands.breadths[1] == pytest.approx(plain.breadths[1])
    assert stands.breadths[0] == stands.breadths[2] == 2.0 * stands.radius


def test_large_grids_are_searched_by_groups(monkeypatch: pytest.MonkeyPatch) -> None:
    full = body_of(region(ball, 20)).full
    low, high = largest_box(full)
    monkeypatch.setattr("cutjoint.workspace.largest_box.MOST_WORK", 50_000)
    coarse_low, coarse_high = largest_box(full)
    assert full[tuple(slice(a, b) for a, b in zip(coarse_low, coarse_high, strict=True))].all()
    assert np.prod(np.subtract(coarse_high, coarse_low)) < np.prod(np.subtract(high, low))
    space = region(ball, 20)
    grown = largest(space, "box")  # to the ends of the fine grid
    assert grown.extent > 0.8 * np.prod(np.subtract(high, low) * [axis.step for axis in space.axes])


def test_what_does_not_fit_is_refused() -> None:
    space = region(ball, 12)
    turning = region(ball, 12, names=("x", "y", "rz"))
    assert largest(turning, "box").units == ("m", "m", "rad")
    assert largest(turning, "cylinder").upright == "rz"
    for wrong, error, told in (
        (lambda: largest(space, "cone"), UnknownNameError, "cone"),
        (lambda: largest(space, "cylinder", upright="w"), UnknownNameError, "w"),
        (lambda: largest(space, "box", margin=-1.0), InputError, "0 or more"),
        (lambda: largest(space, "box", margin=math.nan), InputError, "0 or more"),
        (lambda: largest(space, "sphere", margin=1.0), InputError, "take a smaller margin"),
        (lambda: largest(space, "box", margin=1.0), InputError, "take a smaller margin"),
        (lambda: largest(turning, "sphere"), InputError, "not round"),
        (lambda: largest(turning, "cylinder", upright="x"), InputError, "not round"),
        (lambda: largest(turning, "box", margin=0.1), InputError, "margin is a distance"),
        (lambda: largest(region(ball, 12, axes=2), "cylinder"), InputError, "three axes"),
        (lambda: largest(region(lambda x, y, z: z == z.flat[0], 5), "box"), InputError, "more cells"),
    ):
        with pytest.raises(error, match=told):
            wrong()
