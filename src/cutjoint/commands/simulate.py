"""`cutjoint simulate`: one robot, one controller, one trajectory."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple, TypeVar, cast

import typer

from cutjoint import interrupts
from cutjoint.commands import built, completing, options
from cutjoint.commands.failing import complain
from cutjoint.commands.loads import loads_of
from cutjoint.commands.options import CONTROLLERS, HELP, gains_of, named_gains, numbers, trajectory_of, with_gains
from cutjoint.commands.output import print_json
from cutjoint.commands.progress import progress
from cutjoint.commands.reaction_peaks import check_reactions, peaks_of, show_peaks, written
from cutjoint.commands.run_figures import show
from cutjoint.commands.stopping import stopped, stopped_name

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from cutjoint.chain import ClosedChain
    from cutjoint.control import Law
    from cutjoint.mechanism import JointLimits, Load, Mechanism
    from cutjoint.motion import Reference
    from cutjoint.simulation import Integrator, Plant, Result
    from cutjoint.simulation.hardware import Hardware

LONGEST_STEP = 1e-3
PROGRESS = 0.02
"""Part of a run after which its progress is shown anew."""
Robot = TypeVar("Robot", bound="Mechanism")


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
        typer.Option(metavar="SPEC", help=f"Default paper: {HELP}", autocompletion=completing.trajectories),
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
    load: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LINK:FX,FY,FZ[,MX,MY,MZ]",
            help="Force [N] and moment [N m] from outside, world axes, such as tool:0,0,-10; may be repeated.",
        ),
    ] = None,
    plant: Annotated[
        str,
        typer.Option(
            metavar="compiled|chain|paper",
            help="The robot: its chain compiled, where it can be; the chain in Pinocchio; or the published model.",
        ),
    ] = "compiled",
    model: Annotated[
        str | None,
        typer.Option(
            metavar="chain|paper",
            help="What the controller believes; default the published model of an ideal robot that has one.",
        ),
    ] = None,
    variant: options.Variant = None,
    ideal: options.Ideal = False,
    lenient: options.Lenient = False,
    gain: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=K", help="A gain by name, also of controllers from outside; may be repeated."),
    ] = None,
    rate: Annotated[
        float | None, typer.Option(metavar="HZ", help="Sample rate of the controller; default continuous control.")
    ] = None,
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
    robots = _robots(robot, variant, plant, model, payload, ideal, lenient)
    if reactions is not None:
        check_reactions(reactions, robots.robot)
    joints: JointLimits = "ignore" if ignore_limits else "respect"
    if free or efforts is not None:
        law = _unled(robots, controller, trajectory, efforts, lock or (), named_gains(gains, gain or ()))
        reference = None
    else:
        law = _law(robots, controller or "computed-torque", named_gains(gains, gain or ()))
        reference = _reference(robots, trajectory or "paper", duration, joints)
    if duration is None and efforts is None:
        duration = 1.0 if reference is None else reference.duration
    with interrupts.keeping():
        result, early = _done(
            save,
            lambda: _run(
                (robots.moving, law, reference),
                duration,
                machine or (rate, limit),
                every,
                step,
                lock=lock or (),
                joint_limits=joints,
                loads=loads_of(load) if load else None,
            ),
        )
        saved = None if save is None else write(result, stopped_name(save) if early else save)
        _tell(result, saved, reactions, robots.robot, json=json, early=early)


def _done(save: Path | None, go: Callable[[], Result]) -> tuple[Result, str]:
    """The result of a run; where it was interrupted also the words for that, and the result goes until then."""
    from cutjoint.errors import Interrupted, SimulationError
    from cutjoint.simulation import save as write

    try:
        return go(), ""
    except SimulationError as error:
        if save is not None:
            beside = write(cast("Result", error.result), stopped_name(save))
            complain(f"what was simulated until then: {beside}")
        raise
    except Interrupted as error:
        return cast("Result", error.result), str(error)


def _tell(
    result: Result, saved: Path | None, reactions: Path | None, robot: Mechanism, *, json: bool, early: str
) -> None:
    """Print what a run comes to, and write its reactions; of a run that was interrupted only where nothing else is
    kept.

    Raises:
        typer.Exit: it was interrupted.
    """
    from cutjoint.simulation.summary import figures_of

    figures = figures_of(result)
    if saved is not None:
        figures["saved"] = str(saved)
    if early:
        figures["interrupted"] = True
    carried = None
    if reactions is not None and not (early and saved is not None):
        reactions = stopped_name(reactions) if early else reactions
        try:
            with interrupts.asking():
                carried = written(reactions, result, robot)
        except KeyboardInterrupt:
            told = "nothing was written" if saved is None else f"the run is kept in {saved}, its reactions are not"
            raise stopped(told) from None
        figures |= {"reactions": str(reactions), "reaction_peaks": peaks_of(carried)}
    if json:
        print_json(figures)
    else:
        show(result, figures)
        if carried is not None:
            show_peaks(carried)
    if early:
        kept = [str(one) for one in (saved, reactions if carried else None) if one is not None]
        raise stopped(f"{early}; kept in {', '.join(kept)}" if kept else f"{early}; without --save no file is written")


class Robots(NamedTuple):
    """What moves, the chain of the same robot, and what the controller believes."""

    moving: Plant | Mechanism
    chain: ClosedChain
    inside: Mechanism

    @property
    def robot(self) -> Mechanism:
        """What moves, without its plant, and not compiled."""
        from cutjoint.mechanism import Mechanism

        moving = self.moving
        robot = moving if isinstance(moving, Mechanism) else moving.mechanism
        plain: Mechanism = getattr(robot, "plain", robot)
        return plain


def _robots(
    robot: str, variant: str | None, plant: str, model: str | None, payload: float, ideal: bool, lenient: bool
) -> Robots:
    from cutjoint.errors import InputError, UnknownNameError
    from cutjoint.robots import PUBLISHED, load, published
    from cutjoint.simulation import ConstrainedPlant
    from cutjoint.simulation.choice import quick

    for option, side, known in (("plant", plant, ("compiled", "chain", "paper")), ("model", model, ("chain", "paper"))):
        if side is not None and side not in known:
            raise UnknownNameError(option, side, known)
    chain = load(robot, variant, dynamics="ideal" if ideal else "real", lenient=lenient)
    name = chain.description.name
    acting = chain.description.acting
    if plant == "paper" and acting:
        raise InputError(
            f"--plant paper moves freely, and {robot} has physics of {', '.join(acting)}; take --plant chain or "
            "--ideal, or published(...).with_motors(...) in Python"
        )
    believes = model or ("paper" if name in PUBLISHED and not acting else "chain")
    inside: Mechanism = published(name) if believes == "paper" else chain
    if plant == "chain":
        return Robots(ConstrainedPlant(_loaded(chain, payload)), chain, inside)
    quickly = quick(inside)
    if inside is chain and plant == "compiled" and payload == 0.0:
        return Robots(quickly, chain, quickly)
    moving: Mechanism = _loaded(published(name) if plant == "paper" else chain, payload)
    return Robots(moving, chain, quickly)


def _law(robots: Robots, controller: str, gains: Mapping[str, str]) -> Law:
    from cutjoint.control import law

    return law(controller, robots.inside, gains_of(robots.chain.description.name, controller, gains))


def _unled(
    robots: Robots,
    controller: str | None,
    trajectory: str | None,
    efforts: Path | None,
    lock: Sequence[str],
    gains: Mapping[str, str],
) -> Law:
    """Who gives the efforts of a robot that follows nothing."""
    from cutjoint.control import efforts_from_csv
    from cutjoint.errors import InputError

    if trajectory is not None:
        raise InputError(
            f"with {'--free' if efforts is None else '--efforts'} nothing is followed; leave out --trajectory"
        )
    if efforts is None:
        return _law(robots, controller or "none", gains)
    if controller is not None or gains:
        raise InputError("with --efforts there is no controller; leave out --controller and gains")
    return efforts_from_csv(efforts, robots.chain.actuators, lock)


def _reference(robots: Robots, trajectory: str, duration: float | None, joints: JointLimits) -> Reference:
    from cutjoint.motion import Reference

    return Reference(trajectory_of(robots.chain, trajectory, robots.inside), robots.inside, duration, limits=joints)


def _loaded(robot: Robot, payload: float) -> Robot:
    return robot.with_payload(payload) if payload != 0.0 else robot


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
