"""Placements: roll, pitch, yaw and position to a (4, 4) homogeneous transform and back.

Roll, pitch and yaw are turns about the fixed x, y and z axes in this order, so R = Rz(yaw) Ry(pitch) Rx(roll), as URDF
and SDF have it.  Like urdfdom, the rotation is made through a unit quaternion, which keeps it the same to rounding.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, readonly


def quaternion_from_rpy(rpy: Sequence[float] | Array) -> Array:
    """Unit quaternion (w, x, y, z) of roll, pitch, yaw [rad]."""
    roll, pitch, yaw = (0.5 * float(angle) for angle in rpy)
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    quaternion: Array = np.array(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ]
    )
    return readonly(quaternion / np.linalg.norm(quaternion))


def rotation_from_quaternion(quaternion: Sequence[float] | Array) -> Array:
    """Rotation (3, 3) of a quaternion (w, x, y, z), which need not have length 1.  It must not be zero."""
    w, x, y, z = np.asarray(quaternion, dtype=float) / np.linalg.norm(quaternion)
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def quaternion_from_rotation(rotation: npt.NDArray[np.float64]) -> Array:
    """Unit quaternion (w, x, y, z) of a rotation (3, 3), from whichever of the four is largest."""
    r = rotation
    squares = [1.0 + r[0, 0] + r[1, 1] + r[2, 2], 1.0 + r[0, 0] - r[1, 1] - r[2, 2]]
    squares += [1.0 - r[0, 0] + r[1, 1] - r[2, 2], 1.0 - r[0, 0] - r[1, 1] + r[2, 2]]
    wx, wy, wz = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    xy, xz, yz = r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1]
    rows = [(squares[0], wx, wy, wz), (wx, squares[1], xy, xz), (wy, xy, squares[2], yz), (wz, xz, yz, squares[3])]
    quaternion = np.array(rows[int(np.argmax(squares))])
    return readonly(quaternion / np.linalg.norm(quaternion))


def rotation_from_rpy(rpy: Sequence[float] | Array) -> Array:
    """Rotation (3, 3) of roll, pitch, yaw [rad]."""
    return rotation_from_quaternion(quaternion_from_rpy(rpy))


def rpy_from_rotation(rotation: npt.NDArray[np.float64]) -> tuple[float, float, float]:
    """Roll, pitch, yaw [rad] of a rotation (3, 3).

    Once yaw is chosen (near a pitch of +-90 degrees it hardly matters), Rz(-yaw) R = Ry(pitch) Rx(roll) gives the
    others from entries that do not vanish there, so that the three together are right to rounding everywhere.
    """
    r = rotation
    yaw = math.atan2(r[1, 0], r[0, 0])
    sine, cosine = math.sin(yaw), math.cos(yaw)
    pitch = math.atan2(-r[2, 0], cosine * r[0, 0] + sine * r[1, 0])
    roll = math.atan2(sine * r[0, 2] - cosine * r[1, 2], cosine * r[1, 1] - sine * r[0, 1])
    return roll, pitch, yaw


def placement(xyz: Sequence[float] | Array = (0.0, 0.0, 0.0), rpy: Sequence[float] | Array = (0.0, 0.0, 0.0)) -> Array:
    """Read-only (4, 4) transform of a position [m] and roll, pitch, yaw [rad]."""
    return from_rotation(rotation_from_rpy(rpy), xyz)


def from_rotation(rotation: npt.ArrayLike, xyz: npt.ArrayLike) -> Array:
    """Read-only (4, 4) transform of a rotation (3, 3) and a position (3,) [m]."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:3, 3] = xyz
    return readonly(matrix)


def turned(transform: npt.NDArray[np.float64], rotation: npt.NDArray[np.float64]) -> Array:
    """A placement (4, 4) whose axes are turned by a rotation (3, 3) about its own origin."""
    return from_rotation(transform[:3, :3] @ rotation, transform[:3, 3])


def inverse(transform: npt.NDArray[np.float64]) -> Array:
    """The inverse of a placement (4, 4)."""
    rotation = transform[:3, :3].T
    return from_rotation(rotation, -rotation @ transform[:3, 3])


def frame_along(axis: npt.ArrayLike) -> Array:
    """A rotation (3, 3) whose z axis is the unit vector `axis`; the identity where that is z already."""
    z = np.asarray(axis, dtype=float)
    z = z / np.linalg.norm(z)
    if z[2] == 1.0:
        return readonly(np.eye(3))
    helper = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(helper, z)
    x /= np.linalg.norm(x)
    return readonly(np.column_stack([x, np.cross(z, x), z]))
