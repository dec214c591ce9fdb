"""Inverse kinematics of a chain by its compiled functions: short ways of the tool, plainly on one branch.

Loops and task are led together (`cutjoint.compile.equations.led`), so a step of Newton's method is one evaluation.  A
point that moves on a surface or a curve is led by as many of its places as there are actuators, and all must be met.
The branch is plain where the steps shrink (`cutjoint.compile.equations.newton`) and the determinant
hardly changes: a singular posture on the way would change it more.
"""

from __future__ import annotations

from math import inf, isfinite
from typing import Any

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.short_steps import LARGEST_CHANGE
from cutjoint.compile.equations import newton
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.compile.functions.library import CompiledFunction
from cutjoint.compile.functions.sample import goal_of
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.mechanism import Pose, Posture, Target


class ChainReaching:
    """Leads the tool of one chain.

    Args:
        source: the chain.
        step: its compiled `reach_step`.
        parameters: values of the inertial parameters that are arguments; reaching does not depend on them.
    """

    def __init__(self, source: ChainSource, step: CompiledFunction, parameters: Array) -> None:
        self._source, self._step, self._parameters = source, step, parameters
        self._task, self._origin = source.chain.task, np.array(source.origin)
        self._rows, self._actuated = set(self._task.rows), np.array(source.actuated)
        self._at = {part: step.place(part) for part in ("q_next", "place", "rotation", "residual")}
        self._scalars = slice(step.place("size").start, None)
        self._led = {(0, 1, 2) if self._task.is_of_point else self._task.rows, self._task.rows}

    def to(self, q: Array, given: Any, free: bool) -> Posture | None:  # see `Task.target`
        """From a closed configuration to a target; None where that is not plainly on the same branch, or not all.

        Raises:
            InputError: it is no target.
        """
        target = self._task.target(given, free)
        if target.led not in self._led:
            return None
        found = self.newton(q, goal_of(target.pose, self._origin))
        if found is None:
            return None
        q, y = found
        if not (self._rows.issuperset(target.asked) or self._has_rest(target, y)):
            return None
        distance, angle = y[self._at["residual"]].tolist()
        return Posture(q[self._actuated], q, (distance, angle), self._source.chain.home.layout)

    def newton(self, q: Array, goal: Array) -> tuple[Array, Array] | None:
        """The closed configuration with the task of `goal` (12,) next to a closed one, and what the compiled function
        gives there."""
        kernel, after, scalars = self._step.kernel, self._at["q_next"], self._scalars
        last, worst, start = None, inf, 0.0
        for _ in range(newton.STEPS):
            y = kernel(q, goal, self._parameters)
            size, gap, determinant, strain = y[scalars].tolist()
            if not (strain <= STRAIN_LIMIT and isfinite(np.add.reduce(y))):
                return None
            if last is not None and newton.arrived(gap, worst):
                return q, y
            start = start or determinant
            if not (start and 1.0 / LARGEST_CHANGE < determinant / start < LARGEST_CHANGE):
                return None
            if size > newton.longest(last):
                return None
            last, worst, q = size, gap, y[after]
        return None

    def _has_rest(self, target: Target, y: Array) -> bool:
        """Whether the tool is also where nothing leads it."""
        if target.asked == (0, 1, 2):
            away = np.abs(y[self._at["place"]] - target.pose.position + self._origin)
            return bool(away.max() <= tolerances.CLOSURE.value * self._source.chain.length)
        place, rotation = y[self._at["place"]], y[self._at["rotation"]].reshape(3, 3)
        distance, angle = self._task.left(Pose(place + self._origin, rotation), target)
        near = tolerances.CLOSURE if len(target.asked) == len(target.led) else tolerances.REACHED
        return distance <= near.value * self._source.chain.length and angle <= near.value
