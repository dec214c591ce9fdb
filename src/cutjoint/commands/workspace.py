"""`cutjoint workspace`: where the tool of a robot can be, and how well the robot does there."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint.commands import certified_box, options, workspace_files
from cutjoint.commands.output import print_json, say, show
from cutjoint.commands.progress import progress
from cutjoint.errors import InputError
from cutjoint.tables import TextTable

if TYPE_CHECKING:
    from cutjoint.mechanism import JointLimits, Mechanism
    from cutjoint.workspace import Workspace
    from cutjoint.workspace.filling import Told


class WorkingModes(StrEnum):
    """Of which working modes."""

    HOME = "home"
    ALL = "all"


class AssemblyModes(StrEnum):
    """Through type-2 singularities or not."""

    HOME = "home"
    ANY = "any"


# long: its options, a line or three each
def command(
    robot: options.Robot,
    variant: options.Variant = None,
    home: options.Home = None,
    lenient: options.Lenient = False,
    published: Annotated[
        bool, typer.Option("--published", help="Ask the robot's published model, which has no joint limits.")
    ] = False,
    axes: Annotated[
        str | None,
        typer.Option(metavar="NAMES", help="Coordinates of the grid, such as x,y,z or rx,ry; default the led places."),
    ] = None,
    within: Annotated[
        list[str] | None,
        typer.Option("--range", metavar="NAME=A:B", help="Range of one [m or rad]; default all that is reached."),
    ] = None,
    hold: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=V", help="Hold a coordinate there [m or rad]; the others are as at home."),
    ] = None,
    cells: Annotated[int | None, typer.Option(help="Cells along the longest axis; default 40.")] = None,
    maps: Annotated[
        str | None,
        typer.Option(
            "--map",
            metavar="NAMES",
            help="Maps over the cells: condition, isotropy, type1, type2, effort, "
            "speed, stiffness, bearing; separated by commas.",
        ),
    ] = None,
    modes: Annotated[WorkingModes, typer.Option(help="Of the working mode of home, or of all.")] = WorkingModes.HOME,
    assembly: Annotated[
        AssemblyModes, typer.Option(help="Of the assembly mode of home, or through type-2 singularities too.")
    ] = AssemblyModes.HOME,
    ignore_limits: Annotated[bool, typer.Option("--ignore-limits", help="Let joints go beyond their limits.")] = False,
    collisions: Annotated[
        bool, typer.Option("--collisions", help="Leave out postures in which links touch each other.")
    ] = False,
    reachable: Annotated[
        float | None, typer.Option(metavar="TILT", help="Where some orientation within TILT [rad] of home's is had.")
    ] = None,
    dextrous: Annotated[
        float | None, typer.Option(metavar="TILT", help="Where all orientations within TILT [rad] of home's are had.")
    ] = None,
    picture: workspace_files.Picture = None,
    through: workspace_files.Through = None,
    surface: workspace_files.SurfaceFile = None,
    save: workspace_files.Save = None,
    largest: workspace_files.Largest = None,
    margin: workspace_files.Margin = None,
    certify: certified_box.CertifyBox = None,
    certificate: certified_box.CertificatePicture = None,
    most: certified_box.MostBoxes = certified_box.MOST,
    seconds: certified_box.Seconds = None,
    json: options.Json = False,
) -> None:
    """Where the tool can be without a singularity between, and how well the robot does there.

    The cells of a grid over the task's coordinates are filled from home, cell by cell, within the limits of joints and
    on one working mode and one assembly mode; length, area or volume count the cells at the edge in part.  Coordinates
    that the grid is not over are held: turns as at home, so a robot of poses has a workspace of constant orientation.
    Maps are told by their least, middle and largest value over the cells.
    """
    names = None if axes is None else _names(axes)
    ranges, held = _ranges(within or []), _numbers("--hold", hold or [])
    chosen = _names(maps) if maps else ()
    tilts = {name: tilt for name, tilt in (("reachable", reachable), ("dextrous", dextrous)) if tilt is not None}
    _check_together(tilts, ranges, chosen, modes, published, collisions)
    kinds = _names(largest) if largest is not None else ()
    wanted = workspace_files.WantedFiles(picture, _numbers("--through", through or []), surface, save, kinds, margin)
    wanted.check(single=modes is WorkingModes.HOME)
    others = {"--axes": axes, "--cells": cells, "--range": within, "--map": maps, "--published": published}
    others |= {f"--{name}": True for name in tilts} | {"--collisions": collisions, "--ignore-limits": ignore_limits}
    others |= {"--modes all": modes is WorkingModes.ALL, "--assembly any": assembly is AssemblyModes.ANY}
    asked = certified_box.asked(certify, certificate, most, seconds, [name for name, one in others.items() if one])

    from cutjoint.robots import load
    from cutjoint.robots import published as published_model

    if asked is not None:
        certified_box.certify_box(load(robot, variant, home, lenient=lenient), asked, held, json=json)
        return
    limits: JointLimits = "ignore" if ignore_limits else "respect"
    model: Mechanism = published_model(robot) if published else load(robot, variant, home, lenient=lenient)
    with progress(f"{model.name}: workspace", None, "cells") as told:
        found = _found(model, names, ranges, held, cells, chosen, modes, assembly, limits, collisions, tilts, told)
    shapes = wanted.fitted(found[0])
    written = wanted.write(found[0], shapes)
    if json:
        data = [_data(one) for one in found]
        if shapes:
            data[0]["largest"] = workspace_files.shapes_data(shapes)
        print_json(data[0] if modes is WorkingModes.HOME else {"working_modes": data})
        return
    for number, one in enumerate(found, start=1):
        _show(one, f", working mode {number} of {len(found)}" if modes is WorkingModes.ALL else "")
    workspace_files.show_shapes(shapes)
    for sentence in written:
        say(sentence)


def _check_together(
    tilts: dict[str, float],
    ranges: dict[str, tuple[float, float]],
    maps: Sequence[str],
    modes: WorkingModes,
    published: bool,
    collisions: bool,
) -> None:
    """What cannot be asked for together is refused before the work."""
    if len(tilts) > 1:
        raise InputError("--reachable and --dextrous are two questions; ask one of them at a time")
    given = [("--range", bool(ranges)), ("--collisions", collisions)]
    kinds = [*(f"--{name}" for name in tilts), *(["--modes all"] if modes is WorkingModes.ALL else [])]
    if len(kinds) > 1:
        raise InputError(f"{kinds[0]} goes without {kinds[1]}")
    for kind in kinds:
        more = [("--published", published)] if kind == "--modes all" else [("--map", bool(maps))]
        for other, is_given in (*given, *more):
            if is_given:
                raise InputError(f"{kind} goes without {other}")


def _found(
    model: Mechanism,
    axes: tuple[str, ...] | None,
    ranges: dict[str, tuple[float, float]],
    held: dict[str, float],
    cells: int | None,
    maps: Sequence[str],
    modes: WorkingModes,
    assembly: AssemblyModes,
    limits: JointLimits,
    collisions: bool,
    tilts: dict[str, float],
    told: Told,
) -> tuple[Workspace, ...]:
    from cutjoint.chain import ClosedChain
    from cutjoint.workspace import orientation_workspace, workspace, workspaces
    from cutjoint.workspace.exploring import Assembly

    which: Assembly = "home" if assembly is AssemblyModes.HOME else "any"
    if modes is WorkingModes.ALL and isinstance(model, ClosedChain):
        return workspaces(model, axes=axes, held=held, cells=cells, assembly=which, limits=limits, maps=maps, told=told)
    for kind, tilt in tilts.items():
        return (
            orientation_workspace(
                model,
                "reachable" if kind == "reachable" else "dextrous",
                tilt,
                axes=axes,
                held=held,
                cells=cells,
                assembly=which,
                limits=limits,
                told=told,
            ),
        )
    return (
        workspace(
            model,
            axes=axes,
            region=ranges,
            held=held,
            cells=cells,
            assembly=which,
            limits=limits,
            maps=maps,
            collisions=collisions,
            told=told,
        ),
    )


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(","))


def _numbers(option: str, texts: Sequence[str]) -> dict[str, float]:
    found = options.assigned(option, "NAME=V", texts)
    return {name: _number(option, value) for name, value in found.items()}


def _ranges(texts: Sequence[str]) -> dict[str, tuple[float, float]]:
    found = {}
    for name, value in options.assigned("--range", "NAME=A:B", texts).items():
        low, sign, high = value.partition(":")
        if not sign:
            raise InputError(f"--range is given as NAME=A:B, found '{name}={value}'")
        found[name] = (_number("--range", low), _number("--range", high))
    return found


def _number(option: str, text: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise InputError(f"{option} needs numbers, found '{text}'") from error


def _show(found: Workspace, mode: str) -> None:
    import numpy as np

    points = found.points
    rows = [
        (axis.name, f"{low:.4g}", f"{high:.4g}", f"{axis.step:.3g}", axis.unit)
        for axis, low, high in zip(found.axes, points.min(axis=0), points.max(axis=0), strict=True)
    ]
    columns = ("coordinate", "least", "largest", "cell", "unit")
    show(TextTable(f"{found.robot}: workspace{mode}", columns, rows, right=columns[1:4]))
    kind = ("length", "area", "volume")[len(found.axes) - 1]
    say(f"{kind} {found.extent:.5g} {found.unit}, {int(found.inside.sum())} cells reached")
    if found.held:
        units = {"r": "rad"}
        say("held: " + ", ".join(f"{name} {value:.4g} {units.get(name[0], 'm')}" for name, value in found.held.items()))
    for sentence in found.told:
        say(sentence)
    if found.maps:
        lines = []
        for name, one in found.maps.items():
            low, middle, high = np.nanpercentile(one.values, [0, 50, 100])
            lines.append((name, f"{low:.4g}", f"{middle:.4g}", f"{high:.4g}", one.unit or "-"))
        heads = ("map", "least", "middle", "largest", "unit")
        show(TextTable("maps over the cells", heads, lines, right=heads[1:4]))


def _data(found: Workspace) -> dict[str, object]:
    import numpy as np

    points = found.points
    return {
        "robot": found.robot,
        "axes": [
            {
                "name": axis.name,
                "unit": axis.unit,
                "cells": len(axis.values),
                "step": axis.step,
                "least": low,
                "largest": high,
            }
            for axis, low, high in zip(found.axes, points.min(axis=0), points.max(axis=0), strict=True)
        ],
        "held": dict(found.held),
        "extent": found.extent,
        "extent_unit": found.unit,
        "cells_reached": int(found.inside.sum()),
        "maps": {
            name: {
                "title": one.title,
                "unit": one.unit,
                "best": one.best,
                "least": float(np.nanmin(one.values)),
                "middle": float(np.nanmedian(one.values)),
                "largest": float(np.nanmax(one.values)),
            }
            for name, one in found.maps.items()
        },
        "told": list(found.told),
    }
