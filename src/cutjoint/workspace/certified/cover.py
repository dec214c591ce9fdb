"""A box taken apart into sub-boxes until each is proven, and their postures joined to one branch.

Sub-boxes that are not proven are halved along the axis on which most depends, the largest first.  Neighbours are
joined at a common point of their faces: where the room in which the one has its posture lies in that in which the
other has one alone, both have the same; so they have where a posture that is proven at the point alone lies in the
rooms of both.  And then they have the same on all of the common face, as neither is singular there.  One pair across
every cut is enough, since both sides of the cut are joined in themselves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.workspace.certified.certificate import CounterExample
from cutjoint.workspace.certified.forms import EPS
from cutjoint.workspace.certified.proof import Proofs, prove
from cutjoint.workspace.certified.search import CounterSearch
from cutjoint.workspace.certified.system import LedSystem

TOGETHER = 256
"""Sub-boxes that are looked at together."""
LEAST = 2.0**-40
"""Sub-boxes are not halved below this part of the box."""
ROUNDED = 1e-13
"""By how much middles and half edges of sub-boxes are taken wider, relative, so that they have no gaps between them."""


@dataclass
class SubBox:
    """A sub-box, halved or not.

    Attributes:
        low, high: ends along the axes of the box, (axes,).
        guess: a posture near that in the middle, (size,).
        axis: along which it is halved; -1 where it is not.
        children: numbers of both halves.
        batch, place: where its proof is.
    """

    low: Array
    high: Array
    guess: Array
    axis: int = -1
    children: tuple[int, int] = (-1, -1)
    batch: int = -1
    place: int = -1


class Cover:
    """Sub-boxes of one box.

    Args:
        system: the equations.
        search: looks for counter-examples on the way.
        lower, upper: ends of the box along all led coordinates, (led,).
        start: configuration in the middle, (size,).
        most: how many sub-boxes are looked at at most.
        told: is given the part that is proven, and says whether to go on.
    """

    def __init__(
        self, system: LedSystem, search: CounterSearch, start: Array, most: int, told: Callable[[float], bool]
    ) -> None:
        self._system, self._search, self._most, self._told = system, search, most, told
        self._axes = list(system.goals.axes)
        self._lower, self._upper = search.lower, search.upper
        self.parts = [SubBox(self._lower[self._axes], self._upper[self._axes], start)]
        self._proofs: list[Proofs] = []
        self.looked, self.volume = 0, 0.0
        self.counter_example: CounterExample | None = None

    def run(self) -> bool:
        """Take apart until all is proven and joined, a counter-example is found, or the budget is used up; returns
        whether all is proven and joined."""
        waiting = [0]
        while True:
            while waiting:
                if self.looked >= self._most or not self._told(self.volume):
                    return False
                now, waiting = waiting[:TOGETHER], waiting[TOGETHER:]
                more = self._look(now)
                if self.counter_example is not None:
                    return False
                waiting += more
            apart = self._not_joined()
            if not apart:
                return bool(self.leaves()[2].all())
            for number in apart:
                self.volume -= self._share_of(self.parts[number])
                waiting += self._halve(number)
            if not waiting:
                return False

    def leaves(self) -> tuple[Array, Array, npt.NDArray[np.bool_], Array]:
        """Ends of the sub-boxes that are not halved, which are proven, and their margins."""
        kept = [one for one in self.parts if one.axis < 0]
        proofs = [self._proofs[one.batch] if one.batch >= 0 else None for one in kept]
        good = [bool(p.good[one.place]) if p else False for one, p in zip(kept, proofs, strict=True)]
        margins = [float(p.margin[one.place]) if p else -1.0 for one, p in zip(kept, proofs, strict=True)]
        return (
            np.array([one.low for one in kept]),
            np.array([one.high for one in kept]),
            np.array(good),
            np.array(margins),
        )

    # ---- looking ---------------------------------------------------------------------------------------------------

    def _look(self, numbers: list[int]) -> list[int]:
        """Try to prove some sub-boxes; returns the halves of those that are not."""
        parts = [self.parts[k] for k in numbers]
        low, high = (np.array([getattr(one, side) for one in parts]) for side in ("low", "high"))
        middles, halves = self._ends(low, high)
        proofs = prove(self._system, middles, halves, np.array([one.guess for one in parts]))
        signed = (proofs.signs == self._search.signs[:, None]).all(axis=0)
        proofs.good[:] &= signed
        self.looked += len(parts)
        batch = len(self._proofs)
        self._proofs.append(proofs)
        doubtful = ~(proofs.closed & signed) | proofs.limited
        if doubtful.any():
            self.counter_example = self._search.at(middles[doubtful], proofs.q[doubtful])
        more: list[int] = []
        for place, number in enumerate(numbers):
            self.parts[number].batch, self.parts[number].place = batch, place
            if proofs.good[place]:
                self.volume += self._share_of(self.parts[number])
            else:
                more += self._halve(number)
        return more

    def _ends(self, low: Array, high: Array) -> tuple[Array, Array]:
        """Middles and half edges along all led coordinates, (N, led) each, a little wider than the sub-boxes."""
        middles = np.tile(0.5 * (self._lower + self._upper), (len(low), 1))
        halves = np.zeros_like(middles)
        middles[:, self._axes] = 0.5 * (low + high)
        halves[:, self._axes] = 0.5 * (high - low) * (1.0 + 1e-12) + 4.0 * EPS * (np.abs(low) + np.abs(high))
        return middles, halves

    def _share_of(self, part: SubBox) -> float:
        whole = self.parts[0]
        return float(np.prod((part.high - part.low) / (whole.high - whole.low)))

    def _halve(self, number: int) -> list[int]:
        """The halves of a sub-box, unless it is too small."""
        part = self.parts[number]
        proofs, place = self._proofs[part.batch], part.place
        edges = (part.high - part.low) / (self.parts[0].high - self.parts[0].low)
        scores = proofs.scores[:, place]
        axis = int(np.argmax(scores if np.isfinite(scores).all() and scores.any() else edges))
        if edges[axis] < LEAST:
            return []
        part.axis, half = axis, 0.5 * (part.low[axis] + part.high[axis])
        for sign in (-1.0, 1.0):
            low, high = part.low.copy(), part.high.copy()
            (high if sign < 0.0 else low)[axis] = half
            guess = proofs.near(place, 0.5 * sign * np.eye(len(scores))[axis])
            usable = proofs.closed[place] and np.isfinite(guess).all()
            self.parts.append(SubBox(low, high, guess if usable else part.guess))
        part.children = len(self.parts) - 2, len(self.parts) - 1
        return list(part.children)

    # ---- joining ---------------------------------------------------------------------------------------------------

    def _not_joined(self) -> list[int]:
        """Sub-boxes on both sides of cuts that are not joined."""
        cuts = [one for one in self.parts if one.axis >= 0]
        if not cuts:
            return []
        points = np.array([0.5 * (one.low + one.high) for one in cuts])
        sides = [
            [self._holding(one.children[side], at) for one, at in zip(cuts, points, strict=True)] for side in (0, 1)
        ]
        enclosures = [self._room(numbers, points) for numbers in sides]
        (q, room, tight), (other, other_room, other_tight) = enclosures
        away = np.abs(q - other)
        slack = 64.0 * EPS * (np.abs(q) + np.abs(other))
        ways = (away + tight + slack < other_room, away + other_tight + slack < room)
        joined = np.asarray(ways[0].all(axis=1) | ways[1].all(axis=1), dtype=np.bool_)
        if (left := np.flatnonzero(~joined)).size:
            alone = prove(self._system, *self._ends(points[left], points[left]), 0.5 * (q + other)[left])
            inside = alone.good
            for place, within in ((q, room), (other, other_room)):
                inside &= (np.abs(alone.q - place[left]) + alone.reached + slack[left] < within[left]).all(axis=1)
            joined[left] = inside
        return sorted({side[k] for side in sides for k in np.flatnonzero(~joined).tolist()})

    def _holding(self, number: int, at: Array) -> int:
        """The sub-box within another that has a point."""
        part = self.parts[number]
        while part.axis >= 0:
            number = part.children[int(at[part.axis] > 0.5 * (part.low[part.axis] + part.high[part.axis]))]
            part = self.parts[number]
        return number

    def _room(self, numbers: list[int], points: Array) -> tuple[Array, Array, Array]:
        """Postures at points of sub-boxes to first order, and the room and the tight room around them."""
        q, room, tight = (np.empty((len(numbers), self._system.size)) for _ in range(3))
        for k, (number, at) in enumerate(zip(numbers, points, strict=True)):
            part = self.parts[number]
            proofs, place = self._proofs[part.batch], part.place
            shares = (at - 0.5 * (part.low + part.high)) / self._ends(part.low[None], part.high[None])[1][0, self._axes]
            q[k] = proofs.near(place, shares)
            room[k], tight[k] = proofs.room[place], proofs.tight[place]
        return q, room, tight
