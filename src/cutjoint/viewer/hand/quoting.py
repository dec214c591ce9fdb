"""A posture as text that gives it back: a home posture for loops.toml, and a line of Python.

The numbers are exact, so what is loaded or computed from the text is the posture to rounding.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterable

import numpy as np
import pinocchio as pin

from cutjoint.chain import ClosedChain
from cutjoint.description.formats.common.toml.text import home_lines
from cutjoint.description.model import Home
from cutjoint.errors import CutjointError, InputError
from cutjoint.mechanism import Posture
from cutjoint.viewer.hand.coordinates import coordinates_of
from cutjoint.viewer.hand.lead import tool_pose

SAME = 1e-7
"""Two postures are one where no joint is further apart than this [m] or [rad]."""


def as_toml(chain: ClosedChain, at: Posture) -> str:
    """The lines `[home.NAME]` of a loops.toml, under a name that no home of the robot has yet."""
    values = coordinates_of(chain, at)
    actuated = {actuator.name: values[actuator.name][0] for actuator in chain.actuators}
    passive = {name: value if len(value) > 1 else value[0] for name, value in values.items() if name not in actuated}
    taken = {home.name for home in chain.description.homes}
    name = next(one for one in _names("posture") if one not in taken)
    return "\n".join(home_lines(Home(name, actuated, passive))).strip() + "\n"


def as_python(chain: ClosedChain, at: Posture) -> str:
    """Lines that give the posture from `robot`, the chain as it was loaded, each of them alone: by its actuators and by
    its tool where these lead from home to this posture and no other, else by all its joints."""
    lines = []
    if _gives(chain, at, lambda: chain.close(at.q)):
        lines.append(f"at = robot.close({at.q.tolist()})")
    named = _task_coordinates(chain, at)
    if named and _gives(chain, at, lambda: chain.reach(named)):
        lines.append(f"at = robot.reach({json.dumps(named)})")
    return "\n".join(lines or [f"at = robot.posture({at.q_full.tolist()})"]) + "\n"


def _task_coordinates(chain: ClosedChain, at: Posture) -> dict[str, float]:
    """Coordinates of the tool's task by name; none where the robot has no task."""
    try:
        task = chain.task
    except InputError:
        return {}
    pose = tool_pose(chain, at)
    return {} if pose is None else dict(zip(task.names, task.coordinates(pose).tolist(), strict=True))


def _gives(chain: ClosedChain, at: Posture, way: Callable[[], Posture]) -> bool:
    """Whether a way from home leads to `at`, and not to another branch, a singularity or nowhere."""
    try:
        found = way()
    except CutjointError:
        return False
    apart = pin.difference(chain.model, np.array(at.q_full), np.array(found.q_full))
    return float(np.abs(apart).max(initial=0.0)) < SAME


def _names(stem: str) -> Iterable[str]:
    """stem, stem2, stem3, ..."""
    return itertools.chain([stem], (f"{stem}{number}" for number in itertools.count(2)))
