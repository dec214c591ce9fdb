"""Inverse kinematics of a chain by its compiled functions: short ways of the tool, plainly on one branch.

Loops and task are led together (`cutjoint.compile.equations.led`), so a step of Newton's method is one evaluation.  A
point that moves on a surface or a curve is led by as many of its places as there are actuators, and all must be met.
The branch is plain where the steps shrink (`cutjoint.compile.equations.newton`) and the determinant
hardly changes: a singular posture on the way would change it more.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isfinite

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.short_steps import LARGEST_CHANGE
from cutjoint.compile.closing import walked
from cutjoint.compile.equations import newton
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.compile.functions.library import Library
from cutjoint.compile.functions.sample import goal_of
from cutjoint.compile.functions.table import function
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.errors import CutjointError
from cutjoint.mechanism import Pose, Posture, Target, TargetLike
from cutjoint.mechanism.rotations import vector_of


class ChainReaching:
    """Leads the tool of one chain.

    Args:
        source: the chain.
        library: its compiled functions.
        parameters: values of the parameters that are arguments, shape (parameters,) or a row each.

    Raises:
        CutjointError: the chain has no `reach_step`.
    """

    def __init__(self, source: ChainSource, library: Library, parameters: Array) -> None:
        self._source, self._library, self._parameters = source, library, parameters
        self._step = step = library["reach_step"]
        self._task, self._origin = source.chain.task, np.array(source.origin)
        self._rows, self._actuated = set(self._task.rows), np.array(source.actuated)
        self._at = {part: step.place(part) for part in ("q_next", "place", "rotation", "residual")}
        self._scalars = slice(step.place("size").start, None)
        self._led = {(0, 1, 2) if self._task.is_of_point else self._task.rows, self._task.rows}

    def __reduce__(self) -> tuple[object, ...]:
        return ChainReaching, (self._source, self._library, self._parameters)

    @classmethod
    def where_led(cls, source: ChainSource, library: Library, parameters: Array) -> ChainReaching | None:
        """None where the task does not say where the actuators are, no order of elimination serves, or the task is
        another one at these values of the parameters."""
        try:
            if not source.keeps_task(parameters):
                return None

            return cls(source, library, parameters)
        except CutjointError:
            if all(source.lacks(need) is None for need in function("reach_step").needs):
                raise
            return None

    def to(self, q: Array, given: TargetLike, free: bool) -> Posture | None:
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
        if not self._rows.issuperset(target.asked):
            place, rotation = y[self._at["place"]], y[self._at["rotation"]].reshape(3, 3)
            if not self._has_rest(target, place, rotation):
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

    def walk(self, q: Array, goals: Array, threads: int) -> tuple[Array, npt.NDArray[np.bool_]]:
        """Walk all rows from the closed `q` to the task of their `goals` (N, 12), straight and turning about one axis;
        also returns which arrived, on the branch they started from (see `walked`)."""
        function = self._step
        begun, _ = function.batch([q, goals, self._parameters], threads)
        start, first = begun["place"], begun["determinant"][:, 0]
        foot, wanted = begun["rotation"], goals[:, 3:].reshape(-1, 3, 3)
        turns = np.array([vector_of(one) for one in wanted @ foot.transpose(0, 2, 1)]).reshape(-1, 3)

        def step(at: Array, fraction: float) -> tuple[Array, Array, Array]:
            to = goals
            if fraction < 1.0:
                place, turn = start + fraction * (goals[:, :3] - start), _turned(fraction * turns) @ foot
                to = np.concatenate([place, turn.reshape(-1, 9)], axis=1)
            parts, trusted = function.batch([at, to, self._parameters], threads)
            crossed = parts["determinant"][:, 0] * first <= 0.0
            size = np.where(trusted & ~crossed, parts["size"][:, 0], np.inf)
            return parts["q_next"], size, parts["gap"][:, 0]

        return walked(q, step)

    def many(self, q: Array, targets: Sequence[Target], threads: int) -> tuple[Array, npt.NDArray[np.bool_]]:
        """Configurations (N, positions) with the tool at N targets, walked from closed ones, one for all or a row each;
        also returns which have all that is asked for."""
        goals = np.array([goal_of(one.pose, self._origin) for one in targets]).reshape(-1, 12)
        start = np.array(np.broadcast_to(q, (len(goals), q.shape[-1])))
        found, good = self.walk(start, goals, threads)
        parts, _ = self._step.batch([found, goals, self._parameters], threads)
        for row in np.flatnonzero(good).tolist():
            target = targets[row]
            if target.led not in self._led:
                good[row] = False
            elif not self._rows.issuperset(target.asked):
                good[row] = self._has_rest(target, parts["place"][row], parts["rotation"][row])
        return found, good

    def _has_rest(self, target: Target, place: Array, rotation: Array) -> bool:
        """Whether the tool is also where nothing leads it."""
        length = self._source.chain.length
        if target.asked == (0, 1, 2):
            away = np.abs(place - target.pose.position + self._origin)
            return bool(away.max() <= tolerances.CLOSURE.value * length)
        distance, angle = self._task.left(Pose(place + self._origin, rotation), target)
        near = tolerances.CLOSURE if len(target.asked) == len(target.led) else tolerances.REACHED
        return distance <= near.value * length and angle <= near.value


def _turned(vectors: Array) -> Array:
    """Rotations (N, 3, 3) of rotation vectors (N, 3)."""
    angle = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))[:, None, None]
    cross = np.cross(vectors[:, None, :], -np.eye(3))
    return np.asarray(
        np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(0.5 * angle / np.pi) ** 2 * (cross @ cross)
    )
