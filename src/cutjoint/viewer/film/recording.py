"""A motion ready to be shown: closed postures of a chain at even times, with the tool, what it should do, and efforts.

It comes from a simulation's result (resampled; postures of a reduced model are closed again by the chain), or from a
trajectory alone, followed exactly, with the efforts of inverse dynamics.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError
from cutjoint.mechanism import Posture
from cutjoint.motion import Reference, Trajectory
from cutjoint.simulation import Result

FRAMES_PER_SECOND = 30.0
FRAMES = 1500


@dataclass(frozen=True, eq=False)
class Recording:
    """k frames of a robot with n actuators.

    Attributes:
        time: from 0, evenly spaced, shape (k,), [s].
        postures: of the chain, k of them.
        tool, desired: tool positions, shape (k, 3), [m]; `desired` is None where nothing was asked for.
        effort: of the actuators, shape (k, n), [N] or [N m].
        about: lines that say how it was made.
    """

    time: Array
    postures: tuple[Posture, ...]
    tool: Array
    desired: Array | None
    effort: Array
    about: tuple[str, ...] = ()

    @property
    def duration(self) -> float:
        """[s]."""
        return float(self.time[-1])

    @property
    def frames_per_second(self) -> float:
        """Frames per second of the recording."""
        return (len(self.time) - 1) / self.duration if self.duration > 0 else 1.0


def from_result(chain: ClosedChain, result: Result) -> Recording:
    """A simulation, shown by `chain`.

    Raises:
        InputError: the result is of a robot with another number of actuators.
        ClosureError: a posture of it cannot be closed by `chain` (another robot's result).
    """
    if result.q.shape[1] != chain.n:
        raise InputError(
            f"the result has {result.q.shape[1]} actuators, {chain.name} has {chain.n}; give the robot it was made with"
        )
    time = frame_times(float(result.time[-1] - result.time[0]))
    at = time + result.time[0]
    full = result.q_full.shape[1] == chain.nq
    postures: list[Posture] = []
    near = chain.posture(result.q_full[0]) if full else chain.home
    for q in _resampled(at, result.time, result.q):
        near = chain.close(q, near, limits="ignore")
        postures.append(near)
    about = [f"{key}: {value}" for key, value in result.about.items() if isinstance(value, str | int | float)]
    return Recording(
        readonly(time),
        tuple(postures),
        _resampled(at, result.time, result.tool),
        _resampled(at, result.time, result.desired_tool) if result.followed else None,
        _resampled(at, result.time, result.effort),
        tuple(about),
    )


def from_trajectory(chain: ClosedChain, trajectory: Trajectory, duration: float | None = None) -> Recording:
    """A trajectory followed exactly by `chain`, with the efforts that inverse dynamics gives.

    Raises:
        UnreachableError: the trajectory leaves the workspace.
        ActuationError: the actuators of `chain` do not determine its motion.
    """
    reference = Reference(trajectory, chain, duration)
    time = frame_times(reference.duration)
    desired = [reference.at(float(t)) for t in time]
    effort = [chain.inverse_dynamics(one.posture, one.v, one.a) for one in desired]
    return Recording(
        readonly(time),
        tuple(one.posture for one in desired),
        readonly([chain.tool(one.posture).position for one in desired]),
        None,
        readonly(effort),
        (f"robot: {chain.name}", f"trajectory: {trajectory.name}, followed exactly", "effort: inverse dynamics"),
    )


def still(chain: ClosedChain, at: Posture) -> Recording:
    """One posture."""
    n = chain.n
    return Recording(readonly([0.0]), (at,), readonly(np.zeros((1, 3))), None, readonly(np.zeros((1, n))))


def frame_times(duration: float) -> Array:
    """Even times from 0 to `duration` [s], at 30 a second or fewer where that would be more than FRAMES."""
    count = int(np.clip(np.ceil(duration * FRAMES_PER_SECOND), 1, FRAMES))
    return np.linspace(0.0, duration, count + 1)


def _resampled(at: Array, time: Array, values: Array) -> Array:
    return readonly(np.column_stack([np.interp(at, time, column) for column in values.T]))
