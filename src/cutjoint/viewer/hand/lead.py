"""The coordinates by which a tool is led by hand: those of its task, and which of them can be moved alone.

Where no task can be told, the point is led along the axes of the world, and the rest moves as little as it can.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.errors import CutjointError, InputError
from cutjoint.mechanism import Pose, Posture, Task
from cutjoint.mechanism.task import NAMES
from cutjoint.viewer.hand.walk import Go

POINT = (0, 1, 2)
"""Rows of the tool's point."""

UNITS = ("m", "m", "m", "rad", "rad", "rad")

STILL = 1e-9
"""A point that moves by less, in robot lengths for a unit of an actuator, does not move."""

TRIAL = 1e-3
"""By how much a coordinate is moved to see whether it can be: [rad] or robot lengths."""


def tool_pose(chain: ClosedChain, at: Posture) -> Pose | None:
    """Pose of the tool in the world, also where the actuators do not determine its motion; None without a tool."""
    frame = chain.description.tool
    if frame is None:
        return None
    placed = chain.link_placements(at)[frame.link] @ frame.placement
    return Pose(placed[:3, 3], placed[:3, :3])


class ToolLead:
    """Leads the tool of one chain.

    Attributes:
        task: its task, or the world's x y z where none can be told; None where there is no tool.
        rows: of the six coordinates x y z rx ry rz, those that can be moved at home while the others of the task stay.
        draggable: whether its point can be dragged about.
    """

    def __init__(self, chain: ClosedChain) -> None:
        self._chain, self._free = chain, False
        home = tool_pose(chain, chain.home)
        self.task: Task | None = None
        try:
            self.task = chain.task
        except InputError:
            if home is not None:
                self.task, self._free = Task(NAMES[:3], home, chain.name), True
        self.rows = [row for row in self.task.rows if self._moves(row)] if self.task is not None else []
        self.draggable = any(row in POINT for row in self.rows) or self._point_moves()

    def coordinates(self, at: Posture) -> dict[int, float]:
        """Those of the task by row, [m] and [rad]."""
        pose = tool_pose(self._chain, at)
        if self.task is None or pose is None:
            return {}
        return dict(zip(self.task.rows, self.task.coordinates(pose).tolist(), strict=True))

    def reach(self, coordinates: Mapping[int, float], near: Posture) -> Posture:
        """The posture with these coordinates by row, near another one; joint limits are the caller's to see to.

        Raises:
            UnreachableError, SingularError: the tool cannot come there.
        """
        named = {NAMES[row]: value for row, value in coordinates.items()}
        return self._chain.reach(named, near, free=self._free, limits="ignore")

    def towards(self, start: Posture, change: Mapping[int, float]) -> Go:
        """The straight way from a posture to where some coordinates have other values."""
        origin = self.coordinates(start)
        goal = {**origin, **change}
        return lambda fraction, near: self.reach(
            {row: value + fraction * (goal[row] - value) for row, value in origin.items()}, near
        )

    def of_point(self, point: Array) -> dict[int, float]:
        """Those coordinates of a point of the world, shape (3,) [m], that can be led."""
        if self.task is None:
            return {}
        whole = replace(self.task, names=NAMES)
        place = whole.coordinates(Pose(point, self.task.home.rotation)).tolist()
        return {row: place[row] for row in self.rows if row in POINT}

    def _point_moves(self) -> bool:
        """Whether the actuators move the tool's point at home, and tell where it is."""
        try:
            rates = self._chain.tool(self._chain.home).jacobian
            return float(np.abs(rates).max(initial=0.0)) > STILL * self._chain.length
        except CutjointError:
            return False

    def _moves(self, row: int) -> bool:
        step = TRIAL * (self._chain.length if row in POINT else 1.0)
        home = self.coordinates(self._chain.home)
        try:
            self.reach({**home, row: home[row] + step}, self._chain.home)
        except CutjointError:
            return False
        return True
