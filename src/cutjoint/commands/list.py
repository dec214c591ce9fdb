"""`cutjoint list`: the robots that cutjoint knows."""

from __future__ import annotations

from typing import Annotated

import typer

from cutjoint.commands import options
from cutjoint.commands.output import TerminalTable, print_json
from cutjoint.extras import how_to_get


def command(
    examples: Annotated[bool, typer.Option("--examples", help="Also those of the package example-robot-data.")] = False,
    json: options.Json = False,
) -> None:
    """The robots that cutjoint knows by name.

    Any of them, and any path to a robot's file or folder, can stand where a command asks for ROBOT.
    """
    from cutjoint.description import catalogue, load_description
    from cutjoint.robots import PUBLISHED

    rows = []
    shown = TerminalTable("robots of cutjoint", ("robot", "title", "actuators", "cuts", "variants", "published model"))
    for name in catalogue.names():
        robot = load_description(name)
        actuators, cuts = len(robot.actuators), len(robot.cuts) + len(robot.couplings)
        variants, known = [variant.name for variant in robot.variants], name in PUBLISHED
        data = {"name": name, "title": robot.title, "actuators": actuators, "cuts": cuts}
        rows.append({**data, "variants": variants, "published_model": known})
        cells = (str(actuators), str(cuts), ", ".join(variants) or "-", "yes" if known else "-")
        shown.add_row(name, robot.title, *cells)
    others = list(catalogue.example_names()) if examples else []
    if json:
        print_json({"robots": rows, "examples": others})
        return
    shown.print()
    if examples:
        absent = f"not installed ({how_to_get('example_robot_data')})"
        typer.echo(f"example-robot-data: {', '.join(others) or absent}")
