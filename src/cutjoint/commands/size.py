"""`cutjoint size`: what motors, gears, brakes and bearings must give along trajectories."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint.commands import completing, options, sized
from cutjoint.commands.loads import OutsideLoads, loads_of
from cutjoint.commands.options import HELP
from cutjoint.commands.output import print_json, say, show
from cutjoint.commands.progress import progress

if TYPE_CHECKING:
    from cutjoint.mechanism import Load, Mechanism
    from cutjoint.motion import Reference
    from cutjoint.sizing import Anywhere, Gearing, ServoMotor, Sizing

GEARS, ANYWHERE = "Motors and gears", "Anywhere"


# long: its options, a line or three each
def command(
    robot: options.Robot,
    trajectory: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SPEC",
            help=f"Default paper, or about-home; may be repeated, then the worst counts: {HELP}",
            autocompletion=completing.trajectories,
        ),
    ] = None,
    duration: Annotated[
        float | None, typer.Option(metavar="S", help="How long each is followed; default its own time.")
    ] = None,
    payload: options.Payload = 0.0,
    load: OutsideLoads = None,
    motors: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE.csv",
            help="Table of motors with units in its headings, such as rated_torque [N m] (docs/sizing.md); may be "
            "repeated.",
            rich_help_panel=GEARS,
        ),
    ] = None,
    gear: Annotated[
        str | None,
        typer.Option(metavar="LIST", help="Ratios to choose from: 3,5,10; default any.", rich_help_panel=GEARS),
    ] = None,
    efficiency: Annotated[
        float, typer.Option(metavar="PART", help="Of the gear, in (0, 1].", rich_help_panel=GEARS)
    ] = 1.0,
    gear_inertia: Annotated[
        float, typer.Option(metavar="KGM2", help="Of the gear at the motor [kg m2].", rich_help_panel=GEARS)
    ] = 0.0,
    pitch: Annotated[
        float | None,
        typer.Option(
            metavar="M", help="Screw, metres a turn: motors that turn drive what slides.", rich_help_panel=GEARS
        ),
    ] = None,
    brake_factor: Annotated[
        float,
        typer.Option(metavar="K", help="Brakes hold K times the largest holding effort.", rich_help_panel=GEARS),
    ] = 1.5,
    ambient: Annotated[
        float, typer.Option(metavar="DEGC", help="Temperature of the surroundings [degC].", rich_help_panel=GEARS)
    ] = 40.0,
    bearings: Annotated[
        bool, typer.Option("--bearings", help="Tell what joints and cuts carry, along and across their axes.")
    ] = False,
    workspace: Annotated[
        bool,
        typer.Option(
            "--workspace",
            help="Tell the worst case anywhere in the workspace, at speeds and accelerations of the tool.",
            rich_help_panel=ANYWHERE,
        ),
    ] = False,
    tool_speed: Annotated[
        float | None, typer.Option(metavar="M/S", help="Largest of the tool point.", rich_help_panel=ANYWHERE)
    ] = None,
    tool_acceleration: Annotated[
        float | None, typer.Option(metavar="M/S2", help="Largest of the tool point.", rich_help_panel=ANYWHERE)
    ] = None,
    turn_speed: Annotated[
        float | None,
        typer.Option(metavar="RAD/S", help="Largest of the tool's turning, where it is led.", rich_help_panel=ANYWHERE),
    ] = None,
    turn_acceleration: Annotated[
        float | None,
        typer.Option(metavar="RAD/S2", help="Largest of the tool's turning.", rich_help_panel=ANYWHERE),
    ] = None,
    condition: Annotated[
        float,
        typer.Option(metavar="K", help="Worst of the task's Jacobian that is looked at.", rich_help_panel=ANYWHERE),
    ] = 10.0,
    samples: Annotated[
        int, typer.Option(metavar="N", help="Postures that are looked at.", rich_help_panel=ANYWHERE)
    ] = 300,
    seed: Annotated[int, typer.Option(metavar="N", help="Of the postures.", rich_help_panel=ANYWHERE)] = 0,
    variant: options.Variant = None,
    ideal: options.Ideal = False,
    lenient: options.Lenient = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="FILE", help="Draw efforts over speeds, beside the best motors: .png or .svg."
        ),
    ] = None,
    csv: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Write efforts, speeds and powers at every instant.")
    ] = None,
    json: options.Json = False,
) -> None:
    """Size a robot: what its motors, gears, brakes and bearings must give along trajectories.

    Peaks and root mean squares of efforts and speeds, powers, energy that comes back, efforts that hold it at rest;
    with friction, springs and rotors as the robot has them. With a table of motors it says which of them do it, behind
    which gear. Exit status 1 means that no motor of the table does it at some actuator.
    """
    from cutjoint.sizing.telling import anywhere_table, tables_of

    sized.check_places(output, csv)
    table, between = sized.motors_of(motors or (), gear, efficiency, gear_inertia, pitch, brake_factor, ambient)
    sized.check_anywhere(workspace, tool_speed, tool_acceleration, turn_speed, turn_acceleration)
    acting = loads_of(load) if load else []
    chain, told = sized.robot_of(robot, variant, ideal, lenient)
    between.check(chain.actuators, table)
    fast, references = sized.references_of(chain, trajectory or (), duration)
    found = _sized(fast, references, table, between, acting, payload, bearings=bearings)
    anywhere = None
    if workspace:
        assert tool_speed is not None
        assert tool_acceleration is not None
        bounds = (tool_speed, tool_acceleration, turn_speed, turn_acceleration)
        anywhere = _anywhere(fast, bounds, payload, acting, condition, samples, seed)
    sized.write_files(found, output, csv)
    if json:
        print_json(sized.data(found, anywhere, told))
    else:
        for one in tables_of(found):
            show(one)
        if anywhere is not None:
            show(anywhere_table(chain.name, anywhere))
        for text in told:
            say(text)
        for path in (output, csv):
            if path is not None:
                say(f"wrote {path}")
    if sized.too_small(found):
        raise typer.Exit(1)


def _sized(
    robot: Mechanism,
    references: list[Reference],
    motors: list[ServoMotor],
    gearing: Gearing,
    loads: list[Load],
    payload: float,
    *,
    bearings: bool,
) -> Sizing:
    from cutjoint.sizing import size

    with progress(f"{robot.name}: sizing") as told:
        return size(
            robot,
            references,
            motors=motors,
            gearing=gearing,
            loads=loads,
            payload=payload,
            bearings=bearings,
            progress=told,
        )


def _anywhere(
    robot: Mechanism,
    bounds: tuple[float, float, float | None, float | None],
    payload: float,
    loads: list[Load],
    condition: float,
    samples: int,
    seed: int,
) -> Anywhere:
    from cutjoint.sizing import size_anywhere

    with progress(f"{robot.name}: anywhere", samples, "postures") as told:
        return size_anywhere(
            robot,
            bounds[0],
            bounds[1],
            turn_speed=bounds[2],
            turn_acceleration=bounds[3],
            payload=payload,
            loads=loads,
            condition=condition,
            samples=samples,
            seed=seed,
            progress=told,
        )
