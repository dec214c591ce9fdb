"""The robot in the hands of the control panel: one posture, moved by an actuator, by the tool, or to another mode.

A move goes as far as it can.  It stops at a joint limit, where the loops cannot be kept closed or the tool cannot go
(the edge of the workspace), and before a singularity; the posture stays closed and on its branch, and `stop` says why.
No browser and no server here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.description.model import JointType
from cutjoint.errors import ActuationError, ClosureError, InputError, SingularError, UnreachableError
from cutjoint.mechanism import Posture
from cutjoint.viewer.hand.walk import Go, Stop, Walker
from cutjoint.viewer.picture.figure import Figure, css, limb_of

WORKSPACE_SAMPLES = 24
FREE_TURN = math.pi
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Slider:
    """A slider of the panel: what it moves (number of an actuator or of an axis), its unit and range."""

    index: int
    name: str
    unit: str
    lower: float
    upper: float
    colour: str = ""

    def as_json(self) -> dict[str, Any]:
        """As the page wants it."""
        return {k: getattr(self, k) for k in ("index", "name", "unit", "lower", "upper", "colour")}


class Puppet:
    """A closed chain and its present posture.

    Attributes:
        at: the posture, always closed.
        stop: why the last move ended early, or None.
        mode: index into `modes` of the branch that `at` is on.
        modes: working modes found so far; the first is that of home.
        box: bounding box of the tool positions sampled so far, shape (2, 3) [m], or None.
    """

    def __init__(self, chain: ClosedChain, figure: Figure) -> None:
        self.chain = chain
        self._figure = figure
        self.at = chain.home
        self.stop: Stop | None = None
        self.modes: tuple[Posture, ...] = (chain.home,)
        self.mode = 0
        self.box: Array | None = None
        self._axes = [axis for axis in range(3) if self._can_pull(axis)]
        self._walker = Walker(chain)
        self._joints = {joint.name: joint for joint in chain.description.joints}

    # ---- moves -----------------------------------------------------------------------------------------------------

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
        axes = np.eye(3)[self._axes]
        ways = list(np.concatenate([axes, -axes]))
        sliders = self.actuated_sliders()

        def pull(to: Array) -> Go:
            return lambda share, near: chain.reach(home + share * (to - home), near)

        def actuate(to: Array) -> Go:
            return lambda share, near: chain.close(chain.home.q + share * (to - chain.home.q), near)

        for _ in range(samples):
            if len(axes):
                way = ways.pop(0) if ways else random.normal(size=len(axes)) @ axes
                yield pull(home + 2.0 * self._figure.radius * way / np.linalg.norm(way))
            elif sliders:
                yield actuate(np.array([random.uniform(slider.lower, slider.upper) for slider in sliders]))

    # ---- what the page shows ---------------------------------------------------------------------------------------

    def actuated_sliders(self) -> list[Slider]:
        """A slider per actuator, with the limits of its joint (or a turn, or the robot's size, where it has none)."""
        found = []
        for i, actuator in enumerate(self.chain.actuators):
            free = FREE_TURN if actuator.kind == "rotation" else 2 * self._figure.radius
            home = float(self.chain.home.q[i])
            lower, upper = self._range(i)
            lower = lower if math.isfinite(lower) else home - free
            upper = upper if math.isfinite(upper) else home + free
            colour = css(self._figure.colours[actuator.name])
            found.append(Slider(i, actuator.name, actuator.unit, lower, upper, colour))
        return found

    def tool_sliders(self) -> list[Slider]:
        """A slider per world axis along which the tool can be pulled at home, over the sampled workspace and a little
        more."""
        position = self.tool_position(self.at)
        if position is None:
            return []
        half = 0.5 * self._figure.radius
        low, high = position - half, position + half
        if self.box is not None:
            wide = np.ptp(self.box, axis=0) > 0.0
            low, high = np.where(wide, self.box[0], low), np.where(wide, self.box[1], high)
        margin = 0.1 * (high - low)
        low, high = low - margin, high + margin
        return [Slider(axis, AXES[axis], "m", float(low[axis]), float(high[axis])) for axis in self._axes]

    def mode_names(self) -> list[str]:
        """A name per working mode: the limbs whose joints stand otherwise than at home."""
        owners = limb_of(self.chain.description)
        home = self.chain.home.q_full
        names = ["1: as at home"]
        for number, mode in enumerate(self.modes[1:], start=2):
            limbs: dict[str, None] = {}
            for joint in self.chain.description.joints:
                if joint.type in (JointType.REVOLUTE, JointType.CONTINUOUS) and joint.child in owners:
                    i = self.chain.model.idx_qs[self.chain.model.getJointId(joint.name)]
                    if abs(math.remainder(mode.q_full[i] - home[i], 2 * math.pi)) > 1e-3:
                        limbs[owners[joint.child]] = None
            names.append(f"{number}: other {', '.join(limbs) or 'assembly'}")
        return names

    def controls(self) -> dict[str, Any]:
        """Sliders, modes and toggles, as JSON."""
        return {
            "type": "controls",
            "title": self.chain.description.title or self.chain.name,
            "source": self.chain.description.source,
            "actuated": [slider.as_json() for slider in self.actuated_sliders()],
            "tool": [slider.as_json() for slider in self.tool_sliders()],
            "note": self._note(),
            "modes": self.mode_names(),
            "labels": self._figure.labels(),
            "toggles": [{"title": t, "paths": p, "shown": s} for t, (p, s) in self._figure.toggles.items()],
        }

    def _note(self) -> str:
        """What a user should know about how the actuators move this robot."""
        report = self.chain.mobility(self.chain.home)
        if report.determined or not self.chain.n:
            return ""
        if report.actuators > report.mobility:
            return "The actuators depend on each other: one alone cannot move. Pull the tool instead."
        return f"With all actuators locked, {', '.join(report.free)} can still move; they move as little as they can."

    def state(self) -> dict[str, Any]:
        """The posture and its live figures, as JSON; None where a figure is not defined."""
        report = self.chain.mobility(self.at)
        position = self.tool_position(self.at)
        effort: list[float] | None = None
        try:
            effort = [float(x) for x in self.chain.terms(self.at).gravity]
        except (ActuationError, SingularError, InputError):
            effort = None
        return {
            "type": "state",
            "q": [float(x) for x in self.at.q],
            "tool": None if position is None else [float(x) for x in position],
            "gap": [_number(x) for x in self.at.gap],
            "mobility": report.mobility,
            "rank": report.rank,
            "rows": report.rows,
            "type1": _number(report.type1),
            "type2": _number(report.type2),
            "condition": _number(report.condition),
            "effort": effort,
            "effort_units": [actuator.effort_unit for actuator in self.chain.actuators],
            "mode": self.mode,
            "stop": None if self.stop is None else {"kind": self.stop.kind, "text": self.stop.text},
        }

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

    def _range(self, index: int) -> tuple[float, float]:
        """Limits of an actuated joint; infinite where the description gives none."""
        joint = self._joints[self.chain.actuators[index].name]
        lower, upper = joint.limits.lower, joint.limits.upper
        if joint.type is JointType.CONTINUOUS:
            lower = upper = None
        return -math.inf if lower is None else lower, math.inf if upper is None else upper

    # ---- inside ----------------------------------------------------------------------------------------------------

    def _move(self, go: Go, where: Callable[[Posture], str]) -> None:
        """Take the longest part of a move that is allowed, and say what ended it."""
        self.at, stop = self._walker.walk(self.at, go)
        self.stop = None if stop is None else Stop(stop.kind, f"Stopped at {where(self.at)}: {stop.text}")


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
