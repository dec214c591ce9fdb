"""`cutjoint retime`: the quickest motion along a path, or from point to point, within limits."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint import interrupts
from cutjoint.commands import completing, moves, options
from cutjoint.commands.loads import OutsideLoads, loads_of
from cutjoint.commands.moves import FORM
from cutjoint.commands.options import assigned, numbers
from cutjoint.commands.output import print_json, say, show
from cutjoint.commands.progress import progress
from cutjoint.errors import InputError
from cutjoint.files import check_place

if TYPE_CHECKING:
    import numpy.typing as npt

    from cutjoint.mechanism import Mechanism
    from cutjoint.motion import Trajectory
    from cutjoint.retiming import MotionLimits, Retimed

EACH = "One number, numbers with commas in the actuators' order, or NAME=K,...; inf is no limit."


# long: its options, a line or three each
def command(
    robot: options.Robot,
    trajectory: Annotated[
        str | None,
        typer.Option(
            metavar="SPEC",
            help="Whose path is gone, as of `cutjoint simulate`; default paper, or about-home.",
            autocompletion=completing.trajectories,
        ),
    ] = None,
    to: Annotated[
        list[str] | None,
        typer.Option(
            metavar="POINT",
            help=f"No path, but points to go to from home, at rest at each: {FORM}; may be repeated, and needs "
            "--acceleration and --jerk.",
        ),
    ] = None,
    effort: Annotated[
        str | None,
        typer.Option(metavar="N", help=f"Largest efforts [N] or [N m]; default those of the robot's file. {EACH}"),
    ] = None,
    speed: Annotated[
        str | None,
        typer.Option(metavar="V", help="Largest speeds [m/s] or [rad/s], likewise; default those of the robot's file."),
    ] = None,
    acceleration: Annotated[
        str | None, typer.Option(metavar="A", help="Largest accelerations [m/s2] or [rad/s2], likewise.")
    ] = None,
    jerk: Annotated[str | None, typer.Option(metavar="J", help="Largest jerks [m/s3] or [rad/s3], likewise.")] = None,
    power: Annotated[
        str | None, typer.Option(metavar="W", help="Largest mechanical power of each actuator [W], likewise.")
    ] = None,
    tool_speed: Annotated[
        float | None, typer.Option(metavar="V", help="Largest speed of the tool point [m/s].")
    ] = None,
    tool_acceleration: Annotated[
        float | None, typer.Option(metavar="A", help="Largest acceleration of the tool point [m/s2].")
    ] = None,
    goes_round: Annotated[
        bool,
        typer.Option("--round", help="A closed path without a rest: it goes round for ever, at speed where it begins."),
    ] = False,
    ramp: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            help="Time in which the acceleration goes from one limit to another; default a 200th of the motion.",
        ),
    ] = None,
    payload: options.Payload = 0.0,
    load: OutsideLoads = None,
    variant: options.Variant = None,
    ideal: options.Ideal = False,
    lenient: options.Lenient = False,
    save: Annotated[
        Path | None,
        typer.Option(metavar="FILE.csv", help="Write the motion; `cutjoint simulate --trajectory FILE.csv` runs it."),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE", help="Write a picture of it: .png or .svg."),
    ] = None,
    json: options.Json = False,
) -> None:
    """The quickest motion along a path, or to points, within limits of speed, acceleration, jerk, effort and power.

    Only the path of the trajectory counts, not its time. The motion is from rest to rest; with --round it goes round.
    Limits are kept at every instant, to 0.1 %, which inverse dynamics checks between the grid points. Where there is no
    such motion it is told which limit leaves none, and where; the exit status is 2 then. With --to no path is
    prescribed: the actuators go from point to point as quickly as speed, acceleration and jerk let them.
    """
    from cutjoint.report.answers.retiming import retiming_sheet
    from cutjoint.report.answers.sheet import check_picture, write_sheet
    from cutjoint.retiming import retime
    from cutjoint.robots import load as load_robot

    if to:
        unused = {"--trajectory": trajectory is not None, "--round": goes_round, "--ramp": ramp is not None}
        if any(unused.values()):
            told_twice = ", ".join(name for name, given in unused.items() if given)
            raise InputError(f"--to goes from point to point, along no path; it takes no {told_twice}")
    if output is not None:
        check_picture(output)
    if save is not None:
        if save.suffix.lower() != ".csv":
            raise InputError(f"'{save}': a motion is written as .csv, found '{save.suffix}'")
        check_place(save)
    chain = load_robot(robot, variant, dynamics="ideal" if ideal else "real", lenient=lenient)
    if payload:
        chain = chain.with_payload(payload)
    each = {"effort": effort, "speed": speed, "acceleration": acceleration, "jerk": jerk, "power": power}
    limits = _limits(chain, each, tool_speed, tool_acceleration)
    acting = tuple(loads_of(load)) if load else ()
    if to:
        moves.run(chain, to, limits, acting, save=save, output=output, json=json)
        return
    path = _path(chain, trajectory)
    with progress(f"{chain.name}: retiming", 100.0, "%") as told:
        found = retime(
            chain,
            path,
            limits,
            goes_round=goes_round,
            ramp=ramp,
            loads=acting,
            progress=lambda part: told(round(100.0 * part)),
        )
    written = []
    with interrupts.keeping():
        if save is not None:
            written.append(found.save(save))
        if output is not None:
            written.append(write_sheet(retiming_sheet(found), output))
    if json:
        print_json(_data(found, written))
        return
    _tell(found, path.name)
    for one in written:
        say(f"wrote {one}")


def _limits(
    chain: Mechanism, each: Mapping[str, str | None], tool_speed: float | None, tool_acceleration: float | None
) -> MotionLimits:
    from cutjoint.retiming import limits_of

    given = {name: None if text is None else _numbers(f"--{name}", text) for name, text in each.items()}
    return limits_of(chain, **given, tool_speed=tool_speed, tool_acceleration=tool_acceleration)


def _numbers(option: str, text: str) -> npt.ArrayLike | Mapping[str, float]:
    if "=" not in text:
        return numbers(option, text)
    found = {}
    for name, value in assigned(option, f"{option} NAME=K,...", text.split(",")).items():
        try:
            found[name] = float(value)
        except ValueError as error:
            raise InputError(f"{option} of {name} must be a number, found '{value}'") from error
    return found


def _path(chain: Mechanism, spec: str | None) -> Trajectory:
    """The trajectory that is named, or the one of the robot's paper, or a small one about home."""
    from cutjoint.robots import PUBLISHED

    if spec is None:
        row = PUBLISHED.get(chain.description.name)  # type: ignore[attr-defined]
        spec = "paper" if row is not None and row.path is not None else "about-home"
    return options.trajectory_of(chain, spec)  # type: ignore[arg-type]


def _tell(found: Retimed, path: str) -> None:
    how = "round and round" if found.goes_round else "from rest to rest"
    say(f"{found.name}, {path}: {found.duration:.5g} s {how}; the trajectory took {found.former:.4g} s")
    if found.cycles_per_minute is not None:
        say(f"{found.cycles_per_minute:.4g} cycles a minute")
    say(
        f"{100.0 * max(found.gap, 0.0):.2f} % longer than the quickest with an acceleration that jumps; here it takes "
        f"{1e3 * found.ramp:.3g} ms from one limit to another; within {found.deviation:.1e} m or rad of the path"
    )
    for one in found.told:
        say(one, first="  ")
    say()
    show(found.table())


def _data(found: Retimed, written: list[Path]) -> dict[str, object]:
    names = ("name", "duration", "shortest", "gap", "former", "cycles_per_minute", "closed", "goes_round", "ramp")
    data = {name: getattr(found, name) for name in (*names, "checked", "deviation")}
    fields = ("quantity", "largest", "limit", "unit", "part", "t", "active")
    data["peaks"] = [{name: getattr(one, name) for name in fields} for one in found.peaks]
    data["told"] = list(found.told)
    if written:
        data["written"] = [str(one) for one in written]
    return data
