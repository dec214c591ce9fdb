"""How far the tool comes: walks from home to the edge of the workspace, one at a time in quiet moments.

The tool is led along each coordinate of its task both ways, then its point in random directions; where no coordinate
can be led alone, the actuators are moved to random places instead.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.mechanism import Posture
from cutjoint.viewer.hand.lead import POINT, ToolLead, tool_pose
from cutjoint.viewer.hand.walk import BranchWalker, Go

SAMPLES = 24
LONGEST = 0.05
"""Longest step of a walk, as part of it."""

FURTHEST_TURN = math.radians(179.0)
"""Beyond half a turn a rotation is the same as one the other way round."""

INSIDE = 0.99
"""Walks end this much before."""


class WorkspaceSampler:
    """What the walks of one chain have found so far.

    Attributes:
        box: bounding box of the tool points, shape (2, 3) [m] in the world, or None before the first.
        ranges: smallest and largest value of each coordinate of the task by row, [m] or [rad].
    """

    def __init__(self, chain: ClosedChain, lead: ToolLead, walker: BranchWalker, radius: float) -> None:
        self._chain, self._lead, self._walker, self._radius = chain, lead, walker, radius
        self.box: Array | None = None
        self.ranges: Mapping[int, tuple[float, float]] = {}

    def sample(self, spans: list[tuple[float, float]], samples: int = SAMPLES) -> Iterator[bool]:
        """One walk each time; yields whether the box has grown.  `spans` are those of the actuators."""
        home = self._chain.home
        if self._lead.task is None:
            return
        self._widen(home)
        for go in self._walks(spans, samples):
            yield self._widen(self._walker.walk(home, go, longest=LONGEST)[0])

    def _widen(self, end: Posture) -> bool:
        pose = tool_pose(self._chain, end)
        assert pose is not None
        self.ranges = {
            row: (min(value, self.ranges[row][0]), max(value, self.ranges[row][1]))
            if row in self.ranges
            else (value,) * 2
            for row, value in self._lead.coordinates(end).items()
        }
        before, point = self.box, pose.position
        self.box = np.array(
            [point, point] if before is None else [np.minimum(before[0], point), np.maximum(before[1], point)]
        )
        return before is None or bool((self.box != before).any())

    def _walks(self, spans: list[tuple[float, float]], samples: int) -> Iterator[Go]:
        random, lead = np.random.default_rng(0), self._lead
        point = [row for row in lead.rows if row in POINT]
        single = [{row: sign} for sign in (1.0, -1.0) for row in lead.rows]
        for _ in range(max(samples, len(single))):
            if single:
                yield self._to_edge(single.pop(0))
            elif point:
                yield self._to_edge(dict(zip(point, random.normal(size=len(point)).tolist(), strict=True)))
            elif spans and not lead.rows:
                yield self._actuated(np.array([random.uniform(*span) for span in spans]))

    def _to_edge(self, direction: dict[int, float]) -> Go:
        """Led from home in a direction of the task's coordinates, as far as may be."""
        home = self._lead.coordinates(self._chain.home)
        size = math.hypot(*direction.values())
        far = {row: 2.0 * self._radius if row in POINT else INSIDE * FURTHEST_TURN for row in direction}
        return self._lead.towards(
            self._chain.home, {row: home[row] + far[row] * part / size for row, part in direction.items()}
        )

    def _actuated(self, to: Array) -> Go:
        chain = self._chain
        return lambda share, near: chain.close(chain.home.q + share * (to - chain.home.q), near, limits="ignore")
