"""`cutjoint crosscheck`: closed chains against the published models."""

from __future__ import annotations

import json as json_module
from collections.abc import Callable, Iterator
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint import interrupts
from cutjoint.commands import completing, options
from cutjoint.commands.output import plain, print_json, say, show
from cutjoint.commands.progress import progress
from cutjoint.commands.stopping import stopped, stopped_name
from cutjoint.files import check_place, write_whole
from cutjoint.tables import TextTable
from cutjoint.texts import Cell

if TYPE_CHECKING:
    from cutjoint.crosscheck import Comparison, Cost, SampledState


class Engine(StrEnum):
    """What a closed chain is compared with."""

    PAPER = "paper"
    MUJOCO = "mujoco"
    YOURDFPY = "yourdfpy"


# long: its options, a line or three each
def command(
    robot: Annotated[
        str,
        typer.Argument(
            metavar="[ROBOT]", help="A robot with a published model, or all.", autocompletion=completing.published
        ),
    ] = "all",
    samples: Annotated[int, typer.Option(min=1, help="Random reachable states per robot.")] = 1000,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the random states.")] = 0,
    variant: Annotated[
        str | None,
        typer.Option(
            help="Inertias of the chain; default the paper's hypothesis. With `distributed` the hypothesis' cost.",
            autocompletion=completing.variants,
        ),
    ] = None,
    engine: Annotated[
        Engine,
        typer.Option(
            help="Against what: the paper's model, MuJoCo's dynamics (if installed), or yourdfpy's kinematics."
        ),
    ] = Engine.PAPER,
    lenient: options.Lenient = False,
    json: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Also write the figures as JSON; - for stdout.")
    ] = None,
) -> None:
    """Compare the closed chain in Pinocchio with the model that the robot's paper derives by hand.

    Random reachable postures, velocities and accelerations; position and orientation of the tool, Jacobian, J_dot v,
    mass matrix, Coriolis vector, gravity, inverse and forward dynamics of both.  The two share no code and no data, so
    agreement is evidence.
    With `--variant distributed` the rods are uniform, which the papers' models are not: what their hypothesis costs
    along the paper's own trajectory is shown instead.  Exit status 1 where a tolerance is exceeded.  Interrupted
    (Ctrl-C), it tells what came of the states until then; the JSON is then in FILE's name with `.stopped` in it.
    """
    from cutjoint.robots import PUBLISHED, hypothesis_cost_of, published

    if json is not None and not _quiet(json):
        check_place(json)
    names = list(PUBLISHED) if robot == "all" else [robot]
    if engine is Engine.PAPER:
        for name in names:
            published(name)
        if variant is not None and all(variant == PUBLISHED[name].physical for name in names):
            costs = {name: hypothesis_cost_of(name) for name in names}
            for name, cost in costs.items():
                if not _quiet(json):
                    _show_cost(name, cost)
            _emit(json, {name: _cost_data(cost) for name, cost in costs.items()})
            return
    comparisons: dict[str, Comparison] = {}
    with interrupts.keeping():
        try:
            for name in names:
                comparisons[name] = _compare(name, engine, variant, samples, seed, lenient)
        except KeyboardInterrupt:
            if not comparisons:
                raise
        for comparison in comparisons.values():
            if not _quiet(json):
                _show(comparison)
        file = json if json is None or _quiet(json) or not interrupts.came() else stopped_name(json)
        _emit(file, {name: _comparison_data(comparison, seed) for name, comparison in comparisons.items()})
        if interrupts.came():
            count = ", ".join(f"{one.samples} of {samples} states of {name}" for name, one in comparisons.items())
            raise stopped(f"compared {count}" + ("" if file is None or _quiet(file) else f"; kept in {file}"))
    raise typer.Exit(0 if all(comparison.passes for comparison in comparisons.values()) else 1)


def _quiet(json: Path | None) -> bool:
    return json is not None and str(json) == "-"


def _emit(json: Path | None, data: dict[str, object]) -> None:
    if json is None:
        return
    if _quiet(json):
        print_json(data)
    else:
        write_whole(json, json_module.dumps(plain(data), indent=2) + "\n")


def _compare(name: str, engine: Engine, variant: str | None, samples: int, seed: int, lenient: bool) -> Comparison:
    """The chain of a robot against the engine at random states, with a bar that shows how far it is."""
    from cutjoint.crosscheck import compare, sample_states
    from cutjoint.engines.compare import compare_with_mujoco
    from cutjoint.engines.yourdfpy import compare_with_yourdfpy
    from cutjoint.robots import PUBLISHED, Dynamics, load, published

    hypothesis = PUBLISHED[name].variant if name in PUBLISHED else None
    with interrupts.asking():
        # the papers' joints move freely
        dynamics: Dynamics = "ideal" if engine is Engine.PAPER else "real"
        chain = load(name, variant or hypothesis, dynamics=dynamics, lenient=lenient)
        reference = published(name) if name in PUBLISHED else chain
        states = sample_states(reference, samples, seed)
        first = next(states)
    against: dict[Engine, Callable[..., Comparison]] = {
        Engine.PAPER: partial(compare, chain, reference),
        Engine.MUJOCO: partial(compare_with_mujoco, chain),
        Engine.YOURDFPY: partial(compare_with_yourdfpy, chain),
    }
    with progress(f"{chain.name}: cross-check", samples, "states") as told:
        return against[engine](_until_interrupted(first, states), told)


def _until_interrupted(first: SampledState, more: Iterator[SampledState]) -> Iterator[SampledState]:
    """The states, no further ones after an interrupt."""
    yield first
    while not interrupts.waiting():
        try:
            yield next(more)
        except StopIteration:
            return


def _show(comparison: Comparison) -> None:
    title = f"{comparison.checked}, Pinocchio closed chain, against {comparison.reference}: {comparison.samples} states"
    rows = [
        (
            row.quantity,
            f"{row.error:.1e}",
            f"{row.tolerance:.0e}",
            Cell("agrees", "good") if row.passes else Cell("DISAGREES", "bad"),
        )
        for row in comparison.rows
    ]
    columns = ("quantity", "worst error", "tolerance", "")
    show(TextTable(title, columns, rows, right=columns[1:3]))
    if comparison.refused:
        count = f"{comparison.refused} states could not be taken up by the chain"
        say(Cell(count, "bad"), f": {comparison.reason}")


def _comparison_data(comparison: Comparison, seed: int) -> dict[str, object]:
    return {
        "checked": comparison.checked,
        "reference": comparison.reference,
        "samples": comparison.samples,
        "seed": seed,
        "passes": comparison.passes,
        "refused": comparison.refused,
        "quantities": {
            row.quantity: {"worst_relative_error": row.error, "tolerance": row.tolerance, "passes": row.passes}
            for row in comparison.rows
        },
    }


def _show_cost(name: str, cost: Cost) -> None:
    columns = ("actuator", "peak effort", "error", "of peak", "of inertial peak")
    title = f"{name}: what the paper's lumped rods cost along its own trajectory"
    show(TextTable(title, columns, cost.rows, right=columns[1:]))


def _cost_data(cost: Cost) -> dict[str, object]:
    return {
        actuator: {
            "unit": cost.units[i],
            "peak_effort": cost.peak[i],
            "error": cost.error[i],
            "percent_of_peak": cost.percent[i],
            "percent_of_inertial_peak": cost.percent_inertial[i],
        }
        for i, actuator in enumerate(cost.actuators)
    }
