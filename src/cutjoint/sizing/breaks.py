"""Where a motion is not smooth: jumps of its acceleration, its knots, and where it begins and ends to move.

Jumps are found by looking: between two instants where the acceleration changes much more than beside them, the larger
half of the change is followed down to rounding.  What is continuous leaves nothing to follow.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.motion import JointMotion, Trajectory

LOOKS, MOST_LOOKS = 1024, 16384
"""Instants that are looked at in the time of a trajectory, and at most."""
SUDDEN = 6.0
"""How many times as much as beside it the acceleration changes where it may jump."""
SMALL = 1e-9
"""Part of the largest acceleration that is none."""
HALVINGS = 60
MOST_JUMPS = 500
MOST_KNOTS = 300
"""Of a spline, up to which every knot ends a piece; of more, pieces go over them."""


def breaks_of(trajectory: Trajectory, duration: float) -> Array:
    """Instants inside (0, duration) at which the motion may not be smooth, ascending [s]."""
    repeats = max(1, int(np.ceil(duration / trajectory.duration - 1e-9)))
    found = [*_jumps(trajectory, duration, repeats), *_knots(trajectory, repeats)]
    inside = sorted(t for t in found if 1e-9 * duration < t < duration * (1.0 - 1e-9))
    kept: list[float] = []
    for t in inside:
        if not kept or t - kept[-1] > 1e-9 * duration:
            kept.append(t)
    return np.array(kept)


def is_fine(trajectory: Trajectory) -> bool:
    """Whether it is a spline of so many knots that pieces go over them."""
    return len(_times(trajectory)) > MOST_KNOTS


def _times(trajectory: Trajectory) -> Array:
    times = getattr(trajectory, "times", None)
    return times if isinstance(times, np.ndarray) else np.zeros(0)


def acceleration(trajectory: Trajectory, t: float) -> Array:
    """All accelerations that a trajectory prescribes at an instant."""
    motion = trajectory.at(t)
    if isinstance(motion, JointMotion):
        return motion.a
    turning = motion.angular_acceleration
    return motion.acceleration if turning is None else np.concatenate([motion.acceleration, turning])


def _jumps(trajectory: Trajectory, duration: float, repeats: int) -> list[float]:
    count = int(min(LOOKS * repeats, MOST_LOOKS))
    times = np.linspace(0.0, duration, count + 1)
    seen = np.array([acceleration(trajectory, float(t)) for t in times])
    least = SMALL * float(np.abs(seen).max(initial=0.0))
    change = np.abs(np.diff(seen, axis=0)).max(axis=1)
    beside = np.maximum(np.append(change[1:], 0.0), np.insert(change[:-1], 0, 0.0))
    moving = np.abs(seen).max(axis=1) > least
    found = [float(times[k]) for k in np.flatnonzero(moving[1:] != moving[:-1])]
    for k in np.flatnonzero((change > SUDDEN * beside) & (change > least))[:MOST_JUMPS]:
        at = _followed(trajectory, float(times[k]), float(times[k + 1]), 0.3 * float(change[k]))
        found += [] if at is None else [at]
    return found


def _followed(trajectory: Trajectory, low: float, high: float, least: float) -> float | None:
    """Where between two instants the acceleration jumps, if it does."""
    at_low, at_high = acceleration(trajectory, low), acceleration(trajectory, high)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        here = acceleration(trajectory, middle)
        left, right = float(np.abs(here - at_low).max()), float(np.abs(at_high - here).max())
        if max(left, right) < least:
            return None
        if left > right:
            high, at_high = middle, here
        else:
            low, at_low = middle, here
    return high


def _knots(trajectory: Trajectory, repeats: int) -> list[float]:
    """Knots of splines, ends of blends at corners, and ends of ways that repeat."""
    own = [0.0, trajectory.duration]
    if not is_fine(trajectory):
        own += _times(trajectory).tolist()
    corners = getattr(trajectory, "corners", None)
    blend, seconds = getattr(corners, "blend", None), getattr(corners, "seconds", None)
    if isinstance(blend, float) and isinstance(seconds, np.ndarray):
        at = blend + np.concatenate([[0.0], np.cumsum(seconds)])
        own += [*(at - blend).tolist(), *(at + blend).tolist()]
    ramp = getattr(trajectory, "ramp", None)
    if isinstance(ramp, float):
        own += [ramp * trajectory.duration, (1.0 - ramp) * trajectory.duration]
    return [again * trajectory.duration + t for again in range(repeats) for t in own]
