"""The whole reproduction: every run of both papers, then one page."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cutjoint.errors import UnknownNameError
from cutjoint.experiments import cpm_report, omega3_report
from cutjoint.experiments.pool import Key, Task, run_all
from cutjoint.report import Section

PARTS = {"cpm": cpm_report, "omega3": omega3_report}


def tasks(robots: Sequence[str]) -> dict[tuple[str, Key], Task]:
    """All runs of the named robots; key (robot, run)."""
    for robot in robots:
        if robot not in PARTS:
            raise UnknownNameError("robot with experiments", robot, [*PARTS, "all"])
    return {(robot, key): task for robot in robots for key, task in PARTS[robot].tasks().items()}


def reproduce(robots: Sequence[str], done: Callable[[int], None] | None = None) -> list[Section]:
    """Run everything and lay it out.

    Raises:
        UnknownNameError: no experiments for a robot of that name.
    """
    found = run_all(tasks(robots), done)
    shown: list[Section] = []
    for robot in robots:
        part = {key: value for (owner, key), value in found.items() if owner == robot}
        shown.extend(PARTS[robot].sections(part))
    return shown
