"""What coordinates over a grid, and others that are held, ask of a tool."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.chain import ClosedChain
from cutjoint.compile import CompiledChain
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Mechanism, Pose, Posture, Task
from cutjoint.mechanism.task import NAMES
from cutjoint.reprs import line


@dataclass(frozen=True, eq=False)
class Goals(Frozen):
    """Coordinates of a task: those that the grid is over, and those that are held.

    Attributes:
        task: of the robot.
        names: coordinates that the grid is over.
        held: the others -> [m] or [rad].
        origin: of the compiled model, in the world [m].
        free: whether coordinates of the task that are neither may be as they like.
    """

    task: Task
    names: tuple[str, ...]
    held: Mapping[str, float]
    origin: Array
    free: bool = False

    __repr__ = line("names", "held")

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of every coordinate of the grid."""
        return tuple("m" if NAMES.index(name) < 3 else "rad" for name in self.names)

    @property
    def basis(self) -> Array:
        """Axes of the task as columns, shape (3, 3)."""
        return self.task.basis

    def named(self, at: Array) -> dict[str, float]:
        """A target by name, of the coordinates of one point of the grid."""
        return {**self.held, **dict(zip(self.names, at.tolist(), strict=True))}

    def of(self, posture: Posture, robot: Mechanism) -> Array:
        """Coordinates of the grid at a posture, shape (axes,)."""
        here = self.task.coordinates(pose_of(robot, posture))
        return np.array([here[self.task.names.index(name)] for name in self.names])

    def frames(self, at: Array) -> Array:
        """Place in the model and rotation, row by row, that coordinates (N, axes) ask for, shape (N, 12)."""
        task, at_home = self.task, self.task.axes == "tool"
        values = np.zeros((len(at), 6))
        values[:, :3] = 0.0 if at_home else task.home.position
        for name, value in self.held.items():
            values[:, NAMES.index(name)] = value
        for column, name in enumerate(self.names):
            values[:, NAMES.index(name)] = at[:, column]
        place = values[:, :3] @ task.basis.T + (task.home.position if at_home else 0.0) - self.origin
        turns = values[:, 3:]
        if turns.any():
            rotation = turned_rows(turns @ task.basis.T) @ task.home.rotation
        else:
            rotation = np.broadcast_to(task.home.rotation, (len(at), 3, 3))
        return np.ascontiguousarray(np.concatenate([place, rotation.reshape(len(at), 9)], axis=1))

    def moved(self, frames: Array, nudges: Array) -> Array:
        """Goals `frames` (N, 12), moved along every led coordinate in turn by a little, shape (N, led, 12)."""
        found = np.repeat(frames[:, None], len(nudges), axis=1)
        for k, (row, nudge) in enumerate(zip(self.task.rows, nudges.tolist(), strict=True)):
            along = self.task.basis[:, row % 3]
            if row < 3:
                found[:, k, :3] += nudge * along
            else:
                # about an axis that is carried by the tool, as the task asks
                since = frames[:, 3:].reshape(-1, 3, 3) @ self.task.home.rotation.T
                turned = since @ turned_rows(nudge * along[None])[0] @ self.task.home.rotation
                found[:, k, 3:] = turned.reshape(-1, 9)
        return found


def pose_of(robot: Mechanism, posture: Posture) -> Pose:
    """Pose of the tool, of a robot whose actuators do not determine its motion too."""
    chain = robot.geometry if isinstance(robot, CompiledChain) else robot
    if isinstance(chain, ClosedChain):
        tool = chain.description.tool
        assert tool is not None
        link = chain.link_placements(posture)[tool.link] @ tool.placement
        return Pose(link[:3, 3], link[:3, :3])
    here = robot.tool(posture)
    return Pose(here.position, here.rotation)


def turned_rows(vectors: Array) -> Array:
    """Rotations (N, 3, 3) of rotation vectors (N, 3), by Rodrigues' formula."""
    angle = np.linalg.norm(vectors, axis=1)[:, None, None]
    cross = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -z, y, -x
    cross -= cross.transpose(0, 2, 1)
    half = 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * cross + half * (cross @ cross))


def chosen_axes(task: Task, axes: tuple[str, ...] | None, held: Mapping[str, float]) -> tuple[str, ...]:
    """The coordinates that a grid is over: those asked for, else the places that are led and not held, else the turns.

    Raises:
        UnknownNameError: one is no coordinate of the task.
        InputError: none or more than three, one is given twice, or it is held and asked for.
    """
    for name in (*(axes or ()), *held):
        if name not in task.names:
            raise UnknownNameError(f"coordinate of {task.robot}, whose task is {task},", name, list(task.names))
    if axes is None:
        free = [name for name in task.names if name not in held]
        places = [name for name in free if NAMES.index(name) < 3]
        axes = tuple(places or free)
    if not 1 <= len(axes) <= 3 or len(set(axes)) < len(axes):
        raise InputError(
            f"a workspace is over 1 to 3 different coordinates of {', '.join(task.names)}, found "
            f"{', '.join(axes) or 'none'}: say which, and hold the others"
        )
    if both := [name for name in axes if name in held]:
        raise InputError(f"{both[0]} cannot be held and vary; leave it out of one of them")
    return axes
