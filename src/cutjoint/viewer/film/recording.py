"""A motion ready to be shown: closed postures of a chain at even times, with the tool, what it should do, and efforts.

It comes from a simulation's result (resampled; postures of a reduced model are closed again by the chain), or from a
trajectory alone, followed exactly, with the efforts of inverse dynamics.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array, readonly
from cutjoint.chain import ClosedChain
from cutjoint.errors import ClosureError, CutjointError, InputError
from cutjoint.mechanism import Posture
from cutjoint.motion import Desired, Reference, Trajectory
from cutjoint.reprs import line
from cutjoint.simulation import Result
from cutjoint.simulation.result import result_of
from cutjoint.viewer.film.curves import CurveGroup, groups_of

FRAMES_PER_SECOND = 30.0
FRAMES = 1500
FEWEST = 30
EXACT = ("effort", "tool", "joints", "velocity", "power", "passive")
"""Curves of a motion that is followed exactly."""
SAME = 1e-6
"""Part of a robot's length that its tool may be away from where a result has it."""


@dataclass(frozen=True, eq=False)
class Recording:
    """k frames of a robot with n actuators.

    Attributes:
        time: from 0, evenly spaced, shape (k,), [s].
        postures: of the chain, k of them.
        tool, desired: tool positions, shape (k, 3), [m]; `desired` is None where nothing was asked for.
        effort: of the actuators, shape (k, n), [N] or [N m].
        about: lines that say how it was made.
        curves: what can be shown beside the robot.
    """

    time: Array
    postures: tuple[Posture, ...]
    tool: Array
    desired: Array | None
    effort: Array
    about: tuple[str, ...] = ()
    curves: tuple[CurveGroup, ...] = ()

    __repr__ = line("about", "time", "tool", time="s", tool="m")

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

    Configurations of the same chain are shown as they are recorded; those of a reduced model are closed by the chain.

    Raises:
        InputError: the result is of another robot.
        ClosureError: a posture of it cannot be closed by `chain`.
    """
    _check_actuators(chain, result)
    time = frame_times(float(result.time[-1] - result.time[0]))
    at = time + result.time[0]
    own = result.q_full.shape[1] == chain.nq
    postures = _recorded(chain, result, at) if own else _closed(chain, _resampled(at, result.time, result.q))
    _check_tool(chain, result, postures)
    about = [f"{key}: {_shown(value)}" for key, value in result.about.items() if isinstance(value, str | int | float)]
    return Recording(
        readonly(time),
        postures,
        _resampled(at, result.time, result.tool),
        _resampled(at, result.time, result.desired_tool) if result.followed else None,
        _resampled(at, result.time, result.effort),
        tuple(about),
        groups_of(replace(result, about={**result.about, "actuators": _actuators(chain)}), chain if own else None),
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
    effort = readonly([chain.inverse_dynamics(one.posture, one.v, one.a) for one in desired])
    tool = readonly([chain.tool(one.posture).position for one in desired])
    return Recording(
        readonly(time),
        tuple(one.posture for one in desired),
        tool,
        None,
        effort,
        (f"robot: {chain.name}", f"trajectory: {trajectory.name}, followed exactly", "effort: inverse dynamics"),
        _curves_of_exact(chain, time, desired, tool, effort),
    )


def _curves_of_exact(
    chain: ClosedChain, time: Array, desired: list[Desired], tool: Array, effort: Array
) -> tuple[CurveGroup, ...]:
    """What there is to see of a motion that is followed exactly: a run without errors and energies."""
    q, v = np.array([one.posture.q for one in desired]), np.array([one.v for one in desired])
    nothing = np.zeros(len(time))
    columns = {
        "time": time,
        "q": q,
        "v": v,
        "tool": tool,
        "tool_velocity": np.zeros_like(tool),
        "effort": effort,
        "gap": np.zeros((len(time), 2)),
        "kinetic": nothing,
        "potential": nothing,
        "work": nothing,
        "q_full": np.array([one.posture.q_full for one in desired]),
    }
    run = result_of({name: readonly(column) for name, column in columns.items()}, {"actuators": _actuators(chain)})
    return groups_of(run, chain, EXACT)


def _shown(value: str | float) -> str:
    """A value of a run's settings in few digits."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _actuators(chain: ClosedChain) -> list[list[str]]:
    """Names and kinds of the actuators, as a result tells them."""
    return [[one.name, one.kind] for one in chain.actuators]


