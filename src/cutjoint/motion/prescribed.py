"""What a trajectory prescribes at an instant, checked: the kind of motion, its shapes, finite numbers, a rotation."""

from __future__ import annotations

from math import isfinite

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import InputError
from cutjoint.motion.values import JointMotion, ToolMotion, Trajectory

ORTHOGONAL = 1e-9
"""By how much a rotation may miss being orthogonal."""


def joint_motion(trajectory: Trajectory, t: float, n: int) -> JointMotion:
    """The motion of n actuators at `t` [s].

    Raises:
        InputError: it is another kind of motion, of another number of actuators, or not finite.
    """
    motion = trajectory.at(t)
    if not isinstance(motion, JointMotion):
        raise _no_motion(trajectory, t, motion, "a JointMotion, as at the start")
    _check(trajectory, t, (n,), q=motion.q, v=motion.v, a=motion.a)
    return motion


def tool_motion(trajectory: Trajectory, t: float) -> ToolMotion:
    """The motion of the tool at `t` [s].

    Raises:
        InputError: it is another kind of motion, not finite, or its rotation is none.
    """
    motion = trajectory.at(t)
    if not isinstance(motion, ToolMotion):
        raise _no_motion(trajectory, t, motion, "a ToolMotion (or at all times a JointMotion)")
    _check(trajectory, t, (3,), position=motion.position, velocity=motion.velocity, acceleration=motion.acceleration)
    if motion.rotation is not None:
        assert motion.angular_velocity is not None
        assert motion.angular_acceleration is not None
        turning, change = motion.angular_velocity, motion.angular_acceleration
        _check(trajectory, t, (3,), angular_velocity=turning, angular_acceleration=change)
        _check(trajectory, t, (3, 3), rotation=motion.rotation)
        off = float(np.abs(motion.rotation @ motion.rotation.T - np.eye(3)).max())
        if off > ORTHOGONAL or np.linalg.det(motion.rotation) < 0.0:
            found = motion.rotation.tolist()
            raise InputError(f"trajectory '{trajectory.name}' gives a rotation at t = {t:.4g} s that is none: {found}")
    return motion


def _no_motion(trajectory: Trajectory, t: float, found: object, wanted: str) -> InputError:
    return InputError(
        f"trajectory '{trajectory.name}' must give {wanted} at t = {t:.4g} s, found {type(found).__name__}"
    )


def _check(trajectory: Trajectory, t: float, shape: tuple[int, ...], **parts: Array) -> None:
    for name, array in parts.items():
        if array.shape == shape and isfinite(array.ravel().dot(array.ravel())):  # the quick way through
            continue
        where = f"trajectory '{trajectory.name}' gives {name}"
        if array.shape != shape:
            raise InputError(f"{where} of shape {array.shape} at t = {t:.4g} s; it must have shape {shape}")
        if not np.isfinite(array).all():
            raise InputError(f"{where} {array.tolist()} at t = {t:.4g} s; it must be finite")
