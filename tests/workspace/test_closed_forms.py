"""Workspaces of cranks and rods, drawn in random shapes, against closed forms that are written here anew.

A limb is a crank of radius r at a foot, and a rod of length l to a point of the plate; d leads from the foot to that
point.  The crank's end e obeys d . e = (d . d + r^2 - l^2) / 2 (see `oracles.closed_form`), which has two solutions,
one where they meet (type 1), none beyond.  The plate can move with the cranks at rest (type 2) where the rods' lines of
force are linearly dependent: the determinant of their directions, for a plate that turns with their moments.

The plate of a Delta, on pairs of rods l at the ends of sides s, also turns where det (s_k x l_k) vanishes, as the six
lines fall into these two parts.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from kit.blueprint import random_rotation
from kit.led import LENGTH, stand
from kit.led_robots import drawn
from kit.sized import Size
from oracles.closed_form import Cranks, rotation_of
from scipy.ndimage import label

from cutjoint.workspace import Workspace, workspace

Array = np.ndarray
AXES = {"fivebar": "xy", "planar_3rrr": "xy", "delta": "xyz"}
FINE = {2: 500, 3: 110}
"""Cells of the closed form's own grid."""
CLOSE = 0.01
Z = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Truth:
    """A robot of cranks, its plate turned by a fixed `turn` about z."""

    form: Cranks
    turn: float = 0.0

    def __call__(self, at: Array) -> Array:
        """Least determinant of the rods' lines with the tool at `at` (..., 2 or 3), positive at home, NaN out of
        reach."""
        here = self._determinants(at)
        home = self._determinants(self.form.centre[None, : at.shape[-1]])
        return np.asarray((here * np.sign(home[0])).min(axis=-1))

    def _determinants(self, at: Array) -> Array:
        """Those that must keep their signs, shape (..., 1 or 2)."""
        form, place = self.form, np.zeros((*at.shape[:-1], 3))
        place[...] = form.centre
        place[..., : at.shape[-1]] = at
        arms = form.tops @ rotation_of(np.array([0.0, 0.0, self.turn])).T
        lines, moments = [], []
        for k in range(len(form.feet)):
            d, r = place + arms[k] - form.feet[k], form.radii[k]
            a, b = d @ form.u[k], d @ form.v[k]
            c = ((d * d).sum(-1) + r**2 - form.rods[k] ** 2) / (2.0 * r)
            size = np.hypot(a, b)
            with np.errstate(invalid="ignore"):
                bent = np.arccos(np.where(np.abs(c) < size, c / size, np.nan))
            angle = np.arctan2(b, a) + form.elbows[k] * bent
            rod = d - r * (np.cos(angle)[..., None] * form.u[k] + np.sin(angle)[..., None] * form.v[k])
            rod = rod / form.rods[k]
            if at.shape[-1] == 3:
                lines.append(rod)
                moments.append(np.cross(np.cross(Z, form.u[k]), rod))
            elif len(form.feet) == 3:
                moment = (arms[k][0] * rod[..., 1] - arms[k][1] * rod[..., 0]) / LENGTH
                lines.append(np.stack([rod[..., 0], rod[..., 1], moment], axis=-1))
            else:
                lines.append(rod[..., :2])
        with np.errstate(invalid="ignore"):
            return np.stack([np.linalg.det(np.stack(one, axis=-2)) for one in (lines, moments) if one], axis=-1)

    def extent(self, low: Array, high: Array) -> float:
        """Of what is joined with home between corners."""
        count = FINE[len(low)]
        axes = [a + (np.arange(count) + 0.5) * (b - a) / count for a, b in zip(low, high, strict=True)]
        good = np.nan_to_num(self(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1))) > 0.0
        parts, _ = label(good)
        place = [int((x - a) / (b - a) * count) for x, a, b in zip(self.form.centre, low, high, strict=False)]
        return float((parts == parts[tuple(place)]).mean() * np.prod(high - low))


def corners(found: Workspace) -> tuple[Array, Array]:
    ends = np.array([(one.values[0] - one.step, one.values[-1] + one.step) for one in found.axes])
    return ends[:, 0], ends[:, 1]


