"""Where motions start: the tool of a robot at home, and the directions in which its point can be led from there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.errors import InputError
from cutjoint.mechanism import Mechanism, Pose

STILL = 1e-9
"""Directions in which the tool moves less than this beside the quickest are none."""
PLAIN = 0.57
"""An axis of the world is a direction of a plane if this much of it lies there: of three axes two do (1/3^0.5)."""


@dataclass(frozen=True, eq=False)
class ToolAtHome(Frozen):
    """The tool at home.

    Attributes:
        robot: its name, for messages.
        pose: of the tool.
        basis: axes of the task as columns, shape (3, 3).
        directions: orthonormal columns in which the point can be led while what else the task leads stays, the easiest
            first, shape (3, k).
    """

    robot: str
    pose: Pose
    basis: Array
    directions: Array

    @classmethod
    def of(cls, mechanism: Mechanism) -> ToolAtHome:
        """That of a mechanism.

        Raises:
            InputError: it has no tool, or its task cannot be told.
        """
        task, tool = mechanism.task, mechanism.tool(mechanism.home)
        turns = [row for row in task.rows if row >= 3]
        held = task.towards(tool.pose, turns).matrix(tool.rotation) @ tool.frame_jacobian
        point = tool.jacobian
        if held.size:
            _, sizes, motions = np.linalg.svd(held)
            rank = int((sizes > 1e-7 * sizes.max(initial=1e-300)).sum())
            point = point @ motions[rank:].T
        directions, sizes, _ = np.linalg.svd(point, full_matrices=False)
        led = sizes > STILL * np.linalg.norm(tool.jacobian)
        axes = [axis * np.sign(axis[np.argmax(np.abs(axis))]) for axis in directions.T[led]]
        return cls(mechanism.name, tool.pose, task.basis, np.reshape(axes, (-1, 3)).T)

    def by(self, x: float, y: float, z: float) -> Array:
        """The point that is (x, y, z) [m] away along the axes of the task, as a rule the world's, shape (3,)."""
        return np.asarray(self.pose.position + self.basis @ np.array([x, y, z]))

    def plane(self, what: str) -> tuple[Array, Array]:
        """The two directions in which the point moves most easily.

        Raises:
            InputError: there are less than two, so that it cannot go along `what`.
        """
        count = self.directions.shape[1]
        if count < 2:
            where = "moves along a line" if count else "stays where it is"
            raise InputError(f"the tool of {self.robot} {where}; it cannot follow {what}")
        return self.directions[:, 0], self.directions[:, 1]

    def upright(self, what: str) -> tuple[Array, Array]:
        """Two directions in which the point can be led: up (along z of the world; in a level plane along y), and across
        (along x, as far as that can be).

        Raises:
            InputError: there are less than two, so that it cannot go along `what`.
        """
        self.plane(what)
        span = self.directions
        up = _first(span @ span.T, (2, 1, 0))
        return up, _first(span @ span.T - np.outer(up, up), (0, 1, 2))


def _first(projection: Array, order: tuple[int, ...]) -> Array:
    """The first axis of the world that lies in a plane well enough, projected into it."""
    sizes = np.linalg.norm(projection, axis=0)
    axis = next((one for one in order if sizes[one] >= PLAIN), int(np.argmax(sizes)))
    return np.asarray(projection[:, axis] / sizes[axis])


def orthonormal(name: str, columns: Array, count: int) -> Array:
    """Columns as they are, where they are orthogonal unit vectors, shape (3, count).

    Raises:
        InputError: they are none; the message names them.
    """
    array = np.asarray(columns, dtype=np.float64)
    if array.shape != (3, count) or not np.allclose(array.T @ array, np.eye(count), rtol=0.0, atol=1e-12):
        raise InputError(f"{name} must be orthogonal unit vectors, found {array.T.tolist()}")
    return array
