"""The robot in the hands of the control panel: one posture, moved by an actuator, by the tool, or to another mode.

A move goes as far as it can.  It stops at a joint limit, where the loops cannot be kept closed or the tool cannot go
(the edge of the workspace), and before a singularity; the posture stays closed and on its branch, and `stop` says why.
No browser and no server here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.errors import ClosureError, InputError, SingularError, UnreachableError
from cutjoint.mechanism import Posture
from cutjoint.viewer.hand.walk import BranchWalker, Go, Stop

WORKSPACE_SAMPLES = 24
FREE_TURN = math.pi
AXES = ("x", "y", "z")


class Puppet:
    """A closed chain and its present posture.

    Attributes:
        radius: half the robot's extent [m].
        axes: the world axes along which the tool can be pulled at home.
        at: the posture, always closed.
        stop: why the last move ended early, or None.
        mode: index into `modes` of the branch that `at` is on.
        modes: working modes found so far; the first is that of home.
        box: bounding box of the tool positions sampled so far, shape (2, 3) [m], or None.
    """

    def __init__(self, chain: ClosedChain, radius: float) -> None:
        self.chain = chain
        self.radius = radius
        self.at = chain.home
        self.stop: Stop | None = None
        self.modes: tuple[Posture, ...] = (chain.home,)
        self.mode = 0
        self.box: Array | None = None
        self.axes = [axis for axis in range(3) if self._can_pull(axis)]
        self._walker = BranchWalker(chain)
        self._joints = {joint.name: joint for joint in chain.description.joints}

    def actuate(self, index: int, value: float) -> None:
        """Move actuator `index` towards `value` [m] or [rad], the others held.

        Raises:
            InputError: no such actuator, or not a finite number.
        """
        if not 0 <= index < self.chain.n or not math.isfinite(value):
            raise InputError(f"actuators are 0 to {self.chain.n - 1}, values finite; found {index}, {value}")
        start = np.array(self.at.q)
        target = start.copy()
        name, unit = self.chain.actuators[index].name, self.chain.actuators[index].unit
        lower, upper = self._range(index)
        target[index] = min(max(value, lower), upper)

        def go(fraction: float, near: Posture) -> Posture:
            return self.chain.close(start + fraction * (target - start), near)

        self._move(go, lambda at: f"{name} {at.q[index]:.4g} {unit}")
        if self.stop is None and target[index] != value:
            self.stop = Stop("limit", f"{name} is at its limit {target[index]:.4g} {unit}")

    def pull(self, axis: int, value: float) -> None:
        """Move the tool along world axis `axis` (0, 1, 2) towards `value` [m], its other coordinates held.

        Raises:
            InputError: no such axis, no tool, or not a finite number.
        """
        if not 0 <= axis < 3 or not math.isfinite(value):
            raise InputError(f"axes are 0, 1 and 2, values finite; found {axis}, {value}")
        start = self.tool_position(self.at)
        if start is None:
            raise InputError(f"{self.chain.name} has no tool to pull")
        target = start.copy()
        target[axis] = value

        def go(fraction: float, near: Posture) -> Posture:
            return self.chain.reach(start + fraction * (target - start), near)

        def where(at: Posture) -> str:
            position = self.tool_position(at)
            return "" if position is None else f"tool {AXES[axis]} {position[axis]:.4g} m"

        self._move(go, where)

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
        position = self.tool_position(self.at)
        self.stop = None
        found = self.modes[index]
        if position is not None:
            try:
                found = self.chain.reach(position, self.modes[index])
            except (UnreachableError, ClosureError, SingularError):
                self.stop = Stop("workspace", "this mode cannot hold the tool where it was; it is shown at home")
        self.at, self.mode = found, index

    def sample_workspace(self, samples: int = WORKSPACE_SAMPLES) -> Iterator[bool]:
        """Widen `box` by one walk to the edge of the workspace each time; yields whether it has changed.

        The tool is pulled from home along the axes both ways, then in random directions; where it cannot be pulled
        along any axis, the actuators are moved to random places instead.
        """
        home = self.tool_position(self.chain.home)
        if home is None:
            return
        self.box = np.array([home, home])
        for go in self._walks(home, samples):
            end = self.tool_position(self._walker.walk(self.chain.home, go, longest=0.05)[0])
            before = self.box
            if end is not None:
                self.box = np.array([np.minimum(before[0], end), np.maximum(before[1], end)])
            yield bool((self.box != before).any())

    def _walks(self, home: Array, samples: int) -> Iterator[Go]:
        random, chain = np.random.default_rng(0), self.chain
        axes = np.eye(3)[self.axes]
        ways = list(np.concatenate([axes, -axes]))
        spans = [self.span(index) for index in range(chain.n)]

        def pull(to: Array) -> Go:
            return lambda share, near: chain.reach(home + share * (to - home), near)

        def actuate(to: Array) -> Go:
            return lambda share, near: chain.close(chain.home.q + share * (to - chain.home.q), near)

        for _ in range(samples):
            if len(axes):
                way = ways.pop(0) if ways else random.normal(size=len(axes)) @ axes
                yield pull(home + 2.0 * self.radius * way / np.linalg.norm(way))
            elif spans:
                yield actuate(np.array([random.uniform(*span) for span in spans]))

    def tool_position(self, at: Posture) -> Array | None:
        """World position of the tool point, shape (3,) [m]; None where the robot has no tool."""
        frame = self.chain.description.tool
        if frame is None:
            return None
        link = self.chain.link_placements(at.q_full)[frame.link]
        return np.array((link @ frame.placement)[:3, 3])

    def _can_pull(self, axis: int) -> bool:
        position = self.tool_position(self.chain.home)
        if position is None:
            return False
        try:
            self.chain.reach(position + 1e-3 * self.chain.length * np.eye(3)[axis], self.chain.home)
        except (ClosureError, SingularError, UnreachableError):
            return False
        return True

    def span(self, index: int) -> tuple[float, float]:
        """Limits of an actuated joint, or a turn, or the robot's size, about home where it has none."""
        turns = self.chain.actuators[index].kind == "rotation"
        free, home = FREE_TURN if turns else 2 * self.radius, float(self.chain.home.q[index])
        lower, upper = self._range(index)
        return lower if math.isfinite(lower) else home - free, upper if math.isfinite(upper) else home + free

    def _range(self, index: int) -> tuple[float, float]:
        """Limits of an actuated joint; infinite where the description gives none."""
        joint = self._joints[self.chain.actuators[index].name]
        lower, upper = joint.limits.lower, joint.limits.upper
        if not joint.type.limited:
            lower = upper = None
        return -math.inf if lower is None else lower, math.inf if upper is None else upper

    def _move(self, go: Go, where: Callable[[Posture], str]) -> None:
        """Take the longest part of a move that is allowed, and say what ended it."""
        self.at, stop = self._walker.walk(self.at, go)
        self.stop = None if stop is None else Stop(stop.kind, f"Stopped at {where(self.at)}: {stop.text}")
