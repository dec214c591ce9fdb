"""One move from rest to rest with bounded speed, acceleration and jerk, by ruckig, as switches of the jerk."""

from __future__ import annotations

from types import ModuleType

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import InputError
from cutjoint.retiming.limits import MotionLimits

APART = 1e-5
"""Switches that are nearer than this part of the move are one: a spline between them would lose its digits."""
NOWHERE = 1e-9
"""A distance that is none, beside the coordinates or 1 [m] or [rad]."""


def quickest_move(ruckig: ModuleType, start: Array, end: Array, limits: MotionLimits) -> tuple[Array, Array]:
    """Switches of the jerk of a move [s], shape (k,), and coordinates there, shape (k, n)."""
    n = len(start)
    asked = ruckig.InputParameter(n)
    asked.current_position, asked.target_position = start.tolist(), end.tolist()
    # a speed that nobody reaches on that way where there is no limit
    free = 2.0 * np.sqrt(limits.acceleration * np.maximum(np.abs(end - start), NOWHERE))
    asked.max_velocity = np.minimum(limits.speed, free).tolist()
    asked.max_acceleration, asked.max_jerk = limits.acceleration.tolist(), limits.jerk.tolist()
    asked.synchronization = ruckig.Synchronization.Phase
    found = ruckig.Trajectory(n)
    result = ruckig.Ruckig(n).calculate(asked, found)
    if result not in (ruckig.Result.Working, ruckig.Result.Finished):
        raise InputError(f"no move from {start.tolist()} to {end.tolist()}: ruckig tells {result.name}")
    whole = float(found.duration)
    switches = np.unique(np.concatenate([[0.0], *(np.cumsum(one.t) for one in found.profiles[0])]))
    inner = switches[(switches > APART * whole) & (switches < (1.0 - APART) * whole)]
    times = [0.0]
    for one in inner.tolist():
        if one - times[-1] > APART * whole:
            times.append(one)
    times.append(whole)
    rows = np.array([found.at_time(one)[0] for one in times])
    rows[0], rows[-1] = start, end
    return np.array(times), rows
