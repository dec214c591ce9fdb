"""The robot in the hands of the control panel: one posture, moved by an actuator, by the tool, or to another mode.

A move goes as far as it can.  It stops at a joint limit, where the loops cannot be kept closed or the tool cannot go
(the edge of the workspace), and before a singularity; the posture stays closed and on its branch, and `stop` says why.
Where exactly it stops is found by halving the way that is left.  No browser and no server here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.description.model import JointType
from cutjoint.errors import ActuationError, ClosureError, CutjointError, InputError, SingularError, UnreachableError
from cutjoint.mechanism import Posture
from cutjoint.viewer.figure import Figure, css, limb_of

NEAR_SINGULAR = 2e-3
"""A move stops where the distance to a singularity (dimensionless) would fall below this, or below half that of home."""

HALVINGS = 14
"""The place where a move stops is found to 1/2^14 of the move."""

WORKSPACE_SAMPLES = 200
FREE_TURN = math.pi
AXES = ("x", "y", "z")
ROUNDING = 1e-9


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
        self._report = report
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
        near = self.at

        def go(fraction: float) -> Posture:
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
        near = self.at

        def go(fraction: float) -> Posture:
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

    def sample_workspace(self) -> Iterator[bool]:
        """Widen `box` by one random posture of this branch each time; yields whether it has changed."""
        random = np.random.default_rng(0)
        sliders = self.actuated_sliders()
        low, high = (np.array([getattr(s, end) for s in sliders]) for end in ("lower", "upper"))
        near = self.chain.home
        home = self.tool_position(near)
        if home is None or not sliders:
            return
        self.box = np.array([home, home])
        for _ in range(WORKSPACE_SAMPLES):
            try:
                near = self.chain.close(random.uniform(low, high), near)
            except (ClosureError, SingularError):
                yield False
                continue
            if self._refusal(near, {}) is not None:
                near = self.chain.home
                yield False
                continue
            position = self.tool_position(near)
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
            "toggles": [{"title": t, "paths": p, "shown": s} for t, (p, s) in self._figure.toggles.items()],
        }

    def state(self) -> dict[str, Any]:
        """The posture and its live figures, as JSON; None where a figure is not defined."""
        report = self._report if self.at is self.chain.home else self.chain.mobility(self.at)
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

    def _move(self, go: Callable[[float], Posture], where: Callable[[Posture], str]) -> None:
        """Take the longest part of a move that is allowed, and say what ended it."""
        before = self.chain.limit_violations(self.at)
        found, stop = self._try(go, 1.0, before)
        if found is not None:
            self.at, self.stop = found, None
            return
        done, open_end, last = 0.0, 1.0, self.at
        for _ in range(HALVINGS):
            middle = 0.5 * (done + open_end)
            found, why = self._try(go, middle, before)
            if found is not None:
                done, last = middle, found
            else:
                open_end, stop = middle, why
        self.at = last
        self.stop = None if stop is None else Stop(stop.kind, f"Stopped at {where(last)}: {stop.text}")

    def _try(
        self, go: Callable[[float], Posture], fraction: float, before: Any
    ) -> tuple[Posture | None, Stop | None]:
        try:
            found = go(fraction)
        except SingularError as error:
            return None, Stop("singularity", f"a {error.kind} singularity lies ahead")
        except UnreachableError:
            return None, Stop("workspace", "this is the edge of the workspace; the tool cannot go further on this branch")
        except ClosureError:
            return None, Stop("workspace", "the loops cannot be kept closed beyond (a type-2 singularity bounds the motion)")
        except CutjointError as error:
            return None, Stop("limit", str(error))
        refusal = self._refusal(found, before)
        return (found, None) if refusal is None else (None, refusal)

    def _refusal(self, at: Posture, before: Any) -> Stop | None:
        for name, (value, lower, upper) in self.chain.limit_violations(at).items():
            if name not in before and not lower - ROUNDING <= value <= upper + ROUNDING:
                unit = "m" if self._joints[name].type is JointType.PRISMATIC else "rad"
                return Stop("limit", f"joint {name} is at its limit {lower if value < lower else upper:.4g} {unit}")
        if math.isfinite(self._guard) and self._guard > 0:
            report = self.chain.mobility(at)
            for kind, value in (("type-1", report.type1), ("type-2", report.type2)):
                if value < self._guard and not value >= self._distance(kind):
                    return Stop("singularity", f"a {kind} singularity is near (distance {value:.2g})")
        return None

    def _distance(self, kind: str) -> float:
        report = self.chain.mobility(self.at)
        return report.type1 if kind == "type-1" else report.type2


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
