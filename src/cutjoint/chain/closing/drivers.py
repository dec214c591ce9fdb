"""What is prescribed besides the closure: the actuated coordinates, the tool point, or the tool's pose.

A driver leads the robot along a way: `fraction` runs from 0 at its start to 1 at its target.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Placed


class Driver(Protocol):
    """What is prescribed besides the closure; `is_length` says of each row whether it is a length, shape (rows,)."""

    is_length: Array

    def error(self, placed: Placed, fraction: float) -> Array:
        """Present minus wanted value at this fraction of the way, shape (rows,)."""
        ...

    def jacobian(self, placed: Placed) -> Array:
        """Derivative of the error, shape (rows, nv)."""
        ...

    def put(self, q: Array, fraction: float) -> None:
        """Write the coordinates that are prescribed themselves, none as a rule, into a configuration that nearly has
        them."""
        return


class ToolDriver(Driver):
    """Prescribes the tool point in the model, on a straight line from `start` to `target`, shape (3,) [m]."""

    is_length = np.ones(3, dtype=bool)

    def __init__(self, start: Array, target: Array) -> None:
        self._start, self._target = start, target

    def error(self, placed: Placed, fraction: float) -> Array:
        return np.asarray(placed.tool_position - _on_line(self._start, self._target, fraction))

    def jacobian(self, placed: Placed) -> Array:
        return placed.tool_jacobian[:3]


class ActuatedDriver(Driver):
    """Prescribes the actuated coordinates, on a straight line from `start` to `target`, shape (n,)."""

    def __init__(self, q_index: Array, selection: Array, is_length: Array, start: Array, target: Array) -> None:
        self._q_index, self._selection, self.is_length = q_index, selection, is_length
        self._start, self._target = start, target

    def error(self, placed: Placed, fraction: float) -> Array:
        return np.asarray(placed.q[self._q_index] - _on_line(self._start, self._target, fraction))

    def jacobian(self, placed: Placed) -> Array:
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

    def jacobian(self, placed: Placed) -> Array:
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

    def jacobian(self, placed: Placed) -> Array:
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

    def jacobian(self, placed: Placed) -> Array:
        return np.concatenate([self._one.jacobian(placed), self._two.jacobian(placed)])

    def put(self, q: Array, fraction: float) -> None:
        self._one.put(q, fraction)
        self._two.put(q, fraction)
