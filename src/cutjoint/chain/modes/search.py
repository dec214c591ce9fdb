"""The search for all postures that meet the loops and what is held, from random starts.

Each start is closed (Levenberg-Marquardt, then Newton) and sorted in twice.  First by where the *hub* is, the link
that carries the tool: a place.  With the hub held the robot falls into independent parts, its limbs, so the start then
counts once for each part: a way for the limb to stand.  What was found for one limb goes with what was found for the
others.  Where too few starts came to a place to know its limbs, more are made there, one limb at a time.

The search ends when every place and every way was found several times, or the starts are used up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.closing.assembling import nearest
from cutjoint.chain.closing.drivers import Both, Driver, PoseDriver
from cutjoint.chain.closing.equations import System
from cutjoint.chain.closing.newton import settle
from cutjoint.chain.kinematics import Kinematics
from cutjoint.chain.modes.limits import JointLimits, Starts
from cutjoint.chain.modes.shape import Shapes
from cutjoint.chain.modes.tally import Tally
from cutjoint.chain.rank import null_space
from cutjoint.chain.structure import components

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
TIED = 1e-7
"""Velocities are tied together by entries larger than this of dimensionless matrices."""


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


def independent_parts(
    kinematics: Kinematics, driver: Driver, hub: Array | None, geared: list[int], q: Array
) -> list[list[int]]:
    """Groups of joints that the loops or the tree tie together while `driver` holds the hub, so that where the links of
    a group are is up to its own joints.  The joints that carry the hub are one group.

    Read off the pattern of the equations, at `q` (nq,) and at a place near by, lest a zero be one of the posture alone.

    Args:
        geared: velocities of joints whose whole turns others must go along with; held or not, they stay with these.
    """
    model = kinematics.model
    tied = np.eye(model.nv, dtype=bool)
    if hub is not None:
        carrying = hub > 0.0
        tied |= np.outer(carrying, carrying)
    for joint in range(1, model.njoints):
        own = slice(model.idx_vs[joint], model.idx_vs[joint] + model.nvs[joint])
        tied[own, own] = True
        parent = model.parents[joint]
        if parent > 0 and (hub is None or parent != kinematics.tool_joint):
            tied[own, model.idx_vs[parent]] = tied[model.idx_vs[parent], own] = True
    random = np.random.default_rng(0)
    aside = kinematics.tree.integrate(q, kinematics.column_scale * random.uniform(-0.3, 0.3, model.nv))
    for place in (q, aside):
        placed = kinematics.at(place)
        free = null_space(System(kinematics, driver).at(placed).matrix[kinematics.closure.rows :])
        projector = free @ free.T
        tied |= np.abs(projector) > TIED
        rows = placed.scaled
        touched = np.abs(rows @ projector) > TIED
        touched |= (np.abs(rows) > TIED) & (np.abs(rows[:, geared]) > TIED).any(axis=1, keepdims=True)
        tied |= touched.T.astype(float) @ touched.astype(float) > 0.0
    parts: dict[int, list[int]] = {}
    label = components(tied)
    for joint in range(1, model.njoints):
        parts.setdefault(int(label[model.idx_vs[joint]]), []).append(joint)
    return list(parts.values())
