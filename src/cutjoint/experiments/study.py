"""The whole reproduction: every run of both papers, then one page; of one that was interrupted what there is, and the
next one goes on from there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import cast

from cutjoint.errors import Interrupted, UnknownNameError
from cutjoint.experiments import cpm_report, omega3_report, unfinished
from cutjoint.pool import Key, Outcome, Task, run_all
from cutjoint.report import Section
from cutjoint.tables import TextTable

PARTS = {"cpm": cpm_report, "omega3": omega3_report}
Found = dict[tuple[str, Key], Outcome]


class _Missing(Exception):
    """A run that a part of the page needs is not done."""


class _Done(dict[Key, Outcome]):
    """The runs of a robot that are done."""

    def __missing__(self, key: Key) -> Outcome:
        raise _Missing(key)


def tasks(robots: Sequence[str]) -> dict[tuple[str, Key], Task]:
    """All runs of the named robots; key (robot, run).

    Raises:
        UnknownNameError: no experiments for a robot of that name.
    """
    for robot in robots:
        if robot not in PARTS:
            raise UnknownNameError("robot with experiments", robot, [*PARTS, "all"])
    return {(robot, key): task for robot in robots for key, task in PARTS[robot].tasks().items()}


def reproduce(robots: Sequence[str], done: Callable[[int], None] | None = None) -> list[Section]:
    """Run everything and lay it out.  `done` is told how many runs are done, those of an interrupted reproduction by
    the same code included, which are not run again.

    Raises:
        UnknownNameError: no experiments for a robot of that name.
        Interrupted: a `KeyboardInterrupt` came; `result` holds the parts of the page whose runs were done.
    """
    wanted = tasks(robots)
    found: Found = {(robot, key): one for robot in robots for key, one in unfinished.take(robot).items()}
    found = {key: one for key, one in found.items() if key in wanted}
    known = len(found)

    def told(count: int) -> None:
        if done is not None:
            done(known + count)

    told(0)
    try:
        found |= run_all({key: task for key, task in wanted.items() if key not in found}, told)
    except Interrupted as error:
        found |= cast("Found", error.result)
        kept = [unfinished.keep(robot, _of(robot, found)) for robot in robots]
        told_kept = "the next reproduction goes on from there" if all(kept) else "the cache folder cannot be written"
        words = f"{len(found)} of {len(wanted)} runs are done, {told_kept}"
        page = _partly(robots, found, wanted, words)
        raise Interrupted(words, done=len(found) / len(wanted), result=page) from error
    sections = [part(_of(robot, found)) for robot in robots for part in PARTS[robot].SECTIONS]
    for robot in robots:
        unfinished.drop(robot)
    return sections


def _of(robot: str, found: Found) -> _Done:
    return _Done({key: value for (owner, key), value in found.items() if owner == robot})


def _partly(robots: Sequence[str], found: Found, wanted: dict[tuple[str, Key], Task], words: str) -> list[Section]:
    """What can be laid out of the runs that are done, behind a list of all of them."""
    rows = [(robot, str(key), "done" if (robot, key) in found else "not done") for robot, key in wanted]
    shown = [
        Section(
            "Interrupted",
            (
                f"This reproduction was interrupted: {words}. Parts whose runs are not all done are left out.",
                TextTable("Runs", ("robot", "run", "state"), rows),
            ),
            level=2,
        )
    ]
    for robot in robots:
        for part in PARTS[robot].SECTIONS:
            try:
                shown.append(part(_of(robot, found)))
            except _Missing:
                continue
    return shown
