"""`cutjoint simulate`: one robot, one controller, one trajectory."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cutjoint.commands.motions import HELP, trajectory_of
from cutjoint.commands.output import console, print_json, table

if TYPE_CHECKING:
    from cutjoint.mechanism import Mechanism
    from cutjoint.simulation import Integrator, Result

LONGEST_STEP = 1e-3


def command(
    robot: Annotated[str, typer.Argument(metavar="ROBOT", help="A robot's name, folder or file.")],
    controller: Annotated[
        str,
        typer.Option(metavar="NAME", help="pd, pd-gravity, feedforward, computed-torque, pid, or none for free fall."),
    ] = "computed-torque",
    trajectory: Annotated[str, typer.Option(metavar="SPEC", help=HELP)] = "paper",
    plant: Annotated[
        str, typer.Option(metavar="chain|paper", help="The robot: all joints in Pinocchio, or the published model.")
    ] = "chain",
    model: Annotated[
        str | None,
        typer.Option(
            metavar="chain|paper", help="What the controller believes; default the published model where there is one."
        ),
    ] = None,
    variant: Annotated[str | None, typer.Option(help="Inertias of the chain, such as lumped.")] = None,
    kp: Annotated[str | None, typer.Option(help="Gain: 5, 1,2,3 or [[..],[..],[..]]; default the paper's.")] = None,
    kd: Annotated[str | None, typer.Option(help="Gain, as --kp.")] = None,
    ki: Annotated[str | None, typer.Option(help="Gain of pid, as --kp.")] = None,
    rate: Annotated[
        float | None, typer.Option(metavar="HZ", help="Sample rate of the controller; default continuous control.")
    ] = None,
    limit: Annotated[
        str | None, typer.Option(metavar="N", help="Largest effort of the actuators: 120, or 1,2,3 [N] or [N m].")
    ] = None,
    payload: Annotated[
        float, typer.Option(metavar="KG", help="Mass at the tool that the controller does not know.")
    ] = 0.0,
    duration: Annotated[float | None, typer.Option(metavar="S", help="Default that of the trajectory.")] = None,
    every: Annotated[
        float | None, typer.Option(metavar="S", help="Distance of the samples in the result; default 1 ms or --step.")
    ] = None,
    step: Annotated[
        float | None,
        typer.Option(metavar="S", help="Fixed steps, RK4; default with --rate 1 ms, else adaptive steps (DOP853)."),
    ] = None,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the result: .npz (to load and play) or .csv.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Simulate a robot under a controller and say how well it followed, and whether the simulation can be believed.

    The robot starts at rest in the first desired posture.  A run that cannot go on ends with exit status 2; with
    `--save FILE` what was simulated until then is kept beside it as FILE's name with `.stopped` in it.
    """
    from cutjoint.errors import SimulationError
    from cutjoint.simulation import save as write
    from cutjoint.simulation.files import check_target

    if save is not None:
        check_target(save)
    setup = _prepare(
        robot, controller, trajectory, plant, model, variant, {"kp": kp, "kd": kd, "ki": ki}, payload, duration
    )
    try:
        result = _run(setup, duration, rate, limit, every, step)
    except SimulationError as error:
        if save is not None:
            beside = write(error.result, save.with_name(f"{save.stem}.stopped{save.suffix}"))  # type: ignore[arg-type]
            console().print(f"what was simulated until then: {beside}", soft_wrap=True)
        raise
    figures = _figures(result)
    if save is not None:
        figures["saved"] = str(write(result, save))
    if json:
        print_json(figures)
    else:
        _show(result, figures)


def _prepare(
    robot: str,
    controller: str,
    trajectory: str,
    plant: str,
    model: str | None,
    variant: str | None,
    gains: dict[str, str | None],
    payload: float,
    duration: float | None,
) -> tuple[Any, Any, Any]:
    """Plant, law and reference."""
    from cutjoint.control import law
    from cutjoint.errors import UnknownNameError
    from cutjoint.motion import Reference
    from cutjoint.robots import PUBLISHED, load, published
    from cutjoint.simulation import ConstrainedPlant, ReducedPlant

    for option, value in (("plant", plant), ("model", model)):
        if value not in (None, "chain", "paper"):
            raise UnknownNameError(option, str(value), ("chain", "paper"))
    chain = load(robot, variant)
    name = chain.description.name
    believed = model or ("paper" if name in PUBLISHED else "chain")
    inside: Mechanism = published(name) if believed == "paper" else chain
    made = law(controller, inside, _gains(name, controller, gains))
    if plant == "paper":
        moving: Any = ReducedPlant(_loaded(published(name), payload))
    else:
        moving = ConstrainedPlant(_loaded(chain, payload))
    return moving, made, Reference(trajectory_of(chain, trajectory, inside), inside, duration)


def _loaded(robot: Any, payload: float) -> Any:
    return robot.with_payload(payload) if payload != 0.0 else robot


