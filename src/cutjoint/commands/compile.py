"""`cutjoint compile`: a robot as straight-line machine code, with what that costs and what it gives."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from cutjoint import interrupts
from cutjoint.commands import options
from cutjoint.commands.output import print_json, show
from cutjoint.commands.progress import progress
from cutjoint.commands.stopping import stopped
from cutjoint.tables import TextTable

if TYPE_CHECKING:
    from cutjoint.compile import Compiled, Made
    from cutjoint.mechanism import Mechanism

USUAL = ("forward", "inverse", "terms", "tool", "step", "reach_step")


def command(
    robot: options.Robot,
    variant: options.Variant = None,
    lenient: options.Lenient = False,
    published: Annotated[bool, typer.Option("--published", help="The paper's reduced model instead.")] = False,
    functions: Annotated[
        str, typer.Option(help="What to compile: names separated by commas, or `all`.  Default: the usual ones.")
    ] = "",
    arguments: Annotated[
        str,
        typer.Option(
            help="Numbers that stay arguments, separated by commas: payload, and paths such as links.rod.mass or "
            "joints.elbow.origin.x."
        ),
    ] = "",
    fast: Annotated[bool, typer.Option("--fast", help="Fast-math: other digits in the last places.")] = False,
    cache: Annotated[bool, typer.Option("--cache/--no-cache", help="Use the user's cache folder.")] = True,
    measure: Annotated[bool, typer.Option("--measure", help="Also time every function.")] = False,
    json: options.Json = False,
) -> None:
    """Compile a robot's dynamics and say what became of it; later runs find the instructions in the cache."""
    from cutjoint.compile import compiled, functions_of
    from cutjoint.robots import load
    from cutjoint.robots import published as published_model

    made: list[Made] = []
    model: Mechanism = published_model(robot) if published else load(robot, variant, lenient=lenient)
    mechanism = compiled(model, parameters=_names(arguments), fast=fast, cached=cache, report=made.append)
    known = functions_of(mechanism)
    usual = tuple(name for name in known if name in USUAL)
    chosen = _names(functions) or usual or known
    chosen = known if chosen == ("all",) else chosen
    try:
        with interrupts.asking(), progress(f"{mechanism.name}: compiling", len(chosen), "functions") as told:
            for number, name in enumerate(chosen):
                told(number)
                mechanism.kernel(name)
            times = {one.what: _measured(mechanism, one.what) for one in made} if measure else {}
    except KeyboardInterrupt:
        names = ", ".join(one.what for one in made) or "nothing"
        raise stopped(f"compiled until then: {names}" + (", kept in the cache" if cache and made else "")) from None
    if json:
        print_json([_data(one, times.get(one.what)) for one in made])
    else:
        _show(mechanism, made, times)


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())


def _data(one: Made, times: tuple[float, float] | None) -> dict[str, object]:
    found: dict[str, object] = {
        "function": one.what,
        "operations": one.operations,
        "cached": one.cached,
        "trace_s": one.trace_time,
        "compile_s": one.compile_time,
    }
    if times is not None:
        found["scalar_ns"], found["batch_ns"] = times
    return found


def _show(mechanism: Compiled, made: list[Made], times: dict[str, tuple[float, float]]) -> None:
    right = ["operations", "trace", "compile", "scalar", "batch"]
    columns = ["function", "operations", "trace", "compile"] + (["scalar", "batch"] if times else [])
    rows = []
    for one in made:
        trace = "cached" if one.cached else f"{one.trace_time:.2f} s"
        cells = [one.what, str(one.operations), trace, f"{one.compile_time:.2f} s"]
        if times:
            cells += [f"{value:.0f} ns" for value in times[one.what]]
        rows.append(cells)
    show(TextTable(mechanism.name, columns, rows, right))


def _measured(mechanism: Compiled, what: str) -> tuple[float, float]:
    """Nanoseconds an evaluation at home takes on one core: one after another, and side by side."""
    import time

    import numpy as np

    kernel = mechanism.kernel(what)
    home = mechanism.positions(mechanism.home)
    values = {"q": home, "target": mechanism.home.q, "parameters": np.array(list(mechanism.parameters.values()))}
    if "p" in dict(kernel.program.arguments):
        values["p"] = mechanism.tool(mechanism.home).position
    count = 4096
    given = []
    for name, size in kernel.program.arguments:
        row = values.get(name)
        given.append(np.tile(np.full(size, 0.1) if row is None else row, (count, 1)))
    found = []
    for lanes in (False, True):
        spent = []
        for _ in range(5):
            start = time.process_time()
            kernel.batch(given, lanes=lanes)
            spent.append(time.process_time() - start)
        found.append(1e9 * min(spent) / count)
    return found[0], found[1]
