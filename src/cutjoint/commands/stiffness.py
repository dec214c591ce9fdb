"""`cutjoint stiffness`: how far the tool gives way, and which parts that is due to."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from cutjoint.commands import completing, options
from cutjoint.commands.loads import loads_of
from cutjoint.commands.output import print_json, say, show
from cutjoint.commands.posed import At, Reach, posture_of
from cutjoint.commands.progress import progress
from cutjoint.errors import InputError
from cutjoint.tables import TextTable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from cutjoint.arrays import Array
    from cutjoint.chain import ClosedChain
    from cutjoint.mechanism import Load, Posture
    from cutjoint.stiffness import ElasticRobot, PushedTool, Springs, ToolStiffness

SHOWN = 12
"""Most parts in the table."""


# long: its options, a line or three each
def command(
    robot: options.Robot,
    actuator: Annotated[
        list[str] | None,
        typer.Option(
            metavar="[NAME=]K",
            help="Stiffness of an actuator, or of all, such as 1e5, 'arm*=3e4 N m/rad'; [N/m] or [N m/rad].",
        ),
    ] = None,
    joint: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME[.DIR]=K",
            help="Of a joint or cut, all directions or x, y, z [N/m], rx, ry, rz [N m/rad], such as 'ball*=50 N/um'.",
        ),
    ] = None,
    rod: Annotated[
        list[str] | None,
        typer.Option(metavar="LINK=K", help="E A / L of a rod along its axis [N/m], such as 'rod*=20 N/um'."),
    ] = None,
    springs: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="All of these in a file, and beams (docs/stiffness.md).")
    ] = None,
    load: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LINK:FX,FY,FZ[,MX,MY,MZ]",
            help="Deflection by this force [N] and moment [N m], such as tool:0,0,-10; may be repeated; default 1 N at "
            "the tool along the softest direction.",
        ),
    ] = None,
    preload: Annotated[
        list[str] | None,
        typer.Option(metavar="LINK:FX,FY,FZ[,MX,MY,MZ]", help="Standing load besides the weight; may be repeated."),
    ] = None,
    at: At = None,
    reach: Reach = None,
    trajectory: Annotated[
        str | None,
        typer.Option(
            metavar="SPEC", help="Along a motion, as of `cutjoint simulate`.", autocompletion=completing.trajectories
        ),
    ] = None,
    samples: Annotated[int, typer.Option(min=2, max=100_000, help="Instants of the motion.")] = 50,
    variant: options.Variant = None,
    home: options.Home = None,
    lenient: options.Lenient = False,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="A picture: .png or .svg.")
    ] = None,
    json: options.Json = False,
) -> None:
    """How stiff a robot is at its tool: springs at actuators, in joints and along rods, under its weight.

    What is not named is rigid. Names may be patterns: 'leg*', 'ball?a.z'. The parts that give way most come first.
    """
    from cutjoint.report.answers.sheet import check_picture, write_sheet
    from cutjoint.report.figures import plotting
    from cutjoint.robots import load as load_robot
    from cutjoint.stiffness import ElasticRobot, PushedTool

    if output is not None:
        check_picture(output)
        plotting()
    further, standing = loads_of(load or []), loads_of(preload or [])
    chain = load_robot(robot, variant, home, lenient=lenient)
    elastic = ElasticRobot(chain, _springs(chain, actuator, joint, rod, springs))
    if trajectory is not None:
        if at is not None or reach is not None or load:
            raise InputError("--trajectory looks along a motion; it takes no --at, --reach or --load")
        times, found = _along(chain, elastic, trajectory, samples, standing)
        _show_course(times, found, json)
        if output is not None:
            from cutjoint.report.answers.stiffness import draw_course

            write_sheet(draw_course(times, found), output)
    else:
        where = posture_of(chain, at, reach)
        one = elastic.at(where, standing)
        push = _wrench(further, one)
        if push is None:
            title = " and ".join(f"load {text}" for text in load or ())
            elsewhere = title, elastic.pushed(further, where, standing)
        else:
            title = _at_the_tool(push)
            elsewhere = title, PushedTool(one.deflection(push), one.contributions(push))
        _show(one, push, *elsewhere, json=json)
        if output is not None:
            from cutjoint.report.answers.stiffness import draw_stiffness

            write_sheet(draw_stiffness(one, elsewhere), output)
    if output is not None and not json:
        say(f"wrote {output}")


def _wrench(loads: Sequence[Load], found: ToolStiffness) -> Array | None:
    """The small load at the tool, shape (6,), which is 1 N along the softest direction where there are none; None where
    loads are elsewhere too."""
    if not loads:
        return np.append(_tidy(found.translation.axes[:, 0]), np.zeros(3))
    if any(one.link is not None for one in loads):
        return None
    return np.concatenate([sum(one.force for one in loads), sum(one.moment for one in loads)])


def _springs(
    chain: ClosedChain,
    actuator: Sequence[str] | None,
    joint: Sequence[str] | None,
    rod: Sequence[str] | None,
    file: Path | None,
) -> Springs:
    from cutjoint.commands.options import assigned
    from cutjoint.stiffness import Springs
    from cutjoint.stiffness.reading import both, springs_from_file, springs_of

    robot = chain.description
    of_file = Springs() if file is None else springs_from_file(file, robot)
    named = [one if "=" in one else f"*={one}" for one in actuator or ()]
    found = springs_of(
        robot,
        assigned("the stiffness of an actuator", "--actuator NAME=K", named),
        assigned("the stiffness of a joint", "--joint NAME=K", joint or ()),
        assigned("the stiffness of a rod", "--rod LINK=K", rod or ()),
    )
    return both(of_file, found)


def _along(
    chain: ClosedChain, elastic: ElasticRobot, spec: str, samples: int, loads: Sequence[Load]
) -> tuple[Array, list[ToolStiffness]]:
    from cutjoint.commands.options import trajectory_of
    from cutjoint.motion import Reference

    reference = Reference(trajectory_of(chain, spec), chain)
    times, found = np.linspace(0.0, reference.duration, samples), list["ToolStiffness"]()
    with progress(f"{chain.name}: stiffness", samples, "instants") as done:
        for number, time in enumerate(times.tolist(), start=1):
            where: Posture = reference.at(time).posture
            found.append(elastic.at(where, loads))
            done(number)
    return times, found


def _at_the_tool(wrench: Array) -> str:
    from cutjoint.stiffness.telling import told

    turn = f" and moment ({told(wrench[3:].tolist())}) N m" if wrench[3:].any() else ""
    return f"force ({told(wrench[:3].tolist())}) N{turn}"


def _show(found: ToolStiffness, wrench: Array | None, title: str, pushed: PushedTool, *, json: bool) -> None:
    """One posture: principal stiffness, deflection, parts."""

    from cutjoint.stiffness.telling import told

    moved, parts = pushed.deflection, pushed.parts
    if json:
        print_json(
            {
                "robot": found.robot,
                "position": found.position,
                "compliance": found.compliance,
                "stable": found.stable,
                "stiffness_against_forces": {
                    "values": _finite(found.translation.stiffness),
                    "axes": found.translation.axes.T,
                },
                "stiffness_against_moments": {
                    "values": _finite(found.rotation.stiffness),
                    "axes": found.rotation.axes.T,
                },
                "load": title,
                "wrench": wrench,
                "deflection": moved,
                "parts": [
                    {"name": one.name, "kind": one.kind, "share": one.share, "deflection": one.deflection}
                    for one in parts
                ],
            }
        )
        return
    rows = []
    for what, unit, own in (
        ("force", "N/m", found.translation),
        ("moment", "N m/rad", found.rotation),
    ):
        for value, axis in zip(own.stiffness, own.axes.T, strict=True):
            rows.append((f"against a {what}", *_shown(float(value), unit), _axis(axis)))
    place = told(found.position.tolist(), found.length)
    columns = ("principal stiffness", "value", "unit", "axis x, y, z")
    note = "" if found.stable else "not stable: the robot would not come back after a push"
    show(TextTable(f"{found.robot}, tool at ({place}) m", columns, rows, right=columns[1:2], note=note))
    _show_deflection(title, moved)
    if not moved.any():
        say("nothing gives way under this load: the tool is rigid against it")
        return
    seen = [one for one in parts if abs(one.share) >= 5e-5][:SHOWN]
    cells = [(one.name, one.kind, f"{100.0 * one.share:.2f}", *_size(one.deflection[:3])) for one in seen]
    heads = ("part", "kind", "share [%]", "moves the tool by", "")
    left = len(parts) - len(seen)
    note = f"{left} more have {100.0 * (1.0 - sum(one.share for one in seen)):.2g} %" if left else ""
    show(TextTable("what that is due to", heads, cells, right=heads[2:4], note=note))


def _show_deflection(title: str, moved: Array) -> None:
    from cutjoint.stiffness.telling import told
    from cutjoint.units import handy

    rows = []
    for what, unit, few in (("displacement", "m", slice(0, 3)), ("rotation", "rad", slice(3, 6))):
        factor, shown = handy(float(np.linalg.norm(moved[few])), unit)
        size = float(np.linalg.norm(moved[few]))
        rows.append(
            (what, *(told([factor * x], factor * size) for x in moved[few].tolist()), f"{factor * size:.4g}", shown)
        )
    columns = ("of the tool", "x", "y", "z", "size", "unit")
    show(TextTable(f"deflection by the {title}", columns, rows, right=columns[1:5]))


def _show_course(times: Array, found: Sequence[ToolStiffness], json: bool) -> None:
    """Along a motion: the softest of each."""

    from cutjoint.stiffness.telling import told

    forces = np.array([one.translation.stiffness for one in found])
    moments = np.array([one.rotation.stiffness for one in found])
    if json:
        print_json(
            {
                "robot": found[0].robot,
                "time": times,
                "position": [one.position for one in found],
                "stiffness_against_forces": [_finite(one) for one in forces],
                "stiffness_against_moments": [_finite(one) for one in moments],
                "stable": [one.stable for one in found],
            }
        )
        return
    rows = []
    for what, unit, values in (("force", "N/m", forces[:, 0]), ("moment", "N m/rad", moments[:, 0])):
        for name, index in (("least", int(values.argmin())), ("most", int(values.argmax()))):
            place = told(found[index].position.tolist(), found[index].length)
            rows.append((f"{name} against a {what}", *_shown(float(values[index]), unit), f"{times[index]:.4g}", place))
    columns = ("softest direction", "value", "unit", "at [s]", "tool x, y, z [m]")
    unstable = sum(not one.stable for one in found)
    note = f"not stable at {unstable} instants: the robot would not come back after a push" if unstable else ""
    title = f"{found[0].robot}: stiffness along a motion of {times[-1]:.4g} s, {len(found)} instants"
    show(TextTable(title, columns, rows, right=(columns[1], columns[3]), note=note))


def _shown(value: float, unit: str) -> tuple[str, str]:
    from cutjoint.units import handy

    if np.isinf(value):
        return "rigid", ""
    factor, shown = handy(abs(value), unit)
    return f"{factor * value:.4g}", shown


def _size(displacement: Array) -> tuple[str, str]:
    from cutjoint.units import handy

    size = float(np.linalg.norm(displacement))
    factor, unit = handy(size, "m")
    return f"{factor * size:.4g}", unit


def _axis(axis: Array) -> str:
    return ", ".join(f"{0.0 if abs(x) < 5e-4 else x:.3f}" for x in _tidy(axis))


def _tidy(axis: Array) -> Array:
    """A direction whose largest component is positive, without what is rounding."""
    sign = -1.0 if axis[int(np.abs(axis).argmax())] < 0.0 else 1.0
    clean = np.where(np.abs(axis) < 1e-4, 0.0, sign * axis)
    return np.asarray(clean / np.linalg.norm(clean))


def _finite(values: Array) -> list[float | None]:
    """Numbers for JSON, which has no infinity: None is rigid."""
    return [None if np.isinf(one) else float(one) for one in values]
