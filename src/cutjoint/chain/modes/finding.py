"""Working modes and assembly modes: what is held, whether the modes are discrete, and the search for them.

- *Working modes* are the solutions of inverse kinematics: the tool is held, the limbs differ.
- *Assembly modes* are the solutions of forward kinematics: the actuators are held, the tool differs.

A working mode holds that part of the tool's pose which the robot's task is.  Let m be the directions in which the tool
can move, with its rotation counted, and r those of its point.

- r = m: the point says where the tool is, so the *point* is held (a five-bar, a Delta, a four-bar).  The tool's
  rotation is whatever comes with it: the rotations that the motion generates are left open.  Of a Delta these are none,
  so its platform stays upright; of a planar robot those about the normal of its plane, so a five-bar counts every
  solution, on whichever limb the tool's frame sits; in space, once it turns about two axes, all of them.
- r < m: position and orientation say where the tool is, so its whole *pose* is held (a planar 3-RRR, a 3-PRS, a Stewart
  platform).

A task that the description declares is held as it stands: its coordinates alone, the rest following.

Directions in which the tool moves by less than COMMANDED of its fastest one are side effects, not what a motor is there
for: a 3-PRS moves its point sideways a little while it tilts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, overload

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.drivers import Driver, PoseDriver, TaskDriver, TiltDriver, ToolDriver
from cutjoint.chain.joints import joints_of
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.modes.limits import JointLimits
from cutjoint.chain.modes.listing import Found, Listing
from cutjoint.chain.modes.search import ModeEquations, Search
from cutjoint.chain.modes.shape import Shapes
from cutjoint.chain.postures import Postures
from cutjoint.chain.rank import null_space, rank_of
from cutjoint.chain.structure import scaled_tool
from cutjoint.errors import ActuationError, InputError
from cutjoint.mechanism import Posture, Task
from cutjoint.reprs import clipped, line, one_line, quoted
from cutjoint.tables import TextTable

Held = Literal["point", "pose", "task"]
WAYS: tuple[Held, ...] = ("point", "pose", "task")
MOST_STARTS = 2000
"""Starts at most, unless asked otherwise: ten seconds for a robot of twenty joints."""


@dataclass(frozen=True, eq=False)
class Modes(Sequence[Posture]):
    """Postures found from many starts, as a sequence: `len(modes)`, `modes[0]`, `for mode in modes`.

    The first one is that of the posture asked about.  The others follow by how far their links are from it, so the
    order does not depend on the order in which they were found.

    Attributes:
        postures: the modes.
        found: how often each was found again, by independent starts; what is found once is rarely alone.
        starts: starts made, of which `closed` ended in a solution of the equations.
        closed: starts that ended in a solution, within the joint limits or not.
        loose: those of them that ended in a posture that can still move, which is no mode.
        unseen: share of further starts that would find something new, as Good and Turing estimate it: what was found
            once among what was found.  1 where nothing was found.
        settled: whether the search ended because all was found several times, not because it ran out of starts.
        held: what all of them have in common: "point", "pose" or "task" of the tool, or "actuators".
    """

    postures: tuple[Posture, ...]
    found: tuple[int, ...]
    starts: int
    closed: int
    loose: int
    unseen: float
    settled: bool
    held: str

    def __repr__(self) -> str:
        first = self.postures[0].layout if self.postures else None
        of = [f"of {quoted(first.robot)}"] if first is not None else []
        end = "all found several times" if self.settled else f"{self.unseen:.2g} of further starts would find more"
        return one_line("Modes", [str(len(self)), *of, f"{clipped(self.held)} held", f"{self.starts} starts", end])

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()

    def table(self) -> TextTable:
        """A row a mode: its actuated coordinates, and how often it was found."""
        layout = self.postures[0].layout if self.postures else None
        actuators = [] if layout is None else [f"{clipped(one.name)} [{one.unit}]" for one in layout.actuators]
        rows = [
            (str(number), *(f"{value:.6g}" for value in at.q), str(found))
            for number, (at, found) in enumerate(zip(self.postures, self.found, strict=True))
        ]
        columns = ("mode", *actuators, "found")
        return TextTable(f"{len(self)} modes with the {clipped(self.held)} held", columns, rows, columns)

    def __len__(self) -> int:
        return len(self.postures)

    @overload
    def __getitem__(self, index: int) -> Posture: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Posture, ...]: ...

    def __getitem__(self, index: int | slice) -> Posture | tuple[Posture, ...]:
        return self.postures[index]


class ModeSeeker:
    """Seeks the modes of one robot; what it raises is said in `ClosedChain`."""

    __repr__ = line()

    def __init__(self, postures: Postures) -> None:
        self._postures, self._k, self._actuated = postures, postures.k, postures.actuated

    def working_modes(self, at: Placed, hold: Held | None, starts: int, task: Task | None) -> Modes:
        """Postures that hold the tool as it is at a closed one; what of it is held, home tells, if as regular.

        Args:
            task: whose coordinates are held, where that is so.
        """
        k = self._k
        k.need_tool()
        if not k.closure.rows:
            raise InputError(f"{k.name} has no cut joints; working modes are those of closed robots")
        if hold is not None and hold not in WAYS:
            raise InputError(
                f"hold must be one of {', '.join(map(repr, WAYS))}, or None for the robot's own; found {hold!r}"
            )
        if task is not None:
            pose = at.tool_pose
            place = TaskDriver.way(pose, pose, k.length)
            driver: Driver = TaskDriver(task, task.rows, pose, k.length, place, place)
            return self._all_ways(self._search(driver, driver, frozenset(), at, starts, "its task held"), "task")
        home = self._postures.at_home  # where robots are symmetric and side effects vanish, so it tells the task
        held, axes = commanded(k, home if rank_of(home.scaled) >= rank_of(at.scaled) else at)
        held = held if hold is None else hold
        guide, driver = holding(held, axes, at)
        search = self._search(guide, driver, frozenset(), at, starts, f"its tool's {held} held")
        return self._all_ways(search, held)

    def assembly_modes(self, at: Placed, limbs: bool, starts: int) -> Modes:
        """Postures that hold the actuated coordinates as a closed one does."""
        k, driver = self._k, self._actuated.hold(at.q)
        moved = set(self._actuated.v_index.tolist())
        fixed = frozenset(j for j in range(1, k.model.njoints) if k.model.nvs[j] == 1 and k.model.idx_vs[j] in moved)
        search = self._search(driver, driver, fixed, at, starts, "its actuators held")
        if limbs or k.tool_support is None:
            return self._all_ways(search, "actuators")
        listing = Listing(search)
        return self._modes(search, listing, listing.one_each(), "actuators")

    def _search(
        self, guide: Driver, driver: Driver, fixed: frozenset[int], at: Placed, starts: int, how: str
    ) -> Search:
        """The search for the places of what meets a driver, if that is discrete."""
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
        search = Search(equations, shapes, starts)
        search.find_places()
        return search

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


def commanded(kinematics: Kinematics, placed: Placed) -> tuple[Held, Array]:
    """Whether point or pose of the tool is commanded at a closed configuration, and an orthonormal basis of the
    axes, shape (3, k), about which it turns there."""
    k = kinematics
    moved = scaled_tool(k, placed) @ null_space(placed.scaled)
    fastest = float(np.linalg.svd(moved, compute_uv=False).max(initial=0.0))

    def directions(rows: Array) -> Array:
        left, values, _ = np.linalg.svd(rows)
        return np.asarray(left[:, : int(np.sum(values > tolerances.COMMANDED.value * max(fastest, 1e-300)))])

    whole, point = directions(moved).shape[1], directions(moved[:3]).shape[1]
    return "point" if point == whole else "pose", directions(moved[3:])


def holding(held: Held, axes: Array, at: Placed) -> tuple[Driver, Driver]:
    """What leads a start to a mode, and what a mode must meet, with the tool as it is `at` a configuration.

    They differ where the point is held and the rotation follows: then it leads, and a robot whose links were rounded by
    the program that exported them is not asked for a rotation that it misses by a micrometre.
    """
    pose = at.tool
    if held == "pose":
        whole = PoseDriver(pose)
        return whole, whole
    point = ToolDriver(at.tool_position, at.tool_position)
    if axes.shape[1] == 0:
        return PoseDriver(pose), point
    return TiltDriver(pose, axes[:, 0]) if axes.shape[1] == 1 else point, point
