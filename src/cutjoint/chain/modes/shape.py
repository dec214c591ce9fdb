"""What tells one posture from another: where its links are, but for motions that mean nothing.

Coordinates do not tell: a quaternion and its negative are one orientation, and a joint may be turned by whole turns.
So postures are compared by the placement of every link, its position in characteristic lengths and its rotation matrix.

An idle motion (a rod that spins between two balls) takes a posture through others that are the same to anyone who uses
the robot.  Of a link with such motions only those points count that none of them moves: a line, a point, or nothing.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.joints import support
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.rank import null_space
from cutjoint.chain.structure import scaled_tool

SIZE = 12
"""Numbers per link: a position and a rotation matrix, or a point and a direction, or a point."""

STILL = 1e-7
"""A point of a link that moves less than this per unit of an idle motion stays where it is."""


class Shapes:
    """Compares the postures of one robot.

    Args:
        actuated: velocity indices of the actuated joints.
        hub: 1 for every velocity that moves the tool, shape (nv,).  Idle motions leave the tool where it is; without
            one they leave every connection between links.
        q: a closed configuration, shape (nq,), that tells whether there are idle motions at all.
    """

    def __init__(self, kinematics: Kinematics, actuated: Array, hub: Array | None, q: Array) -> None:
        self._k, self._hub = kinematics, hub
        model = kinematics.model
        self._locked = np.eye(model.nv)[actuated]
        self._supports = np.array([support(model, joint) for joint in range(model.njoints)])
        self._points = _connections(kinematics)
        self.idle_motions = self.idle(kinematics.at(q)).shape[1]

    def idle(self, placed: Placed) -> Array:
        """Orthonormal basis of the idle motions at a configuration, dimensionless, shape (nv, k)."""
        return null_space(np.concatenate([placed.scaled, self._locked, self._kept(placed)]))

    def links(self, q: Array) -> Array:
        """The shape of every link at `q` (nq,), shape (joints, 12)."""
        k = self._k
        length, placed = k.length, k.at(q)
        axes, at = k.tree.bodies(q)
        shapes = np.zeros((k.model.njoints - 1, SIZE))
        idle = self.idle(placed) * k.column_scale[:, None] if self.idle_motions else np.zeros((k.model.nv, 0))
        for joint in range(1, k.model.njoints):
            spins = placed.twists @ (self._supports[joint][:, None] * idle)
            if np.abs(spins).max(initial=0.0) < STILL * max(1.0, length):
                shapes[joint - 1, :3] = at[joint] / length
                shapes[joint - 1, 3:] = axes[joint].ravel()
            else:
                shapes[joint - 1] = _unmoved(spins, at[joint], axes[joint], length)
        return shapes

    def hub_pose(self, placed: Placed) -> Array:
        """The shape of the tool at a configuration, shape (12,); empty without a tool."""
        if self._hub is None:
            return np.zeros(0)
        pose = placed.tool
        return np.concatenate([pose.translation / self._k.length, pose.rotation.ravel()])

    def _kept(self, placed: Placed) -> Array:
        """Dimensionless rows that idle motions leave alone, shape (rows, nv)."""
        k = self._k
        if self._hub is not None:
            return scaled_tool(k, placed)
        axes, at = k.tree.bodies(placed.q)
        rows = [np.zeros((0, k.model.nv))]
        for joint, points in enumerate(self._points[1:], start=1):
            moving = placed.twists * self._supports[joint] * k.column_scale
            if len(points) < 2:
                rows.append(moving[3:])
            for point in points:
                there = at[joint] + axes[joint] @ point
                rows.append((moving[:3] + np.cross(moving[3:], there, axisa=0, axisc=0)) / k.length)
        return np.concatenate(rows)


def _connections(kinematics: Kinematics) -> list[list[Array]]:
    """Per joint, where its link is joined to others, in the joint's own frame."""
    model = kinematics.model
    points = [[np.zeros(3)] for _ in range(model.njoints)]
    for joint in range(1, model.njoints):
        points[model.parents[joint]].append(np.array(model.jointPlacements[joint].translation))
    for cut in kinematics.closure.cuts:
        points[cut.joint_a].append(np.array(cut.placement_a.translation))
        points[cut.joint_b].append(np.array(cut.placement_b.translation))
    return points


def _unmoved(spins: Array, at: Array, rotation: Array, length: float) -> Array:
    """What the twists `spins` (6, k), about the world's origin, leave of a link's placement, shape (12,)."""
    shape = np.zeros(SIZE)
    matrix = np.concatenate([np.cross(np.eye(3), -w).T for w in spins[3:].T])
    wanted = -np.concatenate([v + np.cross(w, at) for v, w in spins.T.reshape(-1, 2, 3)])
    left, values, right = np.linalg.svd(matrix)
    size = float(np.linalg.norm(spins[3:]))
    rank = int(np.sum(values > STILL * max(size, 1e-300)))
    offset = right[:rank].T @ ((left[:, :rank].T @ wanted) / values[:rank])
    if rank < 2 or np.abs(matrix @ offset - wanted).max() > 1e2 * STILL * max(length, 1.0) * max(size, 1e-300):
        return shape
    shape[:3] = (at + offset) / length
    if rank == 2:
        line = rotation.T @ right[2]
        shape[3:6] = right[2] * np.sign(line[np.argmax(np.abs(line) > 0.1)])
        shape[6] = 1.0
    return shape
