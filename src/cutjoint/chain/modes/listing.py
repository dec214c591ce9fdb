"""From what a search found to a list: combinations of the limbs, within the joint limits, in an order of their own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cmp_to_key
from itertools import islice, product

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.newton import settle
from cutjoint.chain.modes.search import HubPlace, Search, TallyEntry, part_of

MOST_MODES = 4096
"""Combinations of the limbs' ways beyond this are not listed."""


@dataclass(frozen=True, eq=False)
class Found:
    """A mode: its configuration (nq,), the shapes of its links (joints, 12), and how often it was found."""

    q: Array
    links: Array
    count: int


class Listing:
    """Lists what a search found."""

    def __init__(self, search: Search) -> None:
        self._e, self._shapes, self._search = search.equations, search.shapes, search
        self._model = self._e.kinematics.model
        self._asked = self._shapes.links(self._e.q)
        self.truncated = False

    def combined(self) -> list[Found]:
        """Every place with every combination of its limbs' ways."""
        return self._ordered([one for place in self._search.places for one in self._combinations(place)])

    def one_each(self) -> list[Found]:
        """Every place once: its limbs as near to how they stand in the posture asked about as the limits allow."""
        found: list[Found] = []
        for place in self._search.places:
            one = self._as_asked(place)
            if one is None:
                self._search.find_ways(place)
                one = next(self._combinations(place), None)
            if one is not None:
                found.append(one)
        return self._ordered(found)

    def _as_asked(self, place: HubPlace) -> Found | None:
        """The posture at a place that the limbs come to from where they stand in the posture asked about."""
        e, model = self._e, self._model
        start = e.q.copy()
        if e.hub is not None:
            carrying = e.hub
            for joint in range(1, model.njoints):
                if carrying[model.idx_vs[joint]]:
                    self._copy(joint, place.q, start)
        q = e.solve(start, place.holding)
        if q is None or self._search.place_of(q) is not place:
            return None
        if not all(e.limits.allow(q, joint) for joint in range(1, model.njoints)):
            return None
        return Found(q, self._shapes.links(q), self._count(place))

    def _combinations(self, place: HubPlace) -> Iterator[Found]:
        choices: list[list[TallyEntry]] = []
        for part, ways in zip(place.parts, place.ways, strict=True):
            allowed = [way for way in ways.entries if way.allowed]
            away = [float(np.linalg.norm(way.shape - part_of(self._asked, part))) for way in allowed]
            choices.append([allowed[index] for index in np.argsort(away, kind="stable")])
        if np.prod([float(len(choice)) for choice in choices]) > MOST_MODES:
            self.truncated = True
        for pick in islice(product(*choices), MOST_MODES):
            q = place.q.copy()
            for part, way in zip(place.parts, pick, strict=True):
                for joint in part:
                    self._copy(joint, way.q, q)
            closed = settle(self._e.kinematics, q, self._e.driver)  # beside it where links are rounded
            if closed is not None:
                counts = [way.count for index, way in enumerate(pick) if index in place.searched]
                count = min([self._count(place), *counts])
                yield Found(closed.q, self._shapes.links(closed.q), count)

    def _count(self, place: HubPlace) -> int:
        return self._search.hubs.entries[self._search.places.index(place)].count

    def _copy(self, joint: int, source: Array, target: Array) -> None:
        where = slice(self._model.idx_qs[joint], self._model.idx_qs[joint] + self._model.nqs[joint])
        target[where] = source[where]

    # ---- order -----------------------------------------------------------------------------------------------------

    def _ordered(self, found: list[Found]) -> list[Found]:
        """The posture asked about, then the others by how far their links are from it; where several are equally far
        (the modes of a symmetric robot) by the first number of their shapes that differs."""
        first = Found(self._e.q, self._asked, 0)
        rest: list[tuple[float, Found]] = []
        for one in found:
            away = one.links - self._asked
            if np.abs(away).max(initial=0.0) < tolerances.DISTINCT.value:
                first = Found(self._e.q, self._asked, one.count)
            else:
                rest.append((float(np.linalg.norm(away)), one))
        return [first, *(one for _, one in sorted(rest, key=cmp_to_key(_compare)))]


def _compare(one: tuple[float, Found], two: tuple[float, Found]) -> int:
    differences = np.concatenate([[one[0] - two[0]], (one[1].links - two[1].links).ravel()])
    telling = np.flatnonzero(np.abs(differences) > tolerances.DISTINCT.value)
    return int(np.sign(differences[telling[0]])) if len(telling) else 0
