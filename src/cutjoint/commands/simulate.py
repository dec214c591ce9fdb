"""`cutjoint simulate`: one robot, one controller, one trajectory."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import numpy as np
import typer

from cutjoint import interrupts
from cutjoint.commands import built, completing, options
from cutjoint.commands.failing import complain
from cutjoint.commands.loads import OutsideLoads, loads_of
from cutjoint.commands.options import CONTROLLERS, HELP, named_gains, numbers, with_gains
from cutjoint.commands.output import print_json
from cutjoint.commands.progress import progress
from cutjoint.commands.reaction_peaks import check_reactions, peaks_data, save_reactions, show_peaks
from cutjoint.commands.run_figures import show_run
from cutjoint.commands.simulated import check_loads, led_by, robots_of, unled
from cutjoint.commands.stopping import stopped, stopped_name

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from cutjoint.control import Law
    from cutjoint.mechanism import JointLimits, Load, Mechanism
    from cutjoint.motion import Reference
    from cutjoint.simulation import Integrator, Plant, Result
    from cutjoint.simulation.hardware import Hardware

LONGEST_STEP = 1e-3
PROGRESS = 0.02
"""Part of a run after which its progress is shown anew."""


# long: its options, a line or three each
@with_gains
def command(
    robot: options.Robot,
    controller: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help=f"Default computed-torque, with --free none: {CONTROLLERS}",
            autocompletion=completing.controllers,
        ),
    ] = None,
    trajectory: Annotated[
        str | None,
        typer.Option(
            metavar="SPEC", help=f"Default paper, or about-home: {HELP}", autocompletion=completing.trajectories
        ),
    ] = None,
    free: Annotated[
        bool, typer.Option("--free", help="Nothing to follow: the robot falls, or does what the controller wants.")
    ] = False,
    efforts: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.csv",
            help="Nothing to follow, efforts as given: columns t and the actuators [N] or [N m], linear between rows.",
        ),
    ] = None,
    lock: Annotated[
        list[str] | None,
        typer.Option(metavar="ACTUATOR", help="A brake holds this actuator where it starts; may be repeated."),
    ] = None,
    load: OutsideLoads = None,
    plant: Annotated[
        str | None,
        typer.Option(
            metavar="compiled|chain|paper",
            help="The robot: its chain compiled, where it can be, which is the default; the chain in Pinocchio; or the "
            "published model.",
        ),
    ] = None,
    model: options.Believed = None,
    variant: options.Variant = None,
    ideal: options.Ideal = False,
    lenient: options.Lenient = False,
    gain: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=K", help="A gain by name, also of controllers from outside; may be repeated."),
    ] = None,
    rate: options.SampleRate = None,
    limit: Annotated[
        str | None, typer.Option(metavar="N", help="Largest effort of the actuators: 120, or 1,2,3 [N] or [N m].")
    ] = None,
    hardware: built.File = None,
    delay: built.Delay = None,
    command_delay: built.CommandDelay = None,
    jitter: built.Jitter = None,
    tick: built.Tick = None,
    resolution: built.Resolution = None,
    noise: built.Noise = None,
    filter: built.Filter = None,
    seed: built.Seed = None,
    payload: Annotated[float, typer.Option(metavar="KG", help="Mass at the tool, unknown to the controller.")] = 0.0,
    duration: Annotated[
        float | None, typer.Option(metavar="S", help="Default that of the trajectory or the efforts; with --free 1 s.")
    ] = None,
    every: Annotated[
        float | None, typer.Option(metavar="S", help="Distance of the samples in the result; default 1 ms or --step.")
    ] = None,
    step: Annotated[
        float | None,
        typer.Option(
            metavar="S", help="Fixed steps, RK4; default adaptive, with --rate in machine code where there is any."
        ),
    ] = None,
    ignore_limits: Annotated[
        bool, typer.Option("--ignore-limits", help="Go on where a joint passes its limits; else the run stops there.")
    ] = False,
    save: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the result: .npz (to play) or .csv.")] = None,
    reactions: Annotated[
        Path | None,
        typer.Option(metavar="FILE.csv", help="Write force and moment in every joint and cut; the peaks are shown."),
    ] = None,
    json: options.Json = False,
    **gains: str | None,
) -> None:
    """Simulate a robot under a controller and say how well it followed, and whether the simulation can be believed.

    With no options it follows its paper's trajectory, or a small motion about home under computed torque; where its
    actuators do not determine its motion they are led, and the rest falls.

    The robot starts at rest in the first desired posture, or at home where it follows nothing.  A run that cannot go on
    ends with exit status 2, one that is interrupted (Ctrl-C) with 130; with `--save FILE` what was simulated until then
    is kept beside it as FILE's name with `.stopped` in it.
    """
    from cutjoint.simulation import save as write
    from cutjoint.simulation.result_file import check_target

    if save is not None:
        check_target(save)
    machine = built.hardware_of_options(
        built.Built(hardware, delay, command_delay, jitter, tick, resolution, noise, filter, seed), rate, limit
    )
    default = not free and efforts is None and controller is None and trajectory is None
    robots = robots_of(robot, variant, plant, model, payload, ideal, lenient, default)
    acting = loads_of(load) if load else None
    check_loads(robots, acting or ())
    if reactions is not None:
        check_reactions(reactions, robots.robot)
    joints: JointLimits = "ignore" if ignore_limits else "respect"
    given = named_gains(gains, gain or ())
    if free or efforts is not None:
        led = unled(robots, controller, trajectory, efforts, lock or (), given)
    else:
        led = led_by(robots, controller, trajectory, duration, given, joints)
    if duration is None and efforts is None:
        duration = led.duration
    with interrupts.keeping():
        made = options.made_with(variant, ideal, lenient, payload)
        result, early = _done(
            save,
            made,
            lambda: _run(
                (robots.moving, led.law, led.reference),
                duration,
                machine or (rate, limit),
                every,
                step,
                lock=lock or (),
                joint_limits=joints,
                loads=acting,
            ),
            may_end=led.may_end,
        )
        saved = None if save is None else write(result, stopped_name(save) if early else save)
        told = [*robots.told, *led.told, *_afterwards(result, led.law, duration)]
        _tell(result, saved, reactions, robots.robot, json=json, early=early, told=told)


def _done(
    save: Path | None, made: Mapping[str, object], go: Callable[[], Result], *, may_end: bool
) -> tuple[Result, str]:
    """The result of a run, which says how its robot was `made`; where it was interrupted also the words for that, and
    the result goes until then.

    It `may_end` where a joint meets its limits, if the run was chosen so and nothing drives that joint.
    """
    from cutjoint.errors import Interrupted, LimitError, SimulationError
    from cutjoint.simulation import save as write

    def said(result: object) -> Result:
        found = cast("Result", result)
        return replace(found, about={**found.about, "options": dict(made)})

    try:
        return said(go()), ""
    except SimulationError as error:
        early = said(error.result)
        if may_end and isinstance(error.__cause__, LimitError) and early.time[-1] > 0.0:
            return early, ""
        if save is not None:
            complain(f"what was simulated until then: {write(early, stopped_name(save))}")
        raise
    except Interrupted as error:
        return said(error.result), str(error)


def _afterwards(result: Result, law: Law, duration: float | None) -> list[str]:
    """What a run that was chosen unasked came to: how well actuators were led, and whether it ended early."""
    from cutjoint.control.led import LedActuators

    if not isinstance(law, LedActuators):
        return []
    off = np.abs(result.q - [law.at(t)[0] for t in result.time.tolist()]).max()
    told = [f"the actuators were at most {off:.2g} m or rad off their way"]
    if duration is not None and result.time[-1] < duration * (1.0 - 1e-9):
        told.append(
            f"it ends at {result.time[-1]:.4g} s of {duration:.4g} s, where a joint that nothing drives meets its "
            "limits; --ignore-limits goes on"
        )
    return told


def _tell(
    result: Result,
    saved: Path | None,
    reactions: Path | None,
    robot: Mechanism,
    *,
    json: bool,
    early: str,
    told: Sequence[str],
) -> None:
    """Print what a run comes to, and write its reactions; of a run that was interrupted only where nothing else is
    kept.

    Raises:
        typer.Exit: it was interrupted.
    """
    from cutjoint.simulation.summary import figures_of

    figures = figures_of(result)
    if told:
        figures["chosen"] = list(told)
    if saved is not None:
        figures["saved"] = str(saved)
    if early:
        figures["interrupted"] = True
    carried = None
    if reactions is not None and not (early and saved is not None):
        reactions = stopped_name(reactions) if early else reactions
        try:
            with interrupts.asking():
                carried = save_reactions(reactions, result, robot)
        except KeyboardInterrupt:
            told = "nothing was written" if saved is None else f"the run is kept in {saved}, its reactions are not"
            raise stopped(told) from None
        figures |= {"reactions": str(reactions), "reaction_peaks": peaks_data(carried)}
    if json:
        print_json(figures)
    else:
        show_run(result, figures)
        if carried is not None:
            show_peaks(carried)
    if early:
        kept = [str(one) for one in (saved, reactions if carried else None) if one is not None]
        raise stopped(f"{early}; kept in {', '.join(kept)}" if kept else f"{early}; without --save no file is written")


def _run(
    what: tuple[Plant | Mechanism, Law, Reference | None],
    duration: float | None,
    machine: Hardware | tuple[float | None, str | None],
    every: float | None,
    step: float | None,
    *,
    lock: Sequence[str],
    joint_limits: JointLimits,
    loads: Sequence[Load] | None,
) -> Result:
    from cutjoint.simulation import Adaptive, RungeKutta4, run

    moving, law, _ = what
    span = getattr(law, "duration", None) if duration is None else duration
    hardware = None if isinstance(machine, tuple) else machine
    rate, limit = machine if isinstance(machine, tuple) else (None, None)
    method: Integrator | None = None if step is None else RungeKutta4(step)
    if method is None and rate is None and hardware is None:
        method = Adaptive(1e-8, 1e-10)
    with interrupts.asking(), progress(f"{moving.name}, {law.name}", span, "s") as told:
        shown = 0.0

        def show(t: float) -> None:
            nonlocal shown
            interrupts.check()
            if span is None or t - shown >= PROGRESS * span:
                told(t)
                shown = t

        return run(
            *what,
            integrator=method,
            duration=duration,
            rate=rate,
            limits=None if limit is None else numbers("--limit", limit),
            hardware=hardware,
            every=max(LONGEST_STEP, step or 0.0) if every is None else every,
            lock=lock,
            joint_limits=joint_limits,
            loads=loads,
            progress=show,
        )
