"""What a motion asks of each limit: estimated everywhere from the terms along the way, and found by inverse dynamics of
the finished trajectory, which knows nothing of the way."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.interpolate import CubicSpline

from cutjoint.arrays import Array
from cutjoint.mechanism import NO_LOADS, Loads, Mechanism, Posture
from cutjoint.motion import JointSpline, Reference
from cutjoint.retiming.limits import OF_ACTUATORS, OF_TOOL, MotionLimits
from cutjoint.retiming.terms import WayTerms, has_tool

INSIDE = (0.0, 0.21, 0.5, 0.79)
"""Places between two rows that are looked at."""
TOPS, AROUND = 12, 6
"""Peaks of each quantity that are looked at again, and at how many instants around each."""

Used = Mapping[str, Array]
"""Quantity -> parts of its limits, with signs, shape (k, n) or (k, 1); only quantities that have a limit."""


def spline_of(motion: JointSpline) -> CubicSpline:
    """The same spline, for many instants at once."""
    return CubicSpline(motion.times, motion.q, bc_type="periodic" if motion.closed else "clamped")


def instants_between(times: Array) -> Array:
    """Instants between rows, shape (k,) [s]."""
    steps = np.diff(times)[:, None] * np.array(INSIDE)
    return np.append((times[:-1, None] + steps).ravel(), times[-1])


def estimated(spline: CubicSpline, t: Array, terms: WayTerms, units: Array, limits: MotionLimits) -> Used:
    """Parts of the limits at instants of a piece of the way, whose terms are those at the same instants."""
    v, a = spline(t, 1), spline(t, 2)
    rates, speeds = terms.rates / units, v / units
    along = np.sum(rates * speeds, axis=1, keepdims=True) / np.sum(rates * rates, axis=1, keepdims=True)
    effort = np.einsum("kij,kj->ki", terms.mass, a) + terms.coriolis * along**2 + terms.holding
    effort = effort + terms.dry + terms.damping * along
    curved = terms.bends * along**2
    back = np.sum(rates * (a - curved) / units, axis=1, keepdims=True) / np.sum(rates * rates, axis=1, keepdims=True)
    tool = terms.tool_rates * along, terms.tool_rates * back + terms.tool_bends * along**2
    return _parts(limits, v, a, spline(t, 3), effort, *tool)


def found(
    reference: Reference, robot: Mechanism, spline: CubicSpline, t: Array, limits: MotionLimits, loads: Loads = NO_LOADS
) -> Used:
    """Parts of the limits at instants, by inverse dynamics."""
    desired = [reference.at(one) for one in t.tolist()]
    motion = np.array([one.v for one in desired]), np.array([one.a for one in desired]), spline(t, 3)
    return asked(robot, [one.posture for one in desired], motion, limits=limits, loads=loads)


def asked(
    robot: Mechanism,
    postures: Sequence[Posture],
    motion: tuple[Array, Array, Array],
    *,
    limits: MotionLimits,
    loads: Loads = NO_LOADS,
) -> Used:
    """Parts of the limits in postures with velocities, accelerations and jerks, shape (k, n) each."""
    v, a, jerk = motion
    efforts, tools = [], []
    with_tool = any(np.isfinite(limits.of(one)).any() for one in OF_TOOL) and has_tool(robot)
    for i, posture in enumerate(postures):
        efforts.append(robot.inverse_dynamics(posture, v[i], a[i], loads))
        tool = np.zeros(6)
        if with_tool:
            here = robot.tool(posture, v[i])
            tool = np.concatenate([here.twist[:3], here.jacobian @ a[i] + here.frame_drift[:3]])
        tools.append(tool)
    turned = np.array(tools)
    return _parts(limits, v, a, jerk, np.array(efforts), turned[:, :3], turned[:, 3:])


def _parts(
    limits: MotionLimits, v: Array, a: Array, jerk: Array, effort: Array, tool_speed: Array, tool_acceleration: Array
) -> Used:
    all_of = dict(zip(OF_ACTUATORS, (v, a, jerk, effort, effort * v), strict=True))
    all_of |= {
        "tool_speed": np.linalg.norm(tool_speed, axis=1, keepdims=True),
        "tool_acceleration": np.linalg.norm(tool_acceleration, axis=1, keepdims=True),
    }
    return {one: value / limits.of(one) for one, value in all_of.items() if np.isfinite(limits.of(one)).any()}


def worst_of(used: Used) -> float:
    """The largest part of any limit."""
    return max(float(np.abs(one).max()) for one in used.values())


def instants_to_check(used: Used, t: Array, duration: float, count: int) -> Array:
    """Instants that are none of the rows: `count` spread over the motion, and around the highest peaks, ascending."""
    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    spread = (np.arange(count) + golden) / count * duration
    near = [spread, [0.0, duration]]
    for parts in used.values():
        for column in np.abs(parts).T:
            inner = np.flatnonzero((column[1:-1] >= column[:-2]) & (column[1:-1] >= column[2:])) + 1
            tops = inner[np.argsort(column[inner])[-TOPS:]]
            for k in tops.tolist():
                near.append(np.linspace(t[k - 1], t[k + 1], AROUND + 2)[1:-1])
    return np.unique(np.clip(np.concatenate([np.asarray(one) for one in near]), 0.0, duration))


def stretch_that_keeps(parts_at: Callable[[float], float], allowed: float) -> float:
    """The least factor >= 1 on all times with which the largest part of a limit is at most `allowed`, to 1e-5."""
    low, high = 1.0, 1.0
    while parts_at(high) > allowed:
        low, high = high, 1.0 + 2.0 * max(high - 1.0, 1e-4)
        if high > 1e6:
            return np.inf
    while high - low > 1e-5 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if parts_at(middle) <= allowed else (middle, high)
    return high
