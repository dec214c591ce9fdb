"""The robot in the hands of the control panel: one posture, moved by an actuator, by the tool, or to another mode.

A move goes as far as it can.  It stops at a joint limit, where the loops cannot be kept closed or the tool cannot go
(the edge of the workspace), and before a singularity; the posture stays closed and on its branch, and `stop` says why.
No browser and no server here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.chain.kinematics import velocity_scale
from cutjoint.description.model import JointType
from cutjoint.errors import ActuationError, ClosureError, InputError, SingularError, UnreachableError
from cutjoint.mechanism import Posture
from cutjoint.viewer.figure import Figure, css, limb_of

NEAR_SINGULAR = 2e-3
"""A move stops where the distance to a singularity (dimensionless) would fall below this, or below half that of home."""

SMALLEST_MOTION = 1e-3
SMALLEST_STEP = 1e-6
"""The place where a move stops is found to this motion of the joints (dimensionless), or this part of the move."""

WORKSPACE_SAMPLES = 30
FREE_TURN = math.pi
AXES = ("x", "y", "z")
ROUNDING = 1e-9

Go = Callable[[float, Posture], Posture]
"""The posture at a fraction of a move, from a posture near it."""


@dataclass(frozen=True)
class Stop:
    """Why a move ended early."""

    kind: Literal["limit", "workspace", "singularity"]
    text: str


@dataclass(frozen=True)
class Slider:
    """A slider of the panel: what it moves, its unit and range."""

    name: str
    unit: str
    lower: float
    upper: float
    colour: str = ""

    def as_json(self) -> dict[str, Any]:
        """As the page wants it."""
        return {k: getattr(self, k) for k in ("name", "unit", "lower", "upper", "colour")}


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
        report = chain.mobility(chain.home)
        self._scale = velocity_scale(chain.model, chain.length)
        nearest = min((x for x in (report.type1, report.type2) if math.isfinite(x)), default=math.inf)
        self._guard = min(NEAR_SINGULAR, 0.5 * nearest)
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
        self.modes = self.chain.working_modes(self.chain.home)

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
        """Widen `box` by one random posture of this branch each time; yields whether it has changed."""
        random = np.random.default_rng(0)
        sliders = self.actuated_sliders()
        low, high = (np.array([getattr(s, end) for s in sliders]) for end in ("lower", "upper"))
        at = self.chain.home
        home = self.tool_position(at)
        if home is None or not sliders:
            return
        self.box = np.array([home, home])
        for _ in range(samples):
            start, target = np.array(at.q), random.uniform(low, high)

            def go(fraction: float, near: Posture, start: Array = start, target: Array = target) -> Posture:
                return self.chain.close(start + fraction * (target - start), near)

            at, _ = self._walk(at, go)
            position = self.tool_position(at)
            before = self.box
            if position is not None:
                self.box = np.array([np.minimum(before[0], position), np.maximum(before[1], position)])
            yield bool((self.box != before).any())

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
            found.append(Slider(actuator.name, actuator.unit, lower, upper, colour))
        return found

    def tool_sliders(self) -> list[Slider]:
        """A slider per tool axis, over the sampled workspace and a little more; none where the robot has no tool."""
        position = self.tool_position(self.at)
        if position is None:
            return []
        half = 0.5 * self._figure.radius
        low, high = (position - half, position + half) if self.box is None else (self.box[0], self.box[1])
        margin = 0.1 * np.maximum(high - low, 0.1 * self._figure.radius)
        return [Slider(n, "m", float(low[i] - margin[i]), float(high[i] + margin[i])) for i, n in enumerate(AXES)]

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
            "modes": self.mode_names(),
            "labels": self._figure.labels(),
            "toggles": [{"title": t, "paths": p, "shown": s} for t, (p, s) in self._figure.toggles.items()],
        }

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
        self.at, stop = self._walk(self.at, go)
        self.stop = None if stop is None else Stop(stop.kind, f"Stopped at {where(self.at)}: {stop.text}")

    def _walk(self, at: Posture, go: Go) -> tuple[Posture, Stop | None]:
        """Walk from `at` along `go`; returns how far it came and what ended it, if anything did.

        A step moves no joint by more than half the distance to a singularity (both dimensionless), so none is stepped
        over and the branch is kept.  Watching a determinant change sign would be cheaper and is not enough: in a
        symmetric robot two limbs pass their singularities at once.
        """
        before, distances = self.chain.limit_violations(at), self._distances(at)
        done, step = 0.0, 1.0
        while done < 1.0:
            end = min(1.0, done + step)
            stride = max(0.5 * min(*distances, 1.0), SMALLEST_MOTION)
            found, stop = self._try(go, end, at)
            motion = math.inf if found is None else self._motion(at, found)
            if found is not None and motion <= stride:
                there = self._distances(found)
                stop = self._refusal(found, before, distances, there)
                if stop is None:
                    at, done, distances = found, end, there
                    step *= 2.0
                    continue
            step = (end - done) * (min(0.5, 0.9 * stride / motion) if math.isfinite(motion) else 0.5)
            if step < SMALLEST_STEP or (stop is not None and motion < SMALLEST_MOTION):
                return at, stop or Stop("singularity", "a singularity is near: the joints would have to move very fast")
        return at, None

    def _try(self, go: Go, fraction: float, near: Posture) -> tuple[Posture | None, Stop | None]:
        try:
            return go(fraction, near), None
        except SingularError as error:
            return None, Stop("singularity", f"a {error.kind} singularity lies ahead")
        except UnreachableError:
            return None, Stop("workspace", "this is the edge of the workspace; the tool cannot go further on this branch")
        except ClosureError:
            return None, Stop("workspace", "the loops cannot be kept closed beyond; a type-2 singularity bounds the motion")

    def _refusal(
        self, at: Posture, before: Mapping[str, object], last: tuple[float, float], now: tuple[float, float]
    ) -> Stop | None:
        """Why `at` must not be taken, at distances `now` to singularities, coming from distances `last`."""
        for name, (value, lower, upper) in self.chain.limit_violations(at).items():
            if name not in before and not lower - ROUNDING <= value <= upper + ROUNDING:
                unit = "m" if self._joints[name].type is JointType.PRISMATIC else "rad"
                return Stop("limit", f"joint {name} is at its limit {lower if value < lower else upper:.4g} {unit}")
        for kind, here, there in zip(("type-1", "type-2"), now, last, strict=True):
            if here < self._guard and here < there:
                return Stop("singularity", f"a {kind} singularity is near (distance {here:.2g})")
        return None

    def _distances(self, at: Posture) -> tuple[float, float]:
        """Distance to type-1 and type-2 singularities; infinite where undefined."""
        report = self.chain.mobility(at)
        type1, type2 = (x if math.isfinite(x) else math.inf for x in (report.type1, report.type2))
        return type1, type2

    def _motion(self, start: Posture, end: Posture) -> float:
        """Largest motion of any joint between two postures, lengths over the characteristic length."""
        difference = pin.difference(self.chain.model, np.array(start.q_full), np.array(end.q_full))
        return float(np.abs(difference / self._scale).max(initial=0.0))


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
