"""Workspaces that are drawn instead of computed: balls, tori, boxes and random ones, of any size and anywhere."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.workspace import FieldMap, GridAxis, Workspace

Inside = Callable[..., np.ndarray]
NAMES = ("x", "y", "z")


def region(
    inside: Inside,
    cells: int | tuple[int, ...] = 24,
    *,
    axes: int = 3,
    scale: float = 1.0,
    at: Array | float = 0.0,
    reach: float = 1.1,
    extent: float | None = None,
    names: tuple[str, ...] = NAMES,
    ways: bool = False,
    robot: str = "drawn",
) -> Workspace:
    """A workspace of the points at which `inside`, a function of coordinates over -`reach` to `reach`, holds; then
    scaled and moved.  `extent` is that before scaling; `ways` whether it is known where they end between cells."""
    counts = (cells,) * axes if isinstance(cells, int) else cells
    plain = [np.linspace(-reach, reach, count) for count in counts]
    start = np.broadcast_to(np.asarray(at, dtype=float), len(counts))
    grid = tuple(
        GridAxis(name, "rad" if name.startswith("r") else "m", scale * one + low)
        for name, one, low in zip(names, plain, start, strict=False)
    )
    reached = np.asarray(inside(*np.meshgrid(*plain, indexing="ij")), dtype=bool)
    size = np.prod([one.step for one in grid]) * reached.sum() if extent is None else extent * scale ** len(counts)
    coordinates = np.stack(np.meshgrid(*plain, indexing="ij"), axis=-1)
    q = np.where(reached[..., None], coordinates, np.nan)
    quality = np.where(reached, 1.0 + (coordinates**2).sum(axis=-1), np.nan)
    maps = {
        "condition": FieldMap("condition number", "", quality, "low"),
        "speed": FieldMap("worst speed", "m/s", 1.0 / quality),
    }
    parts = _ways(inside, plain, reached) if ways else None
    return Workspace(robot, grid, {"rz": 0.25}, reached, float(size), q, maps, ("drawn", "not computed"), parts)


def _ways(inside: Inside, plain: list[Array], reached: np.ndarray) -> Array:
    """What part of the way from every cell to the next is inside, by halving."""
    found = []
    for axis, values in enumerate(plain):
        for step in (values[1] - values[0], values[0] - values[1]):
            low, high = np.zeros(reached.shape), np.ones(reached.shape)
            for _ in range(40):
                middle = 0.5 * (low + high)
                at = list(np.meshgrid(*plain, indexing="ij"))
                at[axis] = at[axis] + middle * step
                good = np.asarray(inside(*at), dtype=bool)
                low, high = np.where(good, middle, low), np.where(good, high, middle)
            found.append(np.where(reached, np.where(low > 1.0 - 1e-9, 1.0, low), 0.0))
    return readonly(np.array(found))


def ball(*x: Array) -> np.ndarray:
    """The points at most 1 from the origin."""
    return sum(one**2 for one in x) <= 1.0


def ring(*x: Array) -> np.ndarray:
    """A torus about z of radius 0.7 and thickness 0.6; over two axes an annulus."""
    return (np.hypot(x[0], x[1]) - 0.7) ** 2 + sum((one**2 for one in x[2:]), np.zeros(())) <= 0.3**2


def random_region(seed: int, axes: int, most: int = 9) -> Workspace:
    """A region of random cells, with a step of its own along every axis."""
    random = np.random.default_rng(seed)
    counts = tuple(random.integers(3, most, size=axes).tolist())
    filled = random.random(counts) < random.uniform(0.75, 0.97)
    filled[(slice(0, 2),) * axes] = True
    steps, scale = random.uniform(0.5, 2.0, size=axes), 10.0 ** random.uniform(-3, 3)
    made = region(lambda *x: filled, counts, scale=scale)
    grid = tuple(
        GridAxis(axis.name, axis.unit, scale * (random.normal() + step * np.arange(len(axis.values))))
        for axis, step in zip(made.axes, steps, strict=True)
    )
    size = float(np.prod([axis.step for axis in grid]) * filled.sum())
    return Workspace(made.robot, grid, made.held, made.inside, size, made.q, made.maps, made.told)
