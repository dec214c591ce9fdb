"""Places beside a robot: a cloud of points and a translucent surface in its scene, such as those of a workspace.

Points with values are coloured by `viridis` (S. van der Walt, N. Smith: matplotlib 1.5, 2015), which everybody can read
and which survives in grey, from dark for the worst to yellow for the best.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from meshcat import geometry as g

from cutjoint.arrays import Array, Frozen
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.reprs import one_line
from cutjoint.viewer.picture.figure import ROOT, WORKSPACE, Figure

PLAIN = f"#{WORKSPACE:06x}"
SCALE = ("#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725")
"""From dark to yellow, evenly."""
FILM, THIN_FILM = 0.3, 0.1
"""Opacity of the surface, without and with points in it."""
DOT = 0.022
"""Size of a point, in half the extent of what is seen."""
BOTH_SIDES = 2
ODD = 2.0
"""Percent of the worst points that may have the colour of the end, such as those beside a singularity."""


def _no_rows() -> Array:
    return np.zeros((0, 3))


def _no_values() -> Array:
    return np.zeros(0)


@door
@dataclass(frozen=True, eq=False)
class Places(Frozen):
    """Points and triangles in the world.

    Attributes:
        title: what they are, under which they are shown and hidden.
        points: shape (count, 3) [m]; may be none.
        values: of the points, for their colours, shape (count,); none where all have one colour.
        quantity: what the values are, with its unit.
        low_is_good: whether the lowest values are the best ones.
        vertices: of the triangles, shape (count, 3) [m]; may be none.
        faces: three vertices a triangle, shape (triangles, 3).

    Raises:
        InputError: shapes that do not fit, numbers that are not finite, or faces of vertices that are not there.
    """

    title: str
    points: Array = field(default_factory=_no_rows)
    values: Array = field(default_factory=_no_values)
    quantity: str = ""
    low_is_good: bool = False
    vertices: Array = field(default_factory=_no_rows)
    faces: Array = field(default_factory=_no_rows)

    def __repr__(self) -> str:
        return one_line("Places", [self.title, f"{len(self.points)} points [m]", f"{len(self.faces)} triangles"])

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("points", "vertices", "faces"):
            value = getattr(self, name)
            if value.ndim != 2 or value.shape[1] != 3 or not np.isfinite(value).all():
                raise InputError(f"{name} of '{self.title}' must be finite, shape (count, 3), found {value.shape}")
        if self.values.ndim != 1 or len(self.values) not in (0, len(self.points)):
            raise InputError(f"'{self.title}' has {len(self.points)} points and values of shape {self.values.shape}")
        if not np.isfinite(self.values).all():
            raise InputError(f"values of '{self.title}' must be finite")
        whole = np.asarray(self.faces == np.floor(self.faces)).all()
        if not whole or (self.faces < 0).any() or (self.faces >= len(self.vertices)).any():
            raise InputError(f"faces of '{self.title}' must be numbers of its {len(self.vertices)} vertices")

    @property
    def all_points(self) -> Array:
        """The points and the vertices, shape (count, 3) [m]."""
        return np.concatenate([self.points, self.vertices])

    @property
    def ends(self) -> tuple[float, float]:
        """The values that are dark and yellow: the worst but for a few, and the best."""
        worst, best = (100.0 - ODD, self.values.min()) if self.low_is_good else (ODD, self.values.max())
        return float(np.percentile(self.values, worst)), float(best)


def show_places(figure: Figure, places: Places) -> None:
    """Put them into the scene of a figure, under toggles of their own."""
    at = f"{ROOT}/places"
    with figure.scene.batch():
        if len(places.points):
            # both packed in columns, which is how the page reads them
            points, colours = places.points.T.astype(np.float32), _colours(places).T.astype(np.float32)
            figure.scene.set_object(f"{at}/cloud", g.PointCloud(points, colours, size=DOT))
            alone = len(places.values) > 0 or not len(
                places.faces
            )  # what has one colour tells no more than its surface
            figure.toggle(f"{places.title}: points{_told(places)}", [f"{at}/cloud"], alone)
        if len(places.faces):
            opacity = THIN_FILM if len(places.values) else FILM
            film = g.MeshPhongMaterial(
                color=WORKSPACE, opacity=opacity, transparent=True, side=BOTH_SIDES, depthWrite=False
            )
            mesh = g.TriangularMeshGeometry(places.vertices, places.faces.astype(np.uint32))
            figure.scene.set_object(f"{at}/surface", g.Mesh(mesh, film))
            figure.toggle(f"{places.title}: surface", [f"{at}/surface"], True)


def legend_of(places: Places) -> list[dict[str, str | bool]]:
    """Rows of a page's legend: what is shown, and the ends of the scale of colours."""
    if not len(places.values):
        return [{"text": places.title, "colour": PLAIN}]
    return [
        {"text": f"{places.quantity or places.title}: {value:.3g}", "colour": colour}
        for value, colour in zip(places.ends, (SCALE[0], SCALE[-1]), strict=True)
    ]


def _told(places: Places) -> str:
    if not len(places.values):
        return ""
    dark, yellow = places.ends
    return f", {places.quantity} {dark:.3g} (dark) to {yellow:.3g} (yellow)"


def _colours(places: Places) -> Array:
    """Red, green and blue from 0 to 1 of every point, shape (count, 3)."""
    if not len(places.values):
        return np.tile(_rgb(PLAIN), (len(places.points), 1))
    dark, yellow = places.ends
    part = np.clip((places.values - dark) / (yellow - dark), 0.0, 1.0) if yellow != dark else 1.0 + 0.0 * places.values
    scale = np.array([_rgb(one) for one in SCALE])
    return np.stack([np.interp(part * (len(SCALE) - 1), np.arange(len(SCALE)), channel) for channel in scale.T], axis=1)


def _rgb(colour: str) -> npt.NDArray[np.float64]:
    return np.array([int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)])
