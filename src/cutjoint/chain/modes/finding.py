"""Working modes and assembly modes: what is held, whether the modes are discrete, and the search for them.

- *Working modes* are the solutions of inverse kinematics: the tool is held, the limbs differ.
- *Assembly modes* are the solutions of forward kinematics: the actuators are held, the tool differs.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.closing.drivers import Driver
from cutjoint.chain.joints import joints_of
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.modes.limits import JointLimits
from cutjoint.chain.modes.listing import Found, Listing
from cutjoint.chain.modes.result import Modes
from cutjoint.chain.modes.search import ModeEquations, Search
from cutjoint.chain.modes.shape import Shapes
from cutjoint.chain.modes.task import WAYS, Held, holding, task_of
from cutjoint.chain.postures import Postures
from cutjoint.chain.rank import rank_of
from cutjoint.errors import ActuationError, InputError

MOST_STARTS = 2000
"""Starts at most, unless asked otherwise: ten seconds for a robot of twenty joints."""


class ModeSeeker:
    """Seeks the modes of one robot."""

    def __init__(self, postures: Postures) -> None:
        self._postures, self._k, self._actuated = postures, postures.k, postures.actuated

    def working_modes(self, at: Placed, hold: Held | None, starts: int) -> Modes:
        """Postures that hold the tool as it is at a closed one; what of it is held is decided at home, if as regular.

        Raises:
            InputError: the robot has no tool or no cuts; `hold` or `starts` mean nothing.
            ActuationError: with the tool held the robot can still move.
        """
        k = self._k
        k.need_tool()
        if not k.closure.rows:
            raise InputError(f"{k.name} has no cut joints; working modes are those of closed robots")
        if hold is not None and hold not in WAYS:
            raise InputError(
                f"hold must be one of {', '.join(map(repr, WAYS))}, or None for the robot's own; found {hold!r}"
            )
        held, axes = _task(k, at, self._postures.at_home)
        held = held if hold is None else hold
        guide, driver = holding(held, axes, at)
        search = self._search(guide, driver, frozenset(), at, starts, f"its tool's {held} held")
        search.find_places()
        return self._all_ways(search, held)

    def assembly_modes(self, at: Placed, limbs: bool, starts: int) -> Modes:
        """Postures that hold the actuated coordinates as a closed one does.

        Raises:
            InputError: `starts` is not a whole number above 0.
            ActuationError: with the actuators held the robot can still move.
        """
        k, driver = self._k, self._actuated.hold(at.q)
        moved = set(self._actuated.v_index.tolist())
        fixed = frozenset(j for j in range(1, k.model.njoints) if k.model.nvs[j] == 1 and k.model.idx_vs[j] in moved)
        search = self._search(driver, driver, fixed, at, starts, "its actuators held")
        search.find_places()
        if limbs or k.tool_support is None:
            return self._all_ways(search, "actuators")
        listing = Listing(search)
        return self._modes(search, listing, listing.one_each(), "actuators")

    def _search(
        self, guide: Driver, driver: Driver, fixed: frozenset[int], at: Placed, starts: int, how: str
    ) -> Search:
        """The search for what meets a driver, if that is discrete."""
        if isinstance(starts, bool) or not isinstance(starts, int | np.integer) or starts < 1:
            raise InputError(f"starts must be a whole number above 0; found {starts!r}")
        k, actuated = self._k, self._actuated.v_index
        equations = ModeEquations(k, k.tool_support, guide, driver, fixed, at.q, JointLimits(k, at.q))
        shapes = Shapes(k, actuated, equations.hub, equations.q)
        left = equations.left(shapes, equations.q)
        if left.shape[1]:
            raise ActuationError(
                f"{k.name} still has {left.shape[1]} degrees of freedom with {how}: its modes are not discrete",
                mobility=left.shape[1],
                actuators=len(actuated),
                free=joints_of(k.model, left),
            )
        return Search(equations, shapes, starts)

    def _all_ways(self, search: Search, held: str) -> Modes:
        """Every place with every combination of its limbs' ways."""
        for place in search.places:
            search.find_ways(place)
        listing = Listing(search)
        return self._modes(search, listing, listing.combined(), held)

    def _modes(self, search: Search, listing: Listing, found: list[Found], held: str) -> Modes:
        return Modes(
            postures=tuple(self._postures.make(self._k.at(one.q)) for one in found),
            found=tuple(one.count for one in found),
            starts=search.starts,
            closed=search.closed,
            loose=search.loose,
            unseen=max(tally.unseen for tally in search.tallies),
            settled=search.settled and not listing.truncated,
            held=held,
        )


def _task(k: Kinematics, at: Placed, home: Placed) -> tuple[Held, Array]:
    """The task at home, where robots are symmetric and side effects vanish; at the posture if only that is regular."""
    return task_of(k, home if rank_of(home.scaled) >= rank_of(at.scaled) else at)
