"""`cutjoint retime --to`: moves from point to point, and how points are told on the command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cutjoint import interrupts
from cutjoint.commands.options import assigned, numbers
from cutjoint.commands.output import print_json, say, show
from cutjoint.commands.progress import progress
from cutjoint.errors import InputError, UnknownNameError, shown
from cutjoint.mechanism import Pose
from cutjoint.mechanism.task import NAMES

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain
    from cutjoint.mechanism import Loads, Posture
    from cutjoint.retiming import MotionLimits, Moved

FORM = "home, Q1,Q2,... of the actuators, or NAME=VALUE,... of actuators or of the task"


def run(
    chain: ClosedChain,
    to: Sequence[str],
    limits: MotionLimits,
    acting: Loads,
    *,
    save: Path | None,
    output: Path | None,
    json: bool,
) -> None:
    """The quickest moves from home through points, told, written and drawn."""
    from cutjoint.report.answers.moves import moves_sheet
    from cutjoint.report.answers.sheet import write_sheet
    from cutjoint.retiming import quickest_moves

    points = points_of(chain, to)
    with progress(f"{chain.name}: moving", 100.0, "%") as told:
        found = quickest_moves(chain, points, limits, loads=acting, progress=lambda part: told(round(100.0 * part)))
    written = []
    with interrupts.keeping():
        if save is not None:
            written.append(found.save(save))
        if output is not None:
            written.append(write_sheet(moves_sheet(found), output))
    if json:
        print_json(_data(found, written))
        return
    _tell(found)
    for one in written:
        say(f"wrote {one}")


def points_of(chain: ClosedChain, to: Sequence[str]) -> list[Posture]:
    """The postures that are named; what a point by names leaves out stays as at the point before.

    Raises:
        InputError, UnknownNameError: a text is no point; or as of `close` and `reach`.
    """
    found, before = [], chain.home
    for text in to:
        if text.strip() == "home":
            before = chain.home
        elif "=" in text:
            before = _named(chain, text, before)
        else:
            before = chain.close(np.atleast_1d(np.asarray(numbers("--to", text), dtype=np.float64)), before)
        found.append(before)
    return found


def _named(chain: ClosedChain, text: str, before: Posture) -> Posture:
    values = {}
    for name, word in assigned("--to", f"--to {FORM}", text.split(",")).items():
        try:
            values[name] = float(word)
        except ValueError as error:
            raise InputError(f"--to: {shown(name)} must be a number [m or rad], found '{shown(word)}'") from error
    actuators = [one.name for one in chain.actuators]
    if all(name in actuators for name in values):
        q = [values.get(name, float(now)) for name, now in zip(actuators, before.q, strict=True)]
        return chain.close(q, before)
    for name in values:
        if name not in NAMES and name not in actuators:
            raise UnknownNameError("actuator or coordinate of the task", name, [*actuators, *NAMES])
    if not all(name in NAMES for name in values):
        raise InputError(f"--to {shown(text)}: a point is told by actuators or by the task, not by both")
    task = chain.task
    unled = [name for name in values if name not in task.names]
    if unled:
        raise InputError(f"--to: {', '.join(unled)} of the tool is not led by the actuators; these are: {task}")
    tool = chain.tool(before)
    now = dict(zip(task.names, task.coordinates(Pose(tool.position, tool.rotation)).tolist(), strict=True))
    return chain.reach({**now, **values}, before)


def _tell(found: Moved) -> None:
    count = len(found.slowed)
    say(f"{found.name}: {found.duration:.5g} s for {count} move{'s' if count > 1 else ''}, at rest at each point")
    say(
        f"loops closed to {found.gap[0]:.1e} m and {found.gap[1]:.1e} rad at {found.checked} instants; joint limits "
        "and branch kept"
    )
    for one in found.told:
        say(one, first="  ")
    say()
    show(found.stops_table())
    say()
    show(found.table())


def _data(found: Moved, written: Sequence[Path]) -> Mapping[str, object]:
    names = ("name", "duration", "closed", "stops", "points", "slowed", "checked", "gap")
    data: dict[str, object] = {name: getattr(found, name) for name in names}
    data["actuators"] = [one.name for one in found.actuators]
    fields = ("quantity", "largest", "limit", "unit", "part", "t", "active")
    data["peaks"] = [{name: getattr(one, name) for name in fields} for one in found.peaks]
    data["told"] = list(found.told)
    if written:
        data["written"] = [str(one) for one in written]
    return data
