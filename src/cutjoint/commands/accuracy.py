"""`cutjoint accuracy`: how far off the tool is, and what causes how much of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from cutjoint.commands import options
from cutjoint.commands.output import print_json, say, show
from cutjoint.commands.posed import At, Reach, posture_of
from cutjoint.commands.progress import progress
from cutjoint.errors import InputError
from cutjoint.tables import TextTable

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from cutjoint.accuracy import Accuracy, Growth, ToolPlay
    from cutjoint.accuracy.reading import Errors
    from cutjoint.arrays import Array
    from cutjoint.description import RobotDescription

SHOWN = 12
"""Most causes in the table."""


# long: its options, a line or three each
def command(
    robot: options.Robot,
    tolerance: Annotated[
        list[str] | None,
        typer.Option(
            "--tolerance",
            "-t",
            metavar="PATH=T",
            help="How far a number may be off, either way, such as 'cuts.*.b.z=0.1 mm', "
            "'tool.yaw=0.02 deg'; 'normal' behind it makes it a standard deviation.",
        ),
    ] = None,
    backlash: Annotated[
        list[str] | None,
        typer.Option(metavar="[NAME=]B", help="Half the play of an actuator, or of all, such as '1 arcmin', 2e-5."),
    ] = None,
    warm: Annotated[
        list[str] | None,
        typer.Option(
            metavar="[PART=]K", help="How much warmer a link, rod or sliding actuator is, or all, such as 'arm*=15'."
        ),
    ] = None,
    material: Annotated[
        list[str] | None,
        typer.Option(
            metavar="[PART=]NAME",
            help="Of what is warm: steel, stainless, aluminium, titanium, brass, invar, or a number [1/K].",
        ),
    ] = None,
    errors: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="All of these in a file (docs/accuracy.md).")
    ] = None,
    samples: Annotated[int, typer.Option(min=0, max=10_000_000, help="Robots drawn at random.")] = 100_000,
    seed: Annotated[int, typer.Option(min=0, help="Of the draws.")] = 0,
    exact: Annotated[
        bool, typer.Option("--exact", help="Close the loops anew for every sample, in compiled code.")
    ] = False,
    springs: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.toml", help="What gives where joints cannot follow (docs/stiffness.md); default all alike."
        ),
    ] = None,
    at: At = None,
    reach: Reach = None,
    variant: options.Variant = None,
    home: options.Home = None,
    lenient: options.Lenient = False,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="A picture: .png or .svg.")
    ] = None,
    json: options.Json = False,
) -> None:
    """How far off the tool is by tolerances of lengths and angles, backlash and warmth, ranked by cause.

    Actuators hold their coordinates. Paths are those of `docs/compile.md`, and actuators.NAME; they may be patterns.
    """
    from cutjoint.accuracy import accuracy, growth
    from cutjoint.accuracy import backlash as backlash_of
    from cutjoint.report.answers.sheet import check_picture, write_sheet
    from cutjoint.report.figures import plotting
    from cutjoint.robots import load
    from cutjoint.stiffness.reading import springs_from_file

    if output is not None:
        check_picture(output)
        plotting()
    chain = load(robot, variant, home, lenient=lenient)
    given = _errors(chain.description, tolerance, backlash, warm, material, errors)
    if given.empty:
        raise InputError("nothing is off; give --tolerance, --backlash or --warm, such as -t 'cuts.*.b.z=0.1 mm'")
    if output is not None and not given.tolerances:
        raise InputError("the picture is of tolerances; give some by --tolerance")
    if given.warm and not given.expansion:
        raise InputError("nobody says how what is warm expands; --material steel, or a number [1/K]")
    soft = None if springs is None else springs_from_file(springs, chain.description)
    where = posture_of(chain, at, reach)
    with progress(f"{chain.name}: accuracy"):
        budget = None
        if given.tolerances:
            budget = accuracy(chain, given.tolerances, where, samples=samples, seed=seed, exact=exact, springs=soft)
        loose = backlash_of(chain, given.backlash, where, soft) if given.backlash else None
        grown = growth(chain, given.warm, given.expansion, where, soft) if given.warm else None
    if json:
        print_json(_data(chain.name, budget, loose, grown))
    else:
        _show(budget, loose, grown)
    if output is not None and budget is not None:
        from cutjoint.report.answers.accuracy import draw_accuracy

        write_sheet(draw_accuracy(budget), output)
        if not json:
            say(f"wrote {output}")


def _errors(
    robot: RobotDescription,
    tolerance: Sequence[str] | None,
    backlash: Sequence[str] | None,
    warm: Sequence[str] | None,
    material: Sequence[str] | None,
    file: Path | None,
) -> Errors:
    from cutjoint.accuracy.reading import Errors, both, errors_from_file, errors_of
    from cutjoint.commands.options import assigned

    of_file = Errors() if file is None else errors_from_file(file, robot)

    def for_all(texts: Sequence[str] | None) -> list[str]:
        return [one if "=" in one else f"*={one}" for one in texts or ()]

    found = errors_of(
        robot,
        _tolerances(tolerance or ()),
        assigned("backlash", "--backlash NAME=B", for_all(backlash)),
        assigned("warmth", "--warm PART=K", for_all(warm)),
        assigned("a material", "--material PART=NAME", for_all(material)),
    )
    return both(of_file, found)


def _tolerances(texts: Sequence[str]) -> Mapping[str, str]:
    """Those that are given; paths that are joined by `=` have several."""
    from cutjoint.errors import shown

    found: dict[str, str] = {}
    for text in texts:
        path, sign, size = (part.strip() for part in text.rpartition("="))
        if not (sign and path and size):
            raise InputError(f"a tolerance is given as --tolerance PATH=T, found '{shown(text)}'")
        if path in found:
            raise InputError(f"a tolerance is given twice for '{shown(path)}'")
        found[path] = size
    return found


def _show(budget: Accuracy | None, loose: ToolPlay | None, grown: Growth | None) -> None:
    from cutjoint.units import handy

    rows: list[tuple[str, Array]] = []
    notes = []
    if budget is not None:
        rows += [("tolerances, standard deviation", budget.sigma), ("tolerances, worst case", budget.worst)]
        notes.append(_how(budget))
    if loose is not None:
        rows.append(("backlash, worst case", loose.box))
    if grown is not None:
        rows.append(("warmth", grown.shift))
    for which, unit, few in (
        ("error of the tool's place", "m", slice(0, 3)),
        ("error of its rotation, about", "rad", slice(3, 6)),
    ):
        _show_errors(which, unit, [(name, one[few]) for name, one in rows], notes if unit == "rad" else [])
    if budget is not None:
        _show_causes(budget)
    if grown is not None:
        _show_parts("warm parts", grown.names, grown.parts, [f"{one:.4g} K" for one in grown.warmth])
    if loose is not None:
        halves = []
        for half, kind in zip(loose.halves.tolist(), loose.units, strict=True):
            factor, shown = handy(half, kind)
            halves.append(f"{factor * half:.4g} {shown}")
        _show_parts("actuators with play", loose.actuators, loose.parts, halves)


def _show_errors(title: str, unit: str, rows: Sequence[tuple[str, Array]], notes: Sequence[str]) -> None:
    from cutjoint.units import handy

    factor, shown = handy(max((float(np.abs(one).max()) for _, one in rows), default=0.0), unit)
    axes = ("x", "y", "z")
    cells = [(name, *(_number(factor * x) for x in one)) for name, one in rows]
    columns = ("cause", *(f"{axis} [{shown}]" for axis in axes))
    show(TextTable(title, columns, cells, right=columns[1:], note="; ".join(notes)))


def _how(budget: Accuracy) -> str:
    """How the samples were drawn, and what the linear law leaves out."""

    from cutjoint.units import handy

    told = []
    if len(budget.errors):
        for percent in (95.0, 99.7):
            away, turned = budget.within(percent)
            (a, metres), (b, radians) = handy(away, "m"), handy(turned, "rad")
            told.append(f"{percent:g} % within {a * away:.4g} {metres} and {b * turned:.4g} {radians}")
        how = "loops closed anew" if budget.exact else "by the linear law"
        told.append(f"{len(budget.errors)} samples {how}")
    off, _ = budget.nonlinear
    if np.isfinite(off):
        factor, unit = handy(off, "m")
        told.append(f"the linear law is off by {factor * off:.2g} {unit} in three robots built anew")
    else:
        told.append("the linear law was not tried on robots built anew: their loops close only where joints give")
    return "; ".join(told)


def _show_causes(budget: Accuracy) -> None:
    from cutjoint.units import handy

    ranked = budget.ranked
    seen = ranked[:SHOWN]
    sizes = [float(np.linalg.norm(one.bound[:3])) for one in seen]
    factor, unit = handy(max(sizes), "m")
    turn, angle = handy(max(float(np.linalg.norm(one.bound[3:])) for one in seen), "rad")
    strained = any(one.strained for one in ranked)
    cells = []
    for one, size in zip(seen, sizes, strict=True):
        turned = float(np.linalg.norm(one.bound[3:]))
        row = [one.name, f"{100.0 * one.share:.2f}", _number(factor * size), _number(turn * turned)]
        if strained:
            row.append(one.strained or "-")
        cells.append(row)
    columns = ["number", "share [%]", f"moves [{unit}]", f"turns [{angle}]", *(["joint gives"] if strained else [])]
    left = len(ranked) - len(seen)
    notes = [f"{left} more have {100.0 * sum(one.share for one in ranked[SHOWN:]):.2g} %"] if left else []
    if strained:
        notes.append("where a joint gives, the loops are redundant: all joints give alike unless springs are stated")
    show(TextTable("causes, at the bound of each", columns, cells, right=columns[1:4], note="; ".join(notes)))


def _show_parts(title: str, names: Sequence[str], parts: Array, sizes: Sequence[str]) -> None:
    from cutjoint.units import handy

    factor, unit = handy(float(np.abs(parts[:3]).max(initial=0.0)), "m")
    cells = [
        (name, size, *(_number(factor * x) for x in column[:3]))
        for name, size, column in zip(names, sizes, parts.T, strict=True)
    ]
    columns = ("part", "size", f"x [{unit}]", f"y [{unit}]", f"z [{unit}]")
    show(TextTable(title, columns, cells, right=columns[1:]))


def _number(value: float) -> str:
    return "0" if abs(value) < 1e-9 else f"{value:.4g}"


def _data(name: str, budget: Accuracy | None, loose: ToolPlay | None, grown: Growth | None) -> dict[str, object]:
    found: dict[str, object] = {"robot": name}
    if budget is not None:
        finite = [None if np.isnan(one) else one for one in budget.nonlinear]
        found["tolerances"] = {
            "position": budget.position,
            "sigma": budget.sigma,
            "worst": budget.worst,
            "samples": len(budget.errors),
            "exact": budget.exact,
            "within": {f"{one:g}": budget.within(one) for one in (50.0, 95.0, 99.7)} if len(budget.errors) else {},
            "linear_law_is_off_by": finite,
            "causes": [
                {
                    "name": one.name,
                    "size": one.deviation.size,
                    "normal": one.deviation.normal,
                    "unit": one.unit,
                    "share": one.share,
                    "turning_share": one.turning_share,
                    "at_bound": one.bound,
                    "play": one.play,
                    "turn": one.turn,
                    "joint_gives": one.strained or None,
                }
                for one in budget.ranked
            ],
        }
    if loose is not None:
        found["backlash"] = {
            "actuators": loose.actuators,
            "halves": loose.halves,
            "parts": loose.parts.T,
            "box": loose.box,
            "furthest": loose.furthest,
        }
    if grown is not None:
        found["warmth"] = {
            "parts": grown.names,
            "warmth": grown.warmth,
            "expansion": grown.expansion,
            "moves": grown.parts.T,
            "shift": grown.shift,
        }
    return found
