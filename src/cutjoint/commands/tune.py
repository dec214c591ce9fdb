"""`cutjoint tune`: gains of a controller, its margins and step responses, beside the paper's and the usual gains."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from cutjoint import interrupts
from cutjoint.commands import built, completing, options
from cutjoint.commands.options import CONTROLLERS, HELP
from cutjoint.commands.output import print_json
from cutjoint.commands.progress import progress
from cutjoint.commands.stopping import stopped

if TYPE_CHECKING:
    from cutjoint.mechanism import Mechanism
    from cutjoint.tuning import Tuning


class By(StrEnum):
    """How gains are found."""

    RULE = "rule"
    POLES = "poles"
    OPTIMISE = "optimise"


class Method(StrEnum):
    """How gains are sought."""

    EVOLUTION = "evolution"
    OPTUNA = "optuna"


class ErrorOf(StrEnum):
    """What errors are taken of."""

    TOOL = "tool"
    ACTUATORS = "actuators"


# long: its options, a line or three each
def command(
    robot: options.Robot,
    controller: Annotated[
        str,
        typer.Option(metavar="NAME", help=f"Default pd: {CONTROLLERS}", autocompletion=completing.controllers),
    ] = "pd",
    by: Annotated[
        By | None,
        typer.Option(
            help="How: the CPM paper's rule (default where there is a bound of the error), pole placement (else the "
            "default), or a search over runs."
        ),
    ] = None,
    trajectory: Annotated[
        str | None,
        typer.Option(
            metavar="SPEC", help=f"Default paper, or about-home: {HELP}", autocompletion=completing.trajectories
        ),
    ] = None,
    duration: Annotated[float | None, typer.Option(metavar="S", help="Default that of the trajectory.")] = None,
    error: Annotated[
        float | None,
        typer.Option(metavar="M", help="Rule: bound of the late error (m or rad); of the CPM default its paper's."),
    ] = None,
    limit: Annotated[
        str | None,
        typer.Option(
            metavar="N",
            help="Efforts that should not be exceeded: 120, or 1,2,3 (N or N m); the rule takes kd from it. Nothing "
            "is cut off there; limits of a drive are in --hardware.",
        ),
    ] = None,
    after: Annotated[
        float | None, typer.Option(metavar="S", help="From when on late errors count; default 0.3 s.")
    ] = None,
    of: Annotated[
        ErrorOf | None, typer.Option(help="Whose late error; default the tool's, where its point moves.")
    ] = None,
    bandwidth: Annotated[
        float | None, typer.Option(metavar="RAD/S", help="Poles: how fast they decay; default 20.")
    ] = None,
    damping: Annotated[
        float | None, typer.Option(metavar="RATIO", help="Poles: least damping ratio; default 1.")
    ] = None,
    method: Annotated[Method | None, typer.Option(help="Optimise: differential evolution (default) or optuna.")] = None,
    trials: Annotated[
        int | None, typer.Option(metavar="N", help="Optimise: how many sets of gains; default 400.")
    ] = None,
    sensitivity: Annotated[
        float | None,
        typer.Option(metavar="RATIO", help="Optimise: largest peak of the sensitivity; default 2."),
    ] = None,
    payload: Annotated[
        list[float] | None,
        typer.Option(metavar="KG", help="Mass at the tool, unknown to the controller; repeated, the worst counts."),
    ] = None,
    draws: Annotated[
        int | None,
        typer.Option(
            metavar="N", help="Runs of every set of gains, each with other noise; the worst counts; default 3."
        ),
    ] = None,
    gain: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=K", help="Gains to begin with and to compare with; repeated, all of them."),
    ] = None,
    plant: Annotated[
        str | None,
        typer.Option(
            metavar="chain|paper|inferred",
            help="The robot: its chain (default), the published model, or of the CPM the model that its paper's "
            "table 3 was most likely computed with.",
        ),
    ] = None,
    model: options.Believed = None,
    variant: options.Variant = None,
    ideal: options.Ideal = False,
    lenient: options.Lenient = False,
    rate: options.SampleRate = None,
    hardware: built.File = None,
    delay: built.Delay = None,
    command_delay: built.CommandDelay = None,
    jitter: built.Jitter = None,
    tick: built.Tick = None,
    resolution: built.Resolution = None,
    noise: built.Noise = None,
    filter: built.Filter = None,
    seed: Annotated[int | None, typer.Option(metavar="N", help="Of noise, jitter and the search; default 0.")] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE", help="Draw Bode plot and step responses: .png, .svg."),
    ] = None,
    json: options.Json = False,
) -> None:
    """Find gains of a controller, and tell margins, poles and step responses beside those of other gains.

    By the rule of the CPM's paper (kd from the limit of the first effort, then the smallest kp that keeps the error),
    by placing the poles of the linear loop, or by a search over runs of the loop as it is built (--rate, --delay,
    --noise, friction), of the worst --payload and noise.  What the way does not fix is told.  Exit status 1 where the
    loop is unstable, or a limit or bound that was asked for does not hold.

    Examples: `cutjoint tune cpm --plant inferred` (12691 and 436, as printed); `cutjoint tune fivebar --by poles
    --bandwidth 30`; `cutjoint tune omega3 --by optimise --controller pd-gravity --rate 1000 --delay 1e-3`.
    """
    from cutjoint.commands.tuned import begin_with, reference_of, robots_for, show_tuning, tuning_data, way_of
    from cutjoint.report.answers.sheet import check_picture, write_sheet

    if output is not None:
        check_picture(output)
    noisy = any(one is not None for one in (delay, command_delay, jitter, tick, resolution, noise, filter))
    given = built.Built(
        hardware, delay, command_delay, jitter, tick, resolution, noise, filter, seed if noisy else None
    )
    machine = built.hardware_of_options(given, rate, None)
    if machine is None and rate is not None:
        from cutjoint.simulation.hardware import Clock, Hardware

        machine = Hardware(Clock(rate))
    used = {
        "--error": error,
        "--bandwidth": bandwidth,
        "--damping": damping,
        "--method": method,
        "--trials": trials,
        "--sensitivity": sensitivity,
    }
    robots = robots_for(robot, variant, plant, model, payload, ideal, lenient)
    way = way_of(robots.chain.description.name, controller, by, used, limit, seed)
    reference, told = reference_of(robots, trajectory, duration)
    begin = begin_with(controller, gain or ())
    moving = cast("Mechanism", robots.moving)
    trials_of = getattr(way.by, "trials", None)
    early = ""
    with interrupts.keeping():
        from cutjoint.errors import Interrupted
        from cutjoint.tuning import tune

        try:
            with (
                interrupts.asking(),
                progress(f"{moving.name}, {controller}: {way.by.words}", trials_of, "gains") as show,
            ):

                def shown(done: float) -> None:
                    interrupts.check()
                    show(done)

                found = tune(
                    moving,
                    controller,
                    reference,
                    by=way.by,
                    model=robots.inside,
                    hardware=machine,
                    limit=way.limit,
                    payloads=payload or [0.0],
                    after=after,
                    of=None if of is None else of.value,
                    begin=begin,
                    draws=draws,
                    compare={"given": begin} if begin else None,
                    progress=shown if trials_of else None,
                )
        except Interrupted as interrupt:
            if interrupt.result is None:
                raise
            found, early = cast("Tuning", interrupt.result), str(interrupt)
        if output is not None:
            from cutjoint.report.answers.tuning import tuning_sheet

            write_sheet(tuning_sheet(found), output)
        notes = [*robots.told, *way.told, *told]
        if json:
            print_json(tuning_data(found, notes, interrupted=bool(early)))
        else:
            show_tuning(found, notes)
        if early:
            raise stopped(f"{early}; the best of them are told")
    raise typer.Exit(1 if found.unmet else 0)
