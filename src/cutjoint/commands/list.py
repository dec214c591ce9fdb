"""`cutjoint list`: the robots that cutjoint knows."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from cutjoint.commands.output import TerminalTable, print_json


def command(
    examples: Annotated[bool, typer.Option("--examples", help="Also those of the package example-robot-data.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Machine-readable output.")] = False,
) -> None:
    """The robots that cutjoint knows by name.

    Any of them, and any path to a robot's file or folder, can stand where a command asks for ROBOT.
    """
    from cutjoint.description import catalogue, load_description
    from cutjoint.robots import PUBLISHED

    rows: list[dict[str, Any]] = []
    for name in catalogue.names():
        robot = load_description(name)
        rows.append(
            {
                "name": name,
                "title": robot.title,
                "actuators": len(robot.actuators),
                "cuts": len(robot.cuts) + len(robot.couplings),
                "variants": [variant.name for variant in robot.variants],
                "published_model": name in PUBLISHED,
            }
        )
    others = list(catalogue.example_names()) if examples else []
    if json:
        print_json({"robots": rows, "examples": others})
        return
    shown = TerminalTable("robots of cutjoint", ("robot", "title", "actuators", "cuts", "variants", "published model"))
    for row in rows:
        shown.add_row(
            row["name"],
            row["title"],
            str(row["actuators"]),
            str(row["cuts"]),
            ", ".join(row["variants"]) or "-",
            "yes" if row["published_model"] else "-",
        )
    shown.print()
    if examples:
        typer.echo("example-robot-data: " + (", ".join(others) or "not installed (pip install example-robot-data)"))