def _gains(robot: str, controller: str, given: dict[str, str | None]) -> dict[str, Any]:
    """The gains from the command line, or the known ones where none is given."""
    from cutjoint.control import LAWS
    from cutjoint.errors import InputError, UnknownNameError
    from cutjoint.experiments.gains import default_gains

    if controller not in LAWS:
        raise UnknownNameError("controller", controller, list(LAWS))
    gains = {name: _number(f"--{name}", text) for name, text in given.items() if text is not None}
    wanted = LAWS[controller].gains
    if not gains:
        return dict(default_gains(robot, controller))
    missing = [f"--{name}" for name in wanted if name not in gains]
    unused = [f"--{name}" for name in gains if name not in wanted]
    if missing or unused:
        raise InputError(
            f"controller '{controller}' takes {', '.join(f'--{name}' for name in wanted) or 'no gains'}; "
            + "; ".join(
                f"{what} {', '.join(names)}" for what, names in (("missing", missing), ("not used", unused)) if names
            )
        )
    return gains


def _number(option: str, text: str) -> Any:
    """One number, several with commas, or a matrix in JSON."""
    import json

    from cutjoint.errors import InputError

    try:
        if text.lstrip().startswith("["):
            return json.loads(text)
        numbers = [float(one) for one in text.split(",")]
    except ValueError as error:
        raise InputError(f"{option} must be a number, numbers with commas, or [[..],[..]]; found '{text}'") from error
    return numbers[0] if len(numbers) == 1 else numbers


def _run(
    setup: tuple[Any, Any, Any],
    duration: float | None,
    rate: float | None,
    limit: str | None,
    every: float | None,
    step: float | None,
) -> Result:
    from rich.progress import Progress

    from cutjoint.simulation import Adaptive, RungeKutta4, run

    plant, law, reference = setup
    method: Integrator = Adaptive(1e-8, 1e-10)
    if step is not None or rate is not None:
        method = RungeKutta4(LONGEST_STEP if step is None else step)
    with Progress(transient=True) as bar:
        task = bar.add_task(f"{plant.name}, {law.name}", total=reference.duration)
        return run(
            plant,
            law,
            reference,
            integrator=method,
            rate=rate,
            limits=None if limit is None else _number("--limit", limit),
            every=max(LONGEST_STEP, step or 0.0) if every is None else every,
            progress=lambda t: bar.update(task, completed=t),
        )


def _figures(result: Result) -> dict[str, Any]:
    """What a run comes to."""
    rms, over_time, gap = result.rmse(), result.rmse_over_time(), result.loop_gap()
    return {
        **{key: result.about[key] for key in ("plant", "law", "gains", "trajectory", "integrator", "rate", "limits")},
        "samples": len(result),
        "duration_s": float(result.time[-1]),
        "error_rms_m": rms.position,
        "error_rms_m_per_s": rms.velocity,
        "error_rms_over_time_m": over_time.position,
        "error_worst_m": result.worst_error(),
        "error_last_m": result.worst_error(float(result.time[-1])),
        "effort_peak": {
            row[0]: peak for row, peak in zip(result.about["actuators"], result.peak_effort(), strict=True)
        },
        "loop_gap_m": gap[0],
        "loop_gap_rad": gap[1],
        "loop_gap_before_projection_m": result.about["strayed"],
        "energy_drift": result.energy_drift(),
        "steps": result.about["steps"],
        "evaluations": result.about["evaluations"],
    }


def _show(result: Result, figures: dict[str, Any]) -> None:
    shown = table(f"{figures['plant']}: {figures['law']}, {figures['trajectory']}", ("", ""))
    gains = ", ".join(f"{name} {_short(value)}" for name, value in figures["gains"].items()) or "none"
    rate = "continuous" if figures["rate"] is None else f"{figures['rate']:g} Hz, held in between"
    units = {row[0]: "N" if row[1] == "translation" else "N m" for row in result.about["actuators"]}
    rows = (
        ("gains", gains),
        ("control", rate),
        ("integrator", f"{figures['integrator']}: {figures['steps']} steps, {figures['evaluations']} evaluations"),
        ("tool error", f"{figures['error_rms_m']:.4g} m rms of {figures['samples']} samples"),
        ("", f"{figures['error_rms_over_time_m']:.4g} m rms over time"),
        ("", f"{figures['error_worst_m']:.4g} m at worst, {figures['error_last_m']:.4g} m at the end"),
        ("tool velocity error", f"{figures['error_rms_m_per_s']:.4g} m/s rms of the samples"),
        ("peak effort", ", ".join(f"{name} {peak:.4g} {units[name]}" for name, peak in figures["effort_peak"].items())),
        ("loops", f"closed to {figures['loop_gap_m']:.1e} m, {figures['loop_gap_rad']:.1e} rad"),
        ("", f"steps strayed by up to {figures['loop_gap_before_projection_m']:.1e} m before they were put back"),
        ("energy balance", f"off by {figures['energy_drift']:.1e} of the energy turned over"),
    )
    for row in rows:
        shown.add_row(*row)
    if "saved" in figures:
        shown.add_row("saved", figures["saved"])
    shown.print()


def _short(gain: list[list[float]]) -> str:
    rows = [" ".join(f"{value:g}" for value in row) for row in gain]
    return rows[0] if len(rows) == 1 else f"[{'; '.join(rows)}]"
