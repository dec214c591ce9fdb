"""What is prescribed besides the closure: the actuated coordinates, the tool point, its task, or its pose.

A driver leads the robot along a way: `fraction` runs from 0 at its start to 1 at its target.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Placed
from cutjoint.mechanism import Pose, Task
from cutjoint.mechanism.rotations import turned, vector_of
from cutjoint.mechanism.task import Condition


class Driver(Protocol):
    """What is prescribed besides the closure.

    Attributes:
        is_length: whether each row is a length, shape (rows,).
        is_of_tool: whether its lengths are places of the tool.
    """

    is_length: Array
    is_of_tool: bool = False

    def error(self, placed: Placed, fraction: float) -> Array:
        """Present minus wanted value at this fraction of the way, shape (rows,)."""
        ...

    def jacobian(self, placed: Placed, fraction: float = 1.0) -> Array:
        """Derivative of the error at this fraction of the way, shape (rows, nv)."""
        ...

    def put(self, q: Array, fraction: float) -> None:
        """Write the coordinates that are prescribed themselves, none as a rule, into a configuration that nearly has
        them."""
        return


class ToolDriver(Driver):
    """Prescribes the tool point in the model, on a straight line from `start` to `target`, shape (3,) [m]."""

    is_length, is_of_tool = np.ones(3, dtype=bool), True

    def __init__(self, start: Array, target: Array) -> None:
        self._start, self._target = start, target

    def error(self, placed: Placed, fraction: float) -> Array:
        return np.asarray(placed.tool_position - _on_line(self._start, self._target, fraction))

    def jacobian(self, placed: Placed, fraction: float = 1.0) -> Array:
        return placed.tool_jacobian[:3]


class TaskDriver(Driver):
    """Prescribes rows of a task, on a straight way of the tool in the model that turns about one axis.

    The way leads from `start` to `target`, shape (6,) each: position, and rotation vector away from `foot`, whose
    angles are lengths too, at the radius `length` [m].
    """

    is_of_tool = True

    def __init__(self, task: Task, rows: Sequence[int], foot: Pose, length: float, start: Array, target: Array) -> None:
        self._task, self._rows, self._foot, self._length = task, list(rows), foot, length
        self._start, self._target = start, target
        self._goal = self._at(target)
        self.is_length = np.array([row < 3 for row in rows])

    @staticmethod
    def way(foot: Pose, pose: Pose, length: float) -> Array:
        """A pose as a place on the way, shape (6,) [m]."""
        return np.concatenate([pose.position, length * vector_of(pose.rotation @ foot.rotation.T)])

    def error(self, placed: Placed, fraction: float) -> Array:
        return self._wanted(fraction).error(placed.tool_position, placed.tool_axes)

    def jacobian(self, placed: Placed, fraction: float = 1.0) -> Array:
        return np.asarray(self._wanted(fraction).matrix(placed.tool_axes).dot(placed.tool_jacobian))

    def _wanted(self, fraction: float) -> Condition:
        return self._goal if fraction == 1.0 else self._at(_on_line(self._start, self._target, fraction))

    def _at(self, place: Array) -> Condition:
        rotation = turned(place[3:] / self._length) @ self._foot.rotation
        return self._task.towards(Pose(place[:3], rotation), self._rows)


class ActuatedDriver(Driver):
    """Prescribes the actuated coordinates, on a straight line from `start` to `target`, shape (n,)."""

    def __init__(self, q_index: Array, selection: Array, is_length: Array, start: Array, target: Array) -> None:
        self._q_index, self._selection, self.is_length = q_index, selection, is_length
        self._start, self._target = start, target

    def error(self, placed: Placed, fraction: float) -> Array:
        return np.asarray(placed.q[self._q_index] - _on_line(self._start, self._target, fraction))

    def jacobian(self, placed: Placed, fraction: float = 1.0) -> Array:
        return self._selection

    def put(self, q: Array, fraction: float) -> None:
        q[self._q_index] = _on_line(self._start, self._target, fraction)


def _on_line(start: Array, target: Array, fraction: float) -> Array:
    return target if fraction == 1.0 else start + fraction * (target - start)


class PoseDriver(Driver):
    """Prescribes the tool's placement in the model."""

    is_length = np.array([True] * 3 + [False] * 3)

    def __init__(self, pose: pin.SE3) -> None:
        self._pose = pose

    def error(self, placed: Placed, fraction: float) -> Array:
        pose = placed.tool
        return np.concatenate([pose.translation - self._pose.translation, self._turn(pose.rotation)])

    def jacobian(self, placed: Placed, fraction: float = 1.0) -> Array:
        return placed.tool_jacobian

    def _turn(self, rotation: Array) -> Array:
        """Rotation vector from the wanted rotation to this one, in the axes of the model."""
        wanted = self._pose.rotation
        return np.asarray(wanted @ pin.log3(wanted.T @ rotation))


class TiltDriver(PoseDriver):
    """Prescribes the tool point and one axis of the tool, about which it may turn."""

    def __init__(self, pose: pin.SE3, axis: Array) -> None:
        super().__init__(pose)
        self._axis, self._flat = axis, np.eye(3) - np.outer(axis, axis)
        self._aside = np.linalg.svd(self._flat)[0][:, 0]

    def jacobian(self, placed: Placed, fraction: float = 1.0) -> Array:
        jacobian = placed.tool_jacobian
        jacobian[3:] = self._flat @ jacobian[3:]
        return jacobian

    def _turn(self, rotation: Array) -> Array:
        carried = rotation @ (self._pose.rotation.T @ self._axis)
        sine, cosine = np.cross(self._axis, carried), float(self._axis @ carried)
        size = float(np.linalg.norm(sine))
        if size < 1e-12 and cosine < 0.0:
            return np.asarray(np.pi * self._aside)
        return np.asarray(sine * (np.arctan2(size, cosine) / size if size > 1e-12 else 1.0))


class Both(Driver):
    """Prescribes what two drivers prescribe."""

    def __init__(self, one: Driver, two: Driver) -> None:
        self._one, self._two = one, two
        self.is_length = np.concatenate([one.is_length, two.is_length])

    def error(self, placed: Placed, fraction: float) -> Array:
        return np.concatenate([self._one.error(placed, fraction), self._two.error(placed, fraction)])

    def jacobian(self, placed: Placed, fraction: float = 1.0) -> Array:
        return np.concatenate([self._one.jacobian(placed, fraction), self._two.jacobian(placed, fraction)])

    def put(self, q: Array, fraction: float) -> None:
        self._one.put(q, fraction)
        self._two.put(q, fraction)