def still(chain: ClosedChain, at: Posture) -> Recording:
    """One posture."""
    n = chain.n
    return Recording(readonly([0.0]), (at,), readonly(np.zeros((1, 3))), None, readonly(np.zeros((1, n))))


def frame_times(duration: float) -> Array:
    """Even times from 0 to `duration` [s], at 30 a second; at least FEWEST, as a short motion is played slowly, and at
    most FRAMES."""
    count = int(np.clip(np.ceil(duration * FRAMES_PER_SECOND), FEWEST, FRAMES))
    return np.linspace(0.0, duration, count + 1)


def _check_actuators(chain: ClosedChain, result: Result) -> None:
    """That the actuators of a result are those of `chain`, as far as the result tells.

    Raises:
        InputError: they are not.
    """
    own = _actuators(chain)
    made_with = result.about.get("actuators", own)
    if result.q.shape[1] != chain.n or list(map(list, made_with)) != own:
        named = f" ({', '.join(name for name, _ in made_with)})" if made_with != own else ""
        raise InputError(
            f"the result has {result.q.shape[1]} actuators{named}; {chain.name} has {len(own)} "
            f"({', '.join(name for name, _ in own)}); give the robot it was made with"
        )


def _check_tool(chain: ClosedChain, result: Result, postures: tuple[Posture, ...]) -> None:
    """That the tool of `chain` is where the tool of the run was, at its start and its end, which are samples.

    Raises:
        InputError: it is not, so the result is of a robot with other lengths, or of another branch.
    """
    tool = chain.description.tool
    if tool is None:
        return
    for row in (0, -1):
        place = (chain.link_placements(postures[row])[tool.link] @ np.asarray(tool.placement))[:3, 3]
        away = float(np.linalg.norm(place - result.tool[row]))
        if away > SAME * (chain.length + float(np.abs(result.tool[row]).max())) + float(result.gap[row, 0]):
            raise InputError(
                f"the tool of {chain.name} would be {away:.3g} m away from where the result has it at "
                f"{result.time[row]:.6g} s; give the robot it was made with"
            )


def _recorded(chain: ClosedChain, result: Result, at: Array) -> tuple[Posture, ...]:
    """The configurations of a run at some times.

    Raises:
        InputError: they are none of `chain`.
    """
    after = np.clip(np.searchsorted(result.time, at), 1, max(len(result) - 1, 1))
    found = []
    for t, k in zip(at, after, strict=True):
        i, j = k - 1, min(k, len(result) - 1)
        span = result.time[j] - result.time[i]
        part = min(max(float((t - result.time[i]) / span), 0.0), 1.0) if span > 0.0 else 0.0
        try:
            found.append(_between(chain, result.q_full[i], result.q_full[j], part))
        except (InputError, ClosureError) as error:
            raise InputError(
                f"the configurations of the result are none of {chain.name} ({error}); give the robot it was made with"
            ) from error
    return tuple(found)


def _between(chain: ClosedChain, q: Array, later: Array, part: float) -> Posture:
    """A posture between two samples, closed; the nearer of the two where that fails, as at a singularity.

    Raises:
        InputError, ClosureError: the samples are none of `chain`.
    """
    if 0.0 < part < 1.0:
        try:
            closed, _ = chain.project(pin.interpolate(chain.model, q, later, part), np.zeros(chain.nv))
            return chain.posture(closed)
        except CutjointError:
            pass
    return chain.posture(q if part < 0.5 else later)


def _closed(chain: ClosedChain, actuated: Array) -> tuple[Posture, ...]:
    """Postures with actuated coordinates (k, n) one after the other, from home on."""
    found, near = [], chain.home
    for q in actuated:
        near = chain.close(q, near, limits="ignore")
        found.append(near)
    return tuple(found)


def _resampled(at: Array, time: Array, values: Array) -> Array:
    return readonly(np.column_stack([np.interp(at, time, column) for column in values.T]))
