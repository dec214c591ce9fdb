"""The search for all postures that meet the loops and what is held, from random starts.

Each start is closed (Levenberg-Marquardt, then Newton) and sorted in twice.  First by where the *hub* is, the link
that carries the tool: a place.  With the hub held the robot falls into independent parts, its limbs, so the start then
counts once for each part: a way for the limb to stand.  What was found for one limb goes with what was found for the
others.  Where too few starts came to a place to know its limbs, more are made there, one limb at a time.

The search ends when every place and every way was found several times, or the starts are used up.

How much is likely to be missing is counted too.  Of n independent finds, those that turned up once make the share
n_1 / n; by Good and Turing that is about the chance that the next find is a new one (I. J. Good, The population
frequencies of species and the estimation of population parameters, Biometrika 40, 1953).  It bounds the share of the
starts, not the number of solutions: one that hardly any start leads to can hide for ever.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.assembling import nearest
from cutjoint.chain.closing.drivers import Both, Driver, PoseDriver
from cutjoint.chain.closing.equations import System
from cutjoint.chain.closing.newton import settle
from cutjoint.chain.kinematics import Kinematics
from cutjoint.chain.modes.limits import JointLimits, Starts
from cutjoint.chain.modes.shape import Shapes
from cutjoint.chain.rank import null_space
from cutjoint.chain.structure import independent_parts

FEWEST = 96
"""Starts that end in a solution, at least: a place that 3 % of them lead to is missed once in twenty searches."""
FEWEST_LIMB = 24
"""The same for the ways of one limb, which are few."""
MOST_LIMB = 240
"""Starts of one limb at most."""
STEPS, PATIENT_STEPS = 30, 100
"""Steps after which a start is given up; the second number where fewer than one in EASY starts ends in a solution."""
EASY = 8
NEAR = 1e-6
"""Sum of squared scaled errors below which Newton's method takes over."""
TIMES = 3
"""A search ends when everything was found as often as this: of m solutions that are found equally often the last one
is then missing with a chance of about 1 in (log m)^2 m."""


@dataclass(frozen=True, eq=False)
class ModeEquations:
    """What is to be solved.

    Attributes:
        kinematics: of the robot.
        hub: 1 for every velocity that moves the tool, shape (nv,), if there is one.
        guide: what leads a start to a solution.
        driver: what a solution must meet besides the loops; the guide implies it.
        fixed: joints that every solution has as `q` has them.
        q: the closed configuration that is asked about, shape (nq,).
        limits: of the joints.
    """

    kinematics: Kinematics
    hub: Array | None
    guide: Driver
    driver: Driver
    fixed: frozenset[int]
    q: Array
    limits: JointLimits

    def solve(self, start: Array, guide: Driver, steps: int = PATIENT_STEPS) -> Array | None:
        """The solution that a start leads to in as many steps, shape (nq,), or None."""
        rest, cost = nearest(self.kinematics, start, guide, steps)
        found = settle(self.kinematics, rest, self.driver) if cost < NEAR else None
        return None if found is None else self.limits.turned_back(found.q)

    def left(self, shapes: Shapes, q: Array) -> Array:
        """Motions other than idle ones that are left at a solution, dimensionless, shape (nv, k)."""
        k = self.kinematics
        placed = k.at(q)
        held = System(k, self.driver).at(placed).matrix
        if shapes.idle_motions:
            held = np.concatenate([held, shapes.idle(placed).T])
        return null_space(held)


@dataclass(eq=False)
class TallyEntry:
    """One of the things: what tells it from the others, a configuration that shows it, whether the robot's joints allow
    it, and how often it was found."""

    shape: Array
    q: Array
    allowed: bool
    count: int = 0


@dataclass(eq=False)
class Tally:
    """Things told apart by a vector, their shape, to within the tolerance DISTINCT."""

    entries: list[TallyEntry] = field(default_factory=list)
    total: int = 0

    def find(self, shape: Array) -> int | None:
        """Which of the entries has this shape."""
        for index, entry in enumerate(self.entries):
            if np.abs(entry.shape - shape).max(initial=0.0) < tolerances.DISTINCT.value:
                return index
        return None

    def add(self, shape: Array, q: Array, allowed: bool = True) -> int:
        """Add an entry, not counted as found yet."""
        self.entries.append(TallyEntry(shape, q, allowed))
        return len(self.entries) - 1

    def count(self, index: int) -> None:
        """Count one find of an entry."""
        self.entries[index].count += 1
        self.total += 1

    @property
    def unseen(self) -> float:
        """Estimated share of further finds that are new and allowed; 1 where nothing was found yet."""
        once = sum(entry.count == 1 and entry.allowed for entry in self.entries)
        return once / self.total if self.total else 1.0

    def settled(self, fewest: int) -> bool:
        """Whether at least `fewest` finds were made and each thing that is allowed was found TIMES."""
        return self.total >= fewest and all(entry.count >= TIMES or not entry.allowed for entry in self.entries)


