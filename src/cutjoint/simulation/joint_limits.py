"""Joint limits during a run: which joint passed which of its bounds, and when.

Limits are watched at every state that is accepted or recorded, not at the stages of a method, which may overshoot.  A
joint that starts beyond its limits may come back, but not go further: how far it is beyond them may only fall.  The
time of a crossing is bisected on what is known between two states (`cutjoint.simulation.interpolant`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.mechanism import Mechanism
from cutjoint.simulation.plant import State

HALVINGS = 50
"""Bisections of a step in search of a crossing: to rounding."""


class Passed(NamedTuple):
    """A joint beyond its limits: its name, where it is and its limits, all in `unit`."""

    joint: str
    value: float
    lower: float
    upper: float
    unit: str

    def __str__(self) -> str:
        side, bound = ("lower", self.lower) if self.value < self.lower else ("upper", self.upper)
        return f"joint '{self.joint}' passes its {side} limit of {bound:.6g} {self.unit}"


class JointGuard:
    """Watches the joints of a chain, passive ones too, but not those with stops, whose force turns them back.
    Published models know no limits: nothing is found.

    Args:
        mechanism: the robot.
        start: its first state.
    """

    def __init__(self, mechanism: Mechanism, start: State) -> None:
        robot = getattr(mechanism, "plain", mechanism)  # of a compiled robot, the chain it was made from
        self._names: list[str] = []
        self._units: list[str] = []
        index: list[int] = []
        if isinstance(robot, ClosedChain):
            model = robot.model
            stopped = {one.name for one in robot.description.joints if one.physics.stop_stiffness > 0.0}
            single = [joint for joint in range(1, model.njoints) if model.nqs[joint] == 1]
            joints = [joint for joint in single if str(model.names[joint]) not in stopped]
            self._names = [str(model.names[joint]) for joint in joints]
            self._units = [robot.description.joint(name).type.coordinates[0].unit for name in self._names]
            index = [int(model.idx_qs[joint]) for joint in joints]
            self._lower, self._upper = model.lowerPositionLimit[index], model.upperPositionLimit[index]
            # what a closed posture may miss by rounding
            sizes = np.array([robot.length if unit == "m" else 1.0 for unit in self._units])
            slack = tolerances.CLOSURE.value * sizes
            # and what one that rests at a limit, or beyond, may by the errors of the run
            self._resting = tolerances.RESTING.value * sizes
            at = (start.q if start.posture is None else start.posture.q_full)[index]
            low, high = (self._resting > np.abs(at - bound) for bound in (self._lower, self._upper))
            self._usual_least = self._lower - np.where(low, self._resting, slack)
            self._usual_most = self._upper + np.where(high, self._resting, slack)
            self._least, self._most = np.full(len(index), -np.inf), np.full(len(index), np.inf)
        self._index = index
        self.accept(start)

    def passed(self, state: State) -> Passed | None:
        """The joint that is furthest beyond what it may be, or None."""
        if not self._index:
            return None
        at = self._joints(state)
        over = np.maximum(self._least - at, at - self._most)
        worst = int(over.argmax())
        if not over[worst] > 0.0:
            return None
        bounds = float(self._lower[worst]), float(self._upper[worst])
        return Passed(self._names[worst], float(at[worst]), *bounds, self._units[worst])

    def accept(self, state: State) -> None:
        """From here on no joint may be further beyond its limits than at `state`, but for errors of the run."""
        if self._index:
            at = self._joints(state)
            self._least = np.minimum(self._usual_least, np.maximum(self._least, at - self._resting))
            self._most = np.maximum(self._usual_most, np.minimum(self._most, at + self._resting))

    def _joints(self, state: State) -> Array:
        return np.asarray((state.q if state.posture is None else state.posture.q_full)[self._index])


def crossing(inside: float, beyond: float, passed: Callable[[float], Passed | None]) -> float:
    """The last time [s] between `inside` and `beyond` at which no joint has passed its limits."""
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + beyond)
        if not inside < middle < beyond:
            break
        if passed(middle) is None:
            inside = middle
        else:
            beyond = middle
    return inside
