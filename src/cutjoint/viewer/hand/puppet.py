"""The robot in the hands of the control panel: one posture, moved by an actuator, by the tool, or to another mode.

A move goes as far as it can.  It stops at a joint limit, where the loops cannot be kept closed or the tool cannot go
(the edge of the workspace), and before a singularity; the posture stays closed and on its branch, and `stop` says why.
No browser and no server here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from cutjoint.arrays import Array, as_vector
from cutjoint.chain import ClosedChain
from cutjoint.errors import ClosureError, InputError, SingularError, UnreachableError
from cutjoint.mechanism import Posture
from cutjoint.mechanism.task import NAMES
from cutjoint.viewer.hand.lead import UNITS, ToolLead, tool_pose
from cutjoint.viewer.hand.sampling import SAMPLES, WorkspaceSampler
from cutjoint.viewer.hand.walk import BranchWalker, Go, Stop, words

FREE_TURN = math.pi
SLIDES = 8
"""Steps of a drag along a curve or a surface, to the nearest point of it."""

FURTHEST = 0.3
"""Longest of these steps, in radii of the robot."""

CLOSE_BY = 1e-4
"""A drag is at its end where a step would move the tool by less, in radii of the robot."""


class Puppet:
    """A closed chain and its present posture.

    Attributes:
        radius: half the robot's extent [m].
        lead: the coordinates by which the tool is pulled.
        workspace: how far the tool comes, as far as it was sampled.
        at: the posture, always closed.
        stop: why the last move ended early, or None.
        mode: index into `modes` of the branch that `at` is on.
        modes: working modes found so far; the first is that of home.
    """

    def __init__(self, chain: ClosedChain, radius: float) -> None:
        self.chain = chain
        self.radius = radius
        self.at = chain.home
        self.stop: Stop | None = None
        self.modes: tuple[Posture, ...] = (chain.home,)
        self.mode = 0
        self.lead = ToolLead(chain)
        self._walker = BranchWalker(chain)
        self.workspace = WorkspaceSampler(chain, self.lead, self._walker, radius)
        self._joints = {joint.name: joint for joint in chain.description.joints}

    def actuate(self, index: int, value: float) -> None:
        """Move actuator `index` towards `value` [m] or [rad], the others held.

        Raises:
            InputError: no such actuator, or not a finite number.
        """
        if not 0 <= index < self.chain.n or not math.isfinite(value):
            raise InputError(f"actuators are 0 to {self.chain.n - 1}, values finite; found {index}, {value}")
        target = np.array(self.at.q)
        name, unit = self.chain.actuators[index].name, self.chain.actuators[index].unit
        lower, upper = self._range(index)
        target[index] = min(max(value, lower), upper)
        self._actuate(target, lambda at: f"{name} {words(float(at.q[index]), unit)}")
        if self.stop is None and target[index] != value:
            self.stop = Stop("limit", f"{name} is at its limit {words(float(target[index]), unit)}")

    def pull(self, row: int, value: float) -> None:
        """Pull the tool towards `value` [m] or [rad] of a coordinate of its task, the others held.

        Args:
            row: number of the coordinate among x y z rx ry rz.
            value: of that coordinate.

        Raises:
            InputError: no such coordinate, no tool, or not a finite number.
        """
        coordinates = self.lead.coordinates(self.at)
        if row not in coordinates or not math.isfinite(value):
            names = ", ".join(f"{one} ({NAMES[one]})" for one in coordinates) or "none, for want of a tool"
            raise InputError(f"coordinates of the tool of {self.chain.name} are {names}; found {row}, {value}")
        self._pull({row: value}, row)

    def drag(self, point: Array) -> None:
        """Drag the tool's point towards one of the world, shape (3,) [m], as far as its task has it: what else the task
        has is held.  Where no coordinate of the point can be led alone, the point slides along the curve or the surface
        that it is on, to where that is nearest.

        Raises:
            InputError: not a finite point, or this tool cannot be dragged.
        """
        to = as_vector("point", point, 3, "m")
        if not self.lead.draggable:
            raise InputError(f"the tool of {self.chain.name} cannot be dragged")
        if wanted := self.lead.of_point(to):
            self._pull(wanted, *wanted)
            return
        for _ in range(SLIDES):
            tool = self.chain.tool(self.at)
            change = np.linalg.lstsq(tool.jacobian, to - tool.position)[0]
            size = float(np.linalg.norm(tool.jacobian @ change)) / self.radius
            self._actuate(self.at.q + change * min(1.0, FURTHEST / max(size, 1e-12)), self._place)
            if self.stop is not None or size < CLOSE_BY:
                return

    def go_home(self) -> None:
        """Back to the home posture and its branch."""
        self.at, self.mode, self.stop = self.chain.home, 0, None

    def find_modes(self) -> None:
        """Search the working modes at home.

        Raises:
            InputError, ActuationError: the robot has none (no tool, no cuts, or not discrete).
        """
        self.modes = tuple(self.chain.working_modes(self.chain.home))

    def choose(self, index: int) -> None:
        """Jump to working mode `index` with the tool where it is, or where the mode was found if it cannot come here.

        Raises:
            InputError: no such mode.
        """
        if not 0 <= index < len(self.modes):
            raise InputError(f"modes are 0 to {len(self.modes) - 1}; found {index}")
        coordinates = self.lead.coordinates(self.at)
        self.stop = None
        found = self.modes[index]
        if coordinates:
            try:
                found = self.lead.reach(coordinates, self.modes[index])
            except (UnreachableError, ClosureError, SingularError):
                self.stop = Stop("workspace", "this mode cannot hold the tool where it was; it is shown at home")
        self.at, self.mode = found, index

    def sample_workspace(self, samples: int = SAMPLES) -> Iterator[bool]:
        """Widen `workspace` by one walk to its edge each time; yields whether its box has changed."""
        return self.workspace.sample([self.span(index) for index in range(self.chain.n)], samples)

    def tool_position(self, at: Posture) -> Array | None:
        """World position of the tool point, shape (3,) [m]; None where the robot has no tool."""
        pose = tool_pose(self.chain, at)
        return None if pose is None else pose.position

    def span(self, index: int) -> tuple[float, float]:
        """Limits of an actuated joint, or a turn, or the robot's size, about home where it has none."""
        turns = self.chain.actuators[index].kind == "rotation"
        free, home = FREE_TURN if turns else 2 * self.radius, float(self.chain.home.q[index])
        lower, upper = self._range(index)
        return lower if math.isfinite(lower) else home - free, upper if math.isfinite(upper) else home + free

    def _range(self, index: int) -> tuple[float, float]:
        """Limits of an actuated joint; infinite where the description gives none."""
        joint = self._joints[self.chain.actuators[index].name]
        return joint.limits.ends if joint.type.limited else (-math.inf, math.inf)

    def _actuate(self, target: Array, where: Callable[[Posture], str]) -> None:
        start = np.array(self.at.q)
        self._move(lambda share, near: self.chain.close(start + share * (target - start), near, limits="ignore"), where)

    def _pull(self, change: dict[int, float], *rows: int) -> None:
        def where(at: Posture) -> str:
            found = self.lead.coordinates(at)
            return "tool " + ", ".join(f"{NAMES[row]} {words(found[row], UNITS[row])}" for row in rows)

        self._move(self.lead.towards(self.at, change), where)

    def _place(self, at: Posture) -> str:
        """Where the tool's point is, in words."""
        position = self.tool_position(at)
        assert position is not None
        return "tool " + ", ".join(f"{name} {words(x, 'm')}" for name, x in zip(NAMES, position.tolist(), strict=False))

    def _move(self, go: Go, where: Callable[[Posture], str]) -> None:
        """Take the longest part of a move that is allowed, and say what ended it."""
        self.at, stop = self._walker.walk(self.at, go)
        self.stop = None if stop is None else Stop(stop.kind, f"Stopped at {where(self.at)}: {stop.text}")
