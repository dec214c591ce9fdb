"""Working modes and assembly modes: what is held, whether the modes are discrete, and the search for them.

- *Working modes* are the solutions of inverse kinematics: the tool is held, the limbs differ.
- *Assembly modes* are the solutions of forward kinematics: the actuators are held, the tool differs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.closing.continuation import Assembler, Driver
from cutjoint.chain.kinematics import Kinematics, Placed, joints_of
from cutjoint.chain.modes.limits import Limits
from cutjoint.chain.modes.listing import Found, Listing
from cutjoint.chain.modes.result import Modes
from cutjoint.chain.modes.search import Equations, Search
from cutjoint.chain.modes.shape import Shapes
from cutjoint.chain.modes.task import WAYS, Held, holding, task_of
from cutjoint.chain.rank import rank_of
from cutjoint.errors import ActuationError, InputError
from cutjoint.mechanism import Posture

MOST_STARTS = 2000
"""Starts at most, unless asked otherwise: ten seconds for a robot of twenty joints."""


@dataclass(frozen=True, eq=False)
class Robot:
    """What the search needs of a robot: its equations, its actuated velocities (n,), and how to make a posture of
    a closed configuration."""

    name: str
    kinematics: Kinematics
    assembler: Assembler
    actuated: Array
    posture: Callable[[Array], Posture]


def working_modes(robot: Robot, at: Placed, home: Placed, hold: Held | None, starts: int) -> Modes:
    """Postures that hold the tool as it is `at` a closed one; what of it is held is decided at `home`, if as regular.

    Raises:
        InputError: `hold` or `starts` mean nothing.
        ActuationError: with the tool held the robot can still move.
    """
    k = robot.kinematics
    _check_starts(starts)
    if hold is not None and hold not in WAYS:
        raise InputError(
            f"hold must be one of {', '.join(map(repr, WAYS))}, or None for the robot's own; found {hold!r}"
        )
    held, axes = _task(k, at, home)
    held = held if hold is None else hold
    guide, driver = holding(held, axes, at)
    equations = Equations(
        k, robot.assembler, robot.actuated, k.tool_support, guide, driver, frozenset(), at.q, Limits(k, at.q)
    )
    shapes = _discrete(robot, equations, f"its tool's {held} held")
    search = Search(equations, shapes, starts)
    search.find_places()
    for place in search.places:
        search.find_ways(place)
    listing = Listing(equations, shapes, search)
    return _result(robot, search, listing, listing.combined(), held)


def assembly_modes(robot: Robot, driver: Driver, q: Array, limbs: bool, starts: int) -> Modes:
    """Postures that hold the actuated coordinates as `q` (nq,) does, which is what `driver` prescribes.

    Raises:
        InputError: `starts` is not a whole number above 0.
        ActuationError: with the actuators held the robot can still move.
    """
    k = robot.kinematics
    _check_starts(starts)
    moved = set(robot.actuated.tolist())
    fixed = frozenset(j for j in range(1, k.model.njoints) if k.model.nvs[j] == 1 and k.model.idx_vs[j] in moved)
    equations = Equations(k, robot.assembler, robot.actuated, k.tool_support, driver, driver, fixed, q, Limits(k, q))
    shapes = _discrete(robot, equations, "its actuators held")
    search = Search(equations, shapes, starts)
    search.find_places()
    listing = Listing(equations, shapes, search)
    if limbs or k.tool_support is None:
        for place in search.places:
            search.find_ways(place)
        return _result(robot, search, listing, listing.combined(), "actuators")
    return _result(robot, search, listing, listing.one_each(), "actuators")


def _check_starts(starts: int) -> None:
    if isinstance(starts, bool) or not isinstance(starts, int | np.integer) or starts < 1:
        raise InputError(f"starts must be a whole number above 0; found {starts!r}")


def _task(k: Kinematics, at: Placed, home: Placed) -> tuple[Held, Array]:
    """The task at home, where robots are symmetric and side effects vanish; at the posture if only that is regular."""
    return task_of(k, home if rank_of(home.scaled) >= rank_of(at.scaled) else at)


def _discrete(robot: Robot, equations: Equations, how: str) -> Shapes:
    shapes = Shapes(robot.kinematics, robot.actuated, equations.hub, equations.q)
    left = equations.left(shapes, equations.q)
    if left.shape[1]:
        raise ActuationError(
            f"{robot.name} still has {left.shape[1]} degrees of freedom with {how}: its modes are not discrete",
            mobility=left.shape[1],
            actuators=len(robot.actuated),
            free=joints_of(robot.kinematics.model, left),
        )
    return shapes


def _result(robot: Robot, search: Search, listing: Listing, found: list[Found], held: str) -> Modes:
    return Modes(
        postures=tuple(robot.posture(one.q) for one in found),
        found=tuple(one.count for one in found),
        starts=search.starts,
        closed=search.closed,
        loose=search.loose,
        unseen=max(tally.unseen for tally in search.tallies),
        settled=search.settled and not listing.truncated,
        held=held,
    )
