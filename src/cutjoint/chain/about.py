"""A closed chain in a small table: what it is called, what drives it, where it is cut, and what its tool can do."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cutjoint.description.model import RobotDescription
from cutjoint.mechanism import Actuator
from cutjoint.reprs import clipped, listed
from cutjoint.tables import TextTable


def chain_table(description: RobotDescription, actuators: Sequence[Actuator], task: Callable[[], str]) -> TextTable:
    """The parts of a robot.

    Args:
        description: of it.
        actuators: with their units.
        task: tells which motions of the tool are led.
    """
    moving = [one for one in description.joints if one.type.moves]
    rows = [
        ("actuators", listed([f"{one.name} [{one.unit}]" for one in actuators]) or "none"),
        ("joints that move", str(len(moving))),
        ("cuts", listed([f"{one.name} ({one.type})" for one in description.cuts]) or "none"),
    ]
    if description.couplings:
        rows.append(("couplings", listed([one.name for one in description.couplings])))
    if description.tool is not None:
        rows += [("tool", f"on {clipped(description.tool.link)}"), ("task", clipped(task(), 200))]
    mass = sum(link.inertial.mass for link in description.links if link.inertial is not None)
    rows.append(("mass", f"{mass:.6g} kg"))
    return TextTable(clipped(description.title or description.name, 80), ("", ""), rows)