@dataclass(eq=False)
class HubPlace:
    """A placement of the hub, first met at `q`; what holds it there; the parts that move independently meanwhile, the
    ways of each to stand, and which of the parts were searched."""

    q: Array
    holding: Driver
    parts: list[list[int]]
    ways: list[Tally]
    searched: set[int] = field(default_factory=set)


class Search:
    """One search.

    Attributes:
        equations, shapes: what is to be solved, and what tells postures apart.
        hubs, places: what was found; entry i of `hubs` counts place i.  The first is that of the posture asked about.
        starts, closed, loose: starts made, those that ended in a solution, and in one that can still move.
    """

    def __init__(self, equations: ModeEquations, shapes: Shapes, most: int) -> None:
        self.equations, self.shapes, self._most = equations, shapes, most
        k = equations.kinematics
        self._starts = Starts(k, equations.limits, equations.q)
        self._free = [joint for joint in range(1, k.model.njoints) if joint not in equations.fixed]
        self.hubs = Tally()
        self.places: list[HubPlace] = []
        self.starts = self.closed = self.loose = 0
        self._sort_in(equations.q, counts=False)

    def find_places(self) -> None:
        """Make starts of the whole robot until every place was found several times."""
        while self.starts < self._most and not self.hubs.settled(FEWEST):
            q = self._start(self._free, self.equations.q, self.equations.guide)
            if q is not None:
                self._sort_in(q)

    def find_ways(self, place: HubPlace) -> None:
        """Make starts of each limb, the hub held at a place, until every way to stand there was found several times; no
        more once a limb cannot stand there within its joints' limits."""
        for index, part in enumerate(place.parts):
            free = [joint for joint in part if joint not in self.equations.fixed]
            if not free:
                continue
            ways, tries = place.ways[index], 0
            place.searched.add(index)
            while tries < MOST_LIMB and not ways.settled(FEWEST_LIMB):
                tries += 1
                q = self._start(free, place.q, place.holding)
                if q is not None:
                    self._sort_in(q, place, index)
            if not any(way.allowed for way in ways.entries):
                return

    @property
    def tallies(self) -> list[Tally]:
        """All that had to be found."""
        return [self.hubs, *(place.ways[index] for place in self.places for index in sorted(place.searched))]

    @property
    def settled(self) -> bool:
        """Whether everything was found several times."""
        ways = (place.ways[index] for place in self.places for index in place.searched)
        return self.hubs.settled(FEWEST) and all(one.settled(FEWEST_LIMB) for one in ways)

    def place_of(self, q: Array) -> HubPlace | None:
        """The place where a solution has the hub."""
        index = self.hubs.find(self.shapes.hub_pose(self.equations.kinematics.at(q)))
        return None if index is None else self.places[index]

    def _start(self, joints: list[int], around: Array, guide: Driver) -> Array | None:
        self.starts += 1
        steps = STEPS if EASY * self.closed >= self.starts else PATIENT_STEPS
        q = self.equations.solve(self._starts.draw(joints, around), guide, steps)
        if q is not None:
            self.closed += 1
        return q

    def _sort_in(self, q: Array, only: HubPlace | None = None, part: int = 0, counts: bool = True) -> None:
        """Count a solution for its place and for each of its parts, or for one part of one place alone."""
        links = self.shapes.links(q)
        place = self.place_of(q)
        if only is not None and place is not only:
            return
        known = [None] if place is None else [w.find(s) for w, s in self._ways(place, links)]
        if None in known and counts and self.equations.left(self.shapes, q).shape[1]:
            self.loose += 1
            return
        if place is None:
            place = self._new_place(q)
            known = [None] * len(place.parts)
        if counts and only is None:
            self.hubs.count(self.places.index(place))
        for index, (ways, shape) in enumerate(self._ways(place, links)):
            if only is None or index == part:
                way = known[index]
                if way is None:
                    way = ways.add(shape, q, all(self.equations.limits.allow(q, joint) for joint in place.parts[index]))
                if counts:
                    ways.count(way)

    @staticmethod
    def _ways(place: HubPlace, links: Array) -> list[tuple[Tally, Array]]:
        """The ways of each part, and the shape of the part among those of all links."""
        return [(ways, part_of(links, part)) for ways, part in zip(place.ways, place.parts, strict=True)]

    def _new_place(self, q: Array) -> HubPlace:
        e, k = self.equations, self.equations.kinematics
        placed = k.at(q)
        self.hubs.add(self.shapes.hub_pose(placed), q)
        holding = e.guide
        if e.hub is not None:
            holding = Both(e.guide, PoseDriver(placed.tool))
        parts = independent_parts(k, holding, e.hub, e.limits.geared_velocities, q)
        place = HubPlace(q, holding, parts, [Tally() for _ in parts])
        self.places.append(place)
        return place


def part_of(links: Array, joints: Sequence[int]) -> Array:
    """The shapes of these joints' links, of those of all, shape (12 joints,)."""
    return np.asarray(links[np.array(joints) - 1].ravel())
