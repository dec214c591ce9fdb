"""What `cutjoint workspace` makes of a workspace: pictures, files, and the largest shapes in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint import interrupts
from cutjoint.commands.output import say, show
from cutjoint.commands.progress import progress
from cutjoint.errors import InputError
from cutjoint.tables import TextTable

if TYPE_CHECKING:
    from cutjoint.workspace import FittedShape, Workspace

Picture = Annotated[
    Path | None,
    typer.Option(
        "--output", "-o", metavar="FILE", help="Draw it: a .png or .svg with slices, coloured by the first map."
    ),
]
Through = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME=V", help="Where the slices of the picture are [m or rad]; default its deepest place."),
]
SurfaceFile = Annotated[
    Path | None, typer.Option("--surface", metavar="FILE", help="Write its boundary: a .stl, .ply or .obj.")
]
Save = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Write it: .npz (for `cutjoint view --workspace`), .vti (ParaView) or .parquet (a row a cell).",
    ),
]
Largest = Annotated[
    str | None, typer.Option(metavar="KINDS", help="Fit the largest box, cylinder or sphere; separated by commas.")
]
Margin = Annotated[
    float | None, typer.Option(metavar="M", help="Least distance of these from the boundary [m or rad]; default 0.")
]


@dataclass(frozen=True)
class WantedFiles:
    """What is asked for.

    Attributes:
        picture: where it is drawn.
        through: where the slices of the picture are.
        surface: where its boundary is written.
        save: where it is written.
        kinds: of shapes to fit.
        margin: that they keep.
    """

    picture: Path | None
    through: Mapping[str, float]
    surface: Path | None
    save: Path | None
    kinds: tuple[str, ...]
    margin: float | None

    def check(self, *, single: bool) -> None:
        """Look at all of it before the work.

        Raises:
            InputError: a place that cannot be written, a suffix that is none, or things that do not go together.
            UnknownNameError: no such shape.
            MissingPackageError: what it needs is not installed.
        """
        from cutjoint.extras import needed
        from cutjoint.report.answers.sheet import check_picture
        from cutjoint.workspace.files import check_target
        from cutjoint.workspace.fitting import check_kinds
        from cutjoint.workspace.surface import check_surface

        asked = {"-o": self.picture, "--surface": self.surface, "--save": self.save, "--largest": self.kinds}
        if not single and (given := [name for name, one in asked.items() if one]):
            raise InputError(f"--modes all goes without {given[0]}: ask of one working mode, by --home")
        if self.margin is not None and not self.kinds:
            raise InputError("--margin is that of fitted shapes; say which by --largest box,cylinder,sphere")
        if self.through and self.picture is None:
            raise InputError("--through says where the slices of a picture are; say where it is written by -o FILE")
        check_kinds(self.kinds, self.margin or 0.0)
        if self.picture is not None:
            check_picture(self.picture)
            needed("matplotlib", "a picture")
        if self.surface is not None:
            check_surface(self.surface)
            needed("skimage", "the surface of a workspace")
        if self.save is not None:
            check_target(self.save)

    def fitted(self, space: Workspace) -> tuple[FittedShape, ...]:
        """The shapes that are asked for.

        Raises:
            InputError: one does not fit.
        """
        from cutjoint.workspace import largest

        if not self.kinds:
            return ()
        with progress(f"{space.robot}: largest {', '.join(self.kinds)}"):
            return tuple(largest(space, kind, margin=self.margin or 0.0) for kind in self.kinds)

    def write(self, space: Workspace, shapes: Sequence[FittedShape]) -> list[str]:
        """Write all that is asked for; what was written, in sentences.

        Raises:
            InputError: something cannot be drawn or written.
        """
        from cutjoint.report.answers.sheet import write_sheet
        from cutjoint.report.answers.workspace import workspace_picture
        from cutjoint.workspace import save, surface, write_surface

        told = []
        with interrupts.keeping():
            if self.save is not None:
                told.append(f"wrote {save(space, self.save)}")
            if self.surface is not None:
                made = surface(space)
                write_surface(made, self.surface)
                told.append(f"wrote {self.surface}: {len(made.faces)} triangles around {made.volume:.5g} {made.unit}")
            if self.picture is not None:
                write_sheet(workspace_picture(space, through=self.through or None, shapes=shapes), self.picture)
                told.append(f"wrote {self.picture}")
        return told


def show_shapes(shapes: Sequence[FittedShape]) -> None:
    """Tell of fitted shapes."""
    from cutjoint.workspace.region import volume_unit

    for shape in shapes:
        columns = ("coordinate", "from", "to", "breadth", "unit")
        rows = [
            (name, f"{low:.5g}", f"{high:.5g}", f"{breadth:.5g}", unit)
            for name, low, high, breadth, unit in zip(
                shape.names, shape.low, shape.high, shape.breadths, shape.units, strict=True
            )
        ]
        margin = f", margin {shape.margin:.4g} {shape.units[0]}" if shape.margin else ""
        extent = f"{shape.extent:.5g} {volume_unit(shape.units)}"
        show(TextTable(f"largest {shape.word}: {extent}{margin}", columns, rows, right=columns[1:4]))
    if shapes:
        steps = ", ".join(f"{one:.3g} {unit}" for one, unit in zip(shapes[0].steps, shapes[0].units, strict=True))
        say(f"inside as far as the cells of {steps} tell; more --cells tell more")


def shapes_data(shapes: Sequence[FittedShape]) -> list[dict[str, object]]:
    """Fitted shapes for JSON."""
    return [
        {
            "kind": shape.kind,
            "word": shape.word,
            "axes": shape.names,
            "units": shape.units,
            "centre": shape.centre,
            "breadths": shape.breadths,
            "radius": shape.radius,
            "upright": shape.upright,
            "extent": shape.extent,
            "margin": shape.margin,
            "steps": shape.steps,
        }
        for shape in shapes
    ]
