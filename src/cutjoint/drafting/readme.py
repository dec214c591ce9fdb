"""The README of a new robot's folder."""

from __future__ import annotations

from collections.abc import Mapping

from cutjoint.drafting.sketch import Sketch
from cutjoint.drafting.template import Template


def readme_text(
    name: str, template: str, row: Template, sketch: Sketch, sizes: Mapping[str, float], density: float
) -> str:
    """What the files are, how the robot was made, and what to do next."""
    options = "".join(f" --{one} {value:.15g}" for one, value in sizes.items())
    lines = [
        f"# {name}",
        "",
        f"{sketch.title}: {row.about}. Made by",
        "",
        "```sh",
        f"cutjoint new {name} --template {template}{options} --density {density:.15g}",
        "```",
        "",
        "| file | what it says |",
        "|---|---|",
        "| `robot.urdf` | the open tree: links with their masses and shapes, joints with their limits |",
        "| `loops.toml` | what closes it: the cut joints; and the actuators, the tool, the home posture |",
        "",
    ]
    if sizes:
        lines += ["| size | m | what it measures |", "|---|---|---|"]
        lines += [f"| {one} | {value:.15g} | {row.sizes[one].about} |" for one, value in sizes.items()]
        lines.append("")
    lines += [
        f"Motors: {', '.join(f'`{one}`' for one in sketch.driven)}. It can move in {sketch.mobility} "
        f"way{'s' if sketch.mobility > 1 else ''}.",
        "",
        "Next, in this folder:",
        "",
        "```sh",
        "cutjoint check .      # everything that is wrong after a change, and the mobility",
        "cutjoint view .       # in the browser, with a slider per motor",
        "cutjoint simulate .   # under a controller",
        "```",
        "",
    ]
    return "\n".join(lines)