def ends_of(found: Workspace) -> tuple[Array, Array]:
    """Where ways out of reached cells end, and the directions out, both (N, axes)."""
    assert found.ways is not None
    points, directions = [], []
    for way in range(2 * len(found.axes)):
        axis, back = divmod(way, 2)
        step = found.axes[axis].step * (-1.0 if back else 1.0)
        ended = np.argwhere(found.inside & (found.ways[way] < 1.0))
        at = np.stack([one.values[k] for one, k in zip(found.axes, ended.T, strict=True)], axis=-1)
        at[:, axis] += step * found.ways[way][tuple(ended.T)]
        points.append(at)
        directions.append(np.tile(np.sign(step) * np.eye(len(found.axes))[axis], (len(at), 1)))
    return np.concatenate(points), np.concatenate(directions)


FAMILY = [("fivebar", seed, 0.0) for seed in range(8)]
FAMILY += [("planar_3rrr", seed, turn) for seed in range(4) for turn in (0.0, 0.4)]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seed", "turn"), FAMILY)
def test_boundaries_and_singular_surfaces(name: str, seed: int, turn: float, tmp_path: Path) -> None:
    led = drawn(name, seed)
    assert isinstance(led.form, Cranks)
    robot, truth = stand(led, tmp_path).chain, Truth(led.form, turn)
    axes, held = tuple(AXES[name]), {"rz": turn} if name == "planar_3rrr" else {}
    found = workspace(robot, axes=axes, held=held)
    assert found.extent == pytest.approx(truth.extent(*corners(found)), rel=CLOSE)
    # every boundary point is where the closed form has one: reach (no number) or a type-2 singularity (another sign)
    points, out = ends_of(found)
    near = CLOSE * max(np.ptp(one.values) for one in found.axes)
    within, beyond = truth(points - near * out), truth(points + near * out)
    good = (np.nan_to_num(within) > 0.0) & ~(np.nan_to_num(beyond) > 0.0)
    # where a way only grazes the boundary it is out again within that distance
    assert good.mean() > 0.97
    # the zero set of the map of distances to type-2 singularities, through which this one goes
    both = workspace(robot, axes=axes, held=held, assembly="any", maps=["type2"], cells=40 if len(axes) == 2 else 20)
    centres = np.stack(np.meshgrid(*(one.values for one in both.axes), indexing="ij"), axis=-1)
    sides, values, missed = truth(centres), both.maps["type2"].values, list[float]()
    reach = max(np.ptp(one.values) for one in both.axes)
    for axis, one in enumerate(both.axes):
        count = np.arange(sides.shape[axis])
        signs = np.where(both.inside, sides, np.nan)
        across = np.argwhere(signs.take(count[:-1], axis) * signs.take(count[1:], axis) < 0.0)
        for at in across:
            low, high = tuple(at), tuple(at + np.eye(len(at), dtype=int)[axis])
            way = np.linspace(centres[low], centres[high], 65)
            way_signs = np.sign(truth(way))
            changes = np.flatnonzero(way_signs[1:] != way_signs[:-1])
            if len(changes) == 1:
                mapped = values[low] / (values[low] + values[high])
                missed.append(abs(mapped - (changes[0] + 0.5) / 64.0) * one.step / reach)
    assert len(missed) > 5
    assert np.median(missed) < 0.25 * CLOSE
    assert np.quantile(missed, 0.95) < CLOSE


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", ["fivebar"])
def test_any_size_and_mounting(name: str, seed: int, tmp_path: Path) -> None:
    """The same extent where the robot is a millimetre or a hundred metres long, hangs askew and stands elsewhere."""
    led, rng = drawn(name, 10 + seed), np.random.default_rng(seed)
    assert isinstance(led.form, Cranks)
    length = 10.0 ** rng.uniform(-3.0, 2.0)
    size = Size(length=length, rotation=random_rotation(rng), offset=length * rng.normal(size=3))
    dimension = len(AXES[name])
    found = workspace(stand(led, tmp_path, size).chain, cells=40 if dimension == 2 else 30)
    middle = led.form.centre[:dimension]
    reach = float((led.form.radii + led.form.rods).max() + np.abs(led.form.feet).max())
    low, high = -reach - 0.2 * np.ones(dimension), reach + 0.2 * np.ones(dimension)
    assert ((low < middle) & (middle < high)).all()
    assert found.extent / length**dimension == pytest.approx(Truth(led.form).extent(low, high), rel=0.015)
