"""`cutjoint simulate`: one robot, one controller, one trajectory."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from cutjoint.commands import options
from cutjoint.commands.options import CONTROLLERS, HELP, gains_of, numbers, trajectory_of, with_gains
from cutjoint.commands.output import TerminalTable, console, print_json

if TYPE_CHECKING:
    from collections.abc import Mapping

    from cutjoint.control import Law
    from cutjoint.mechanism import Mechanism
    from cutjoint.motion import Reference
    from cutjoint.simulation import Integrator, Plant, Result

LONGEST_STEP = 1e-3
SETTINGS = ("plant", "law", "gains", "trajectory", "integrator", "rate", "limits")
Robot = TypeVar("Robot", bound="Mechanism")


@with_gains
def command(
    robot: options.Robot,
    controller: Annotated[str, typer.Option(metavar="NAME", help=CONTROLLERS)] = "computed-torque",
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
    variant: options.Variant = None,
    rate: Annotated[
        float | None, typer.Option(metavar="HZ", help="Sample rate of the controller; default continuous control.")
    ] = None,
    limit: Annotated[
        str | None, typer.Option(metavar="N", help="Largest effort of the actuators: 120, or 1,2,3 [N] or [N m].")
    ] = None,
    payload: Annotated[float, typer.Option(metavar="KG", help="Mass at the tool, unknown to the controller.")] = 0.0,
    duration: Annotated[float | None, typer.Option(metavar="S", help="Default that of the trajectory.")] = None,
    every: Annotated[
        float | None, typer.Option(metavar="S", help="Distance of the samples in the result; default 1 ms or --step.")
    ] = None,
    step: Annotated[
        float | None,
        typer.Option(metavar="S", help="Fixed steps, RK4; default with --rate 1 ms, else adaptive steps (DOP853)."),
    ] = None,
    save: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the result: .npz (to play) or .csv.")] = None,
    json: options.Json = False,
    **gains: str | None,
) -> None:
    """Simulate a robot under a controller and say how well it followed, and whether the simulation can be believed.

    The robot starts at rest in the first desired posture.  A run that cannot go on ends with exit status 2; with
    `--save FILE` what was simulated until then is kept beside it as FILE's name with `.stopped` in it.
    """
    from cutjoint.errors import SimulationError
    from cutjoint.simulation import save as write
    from cutjoint.simulation.result import check_target

    if save is not None:
        check_target(save)
    setup = _prepare(robot, controller, trajectory, plant, model, variant, gains, payload, duration)
    try:
        result = _run(*setup, rate, limit, every, step)
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
    gains: Mapping[str, str | None],
    payload: float,
    duration: float | None,
) -> tuple[Plant, Law, Reference]:
    """What moves, its controller and what it follows."""
    from cutjoint.control import law
    from cutjoint.errors import UnknownNameError
    from cutjoint.motion import Reference
    from cutjoint.robots import PUBLISHED, load, published
    from cutjoint.simulation import ConstrainedPlant, ReducedPlant

    for option, side in (("plant", plant), ("model", model)):
        if side not in (None, "chain", "paper"):
            raise UnknownNameError(option, str(side), ("chain", "paper"))
    chain = load(robot, variant)
    name = chain.description.name
    believes = model or ("paper" if name in PUBLISHED else "chain")
    inside: Mechanism = published(name) if believes == "paper" else chain
    made = law(controller, inside, gains_of(name, controller, gains))
    moving: Plant
    if plant == "paper":
        moving = ReducedPlant(_loaded(published(name), payload))
    else:
        moving = ConstrainedPlant(_loaded(chain, payload))
    return moving, made, Reference(trajectory_of(chain, trajectory, inside), inside, duration)


def _loaded(robot: Robot, payload: float) -> Robot:
    return robot.with_payload(payload) if payload != 0.0 else robot


def _run(
    plant: Plant,
    law: Law,
    reference: Reference,
    rate: float | None,
    limit: str | None,
    every: float | None,
    step: float | None,
) -> Result:
    from rich.progress import Progress

    from cutjoint.simulation import Adaptive, RungeKutta4, run

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
            limits=None if limit is None else numbers("--limit", limit),
            every=max(LONGEST_STEP, step or 0.0) if every is None else every,
            progress=lambda t: bar.update(task, completed=t),
        )


def _figures(result: Result) -> dict[str, object]:
    """What a run comes to."""
    rms, over_time, gap = result.rmse(), result.rmse_over_time(), result.loop_gap()
    return {
        **{key: value for key, value in result.about.items() if key in SETTINGS},
        "samples": len(result),
        "duration_s": float(result.time[-1]),
        "error_rms_m": rms.position,
        "error_rms_m_per_s": rms.velocity,
        "error_rms_over_time_m": over_time.position,
        "error_worst_m": result.worst_error(),
        "error_last_m": result.worst_error(float(result.time[-1])),
        "effort_peak": {name: peak for name, _, peak in _peaks(result)},
        "loop_gap_m": gap[0],
        "loop_gap_rad": gap[1],
        "loop_gap_before_projection_m": result.about["strayed"],
        "energy_drift": result.energy_drift(),
        "steps": result.about["steps"],
        "evaluations": result.about["evaluations"],
    }


def _peaks(result: Result) -> list[tuple[str, str, float]]:
    """Name, unit of its effort, and largest effort of every actuator."""
    rows = zip(result.about["actuators"], result.peak_effort(), strict=True)
    return [(name, "N" if kind == "translation" else "N m", float(peak)) for (name, kind), peak in rows]


def _show(result: Result, figures: dict[str, object]) -> None:
    shown = TerminalTable(f"{figures['plant']}: {figures['law']}, {figures['trajectory']}", ("", ""))
    gains = ", ".join(f"{name} {_short(value)}" for name, value in result.about["gains"].items()) or "none"
    rate = "continuous" if figures["rate"] is None else f"{figures['rate']:g} Hz, held in between"
    rows = (
        ("gains", gains),
        ("control", rate),
        ("integrator", f"{figures['integrator']}: {figures['steps']} steps, {figures['evaluations']} evaluations"),
        ("tool error", f"{figures['error_rms_m']:.4g} m rms of {figures['samples']} samples"),
        ("", f"{figures['error_rms_over_time_m']:.4g} m rms over time"),
        ("", f"{figures['error_worst_m']:.4g} m at worst, {figures['error_last_m']:.4g} m at the end"),
        ("tool velocity error", f"{figures['error_rms_m_per_s']:.4g} m/s rms of the samples"),
        ("peak effort", ", ".join(f"{name} {peak:.4g} {unit}" for name, unit, peak in _peaks(result))),
        ("loops", f"closed to {figures['loop_gap_m']:.1e} m, {figures['loop_gap_rad']:.1e} rad"),
        ("", f"steps strayed by up to {figures['loop_gap_before_projection_m']:.1e} m before they were put back"),
        ("energy balance", f"off by {figures['energy_drift']:.1e} of the energy turned over"),
    )
    for row in rows:
        shown.add_row(*row)
    if "saved" in figures:
        shown.add_row("saved", str(figures["saved"]))
    shown.print()


def _short(gain: list[list[float]]) -> str:
    rows = [" ".join(f"{value:g}" for value in row) for row in gain]
    return rows[0] if len(rows) == 1 else f"[{'; '.join(rows)}]"
