"""`cutjoint list`: the robots that cutjoint knows."""

from __future__ import annotations

from typing import Annotated

import typer

from cutjoint.commands import options
from cutjoint.commands.output import print_json, say, show
from cutjoint.tables import TextTable


def command(
    examples: Annotated[bool, typer.Option("--examples", help="Also those of the package example-robot-data.")] = False,
    json: options.Json = False,
) -> None:
    """The robots that cutjoint knows by name.

    Any of them, and any path to a robot's file or folder, can stand where a command asks for ROBOT.
    """
    from cutjoint.description import catalogue, load_description
    from cutjoint.robots import PUBLISHED

    rows, cells = [], []
    columns = ("robot", "title", "actuators", "cuts", "variants", "published model")
    for name in catalogue.names():
        robot = load_description(name)
        actuators, cuts = len(robot.actuators), len(robot.cuts) + len(robot.couplings)
        variants, known = [variant.name for variant in robot.variants], name in PUBLISHED
        data = {"name": name, "title": robot.title, "actuators": actuators, "cuts": cuts}
        rows.append({**data, "variants": variants, "published_model": known})
        counts = str(actuators), str(cuts)
        cells.append((name, robot.title, *counts, ", ".join(variants) or "-", "yes" if known else "-"))
    others = list(catalogue.example_names()) if examples else []
    if json:
        print_json({"robots": rows, "examples": others})
        return
    show(TextTable("robots of cutjoint", columns, cells, right=columns[2:4]))
    if examples:
        say("example-robot-data: " + (", ".join(others) or "not installed (pip install example-robot-data)"))
