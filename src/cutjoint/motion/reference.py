"""A trajectory seen through a mechanism: what the actuators must do to follow it, along its whole way.

How one instant is followed is told in `following`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import isfinite
from threading import Lock

import numpy as np

from cutjoint.arrays import Array, Frozen, positive, readonly
from cutjoint.doors import door, of_type
from cutjoint.errors import ClosureError, CutjointError, InputError, LimitError, SingularError, UnreachableError
from cutjoint.mechanism import JointLimits, Mechanism, Posture
from cutjoint.motion.following import Demand, follower
from cutjoint.motion.values import ROTATION, ToolMotion, Trajectory
from cutjoint.reprs import line

# Anchors to a way, and to a second of it: near enough that kinematics from the nearest one stays on its branch.
ANCHORS, ANCHORS_PER_SECOND, MOST_ANCHORS = 64, 20, 4096
# Instants that are remembered: a few seconds of RK4 at 1 kHz, some ten megabytes.
MEMORY = 10000


@dataclass(frozen=True, eq=False)
class Desired(Frozen):
    """The desired motion at one instant.

    Attributes:
        t: time [s].
        q, v, a: actuated coordinates, velocity and acceleration, shape (n,).
        tool: motion of the tool, its rotation included: what is prescribed, and the rest as the posture gives it.
        posture: the posture at `q`, made by `mechanism`.
        mechanism: through which the trajectory was seen.
    """

    t: float
    q: Array
    v: Array
    a: Array
    tool: ToolMotion
    posture: Posture
    mechanism: Mechanism

    __repr__ = line("t", "q", "v", "a", "tool", "mechanism", t="s", q="m or rad", v="m/s or rad/s", a="m/s2 or rad/s2")

    def posture_of(self, model: Mechanism) -> Posture:
        """The desired posture as `model` makes it: its own where it made it, else closed at the same `q`.

        Raises:
            ClosureError, SingularError: `model` cannot be closed there.
            InputError: it is no model.
        """
        if not hasattr(model, "close"):
            of_type("model", model, Mechanism)
        return self.posture if model is self.mechanism else model.close(self.q, limits="ignore")


@door
class Reference:
    """The motion of the actuators of `mechanism` that follows `trajectory` for `duration` [s] from time 0 on.

    The whole way is walked once when it is made, so that a trajectory that leaves the workspace, goes beyond a joint's
    limits or asks for what the robot does not lead is found before anything moves; the postures on the way are kept and
    start the kinematics later on.

    Attributes:
        trajectory: the motion of the tool or of the actuators.
        mechanism: whose kinematics are used.
        duration: how long it is followed [s].
        limits: whether joint limits are respected or ignored.
    """

    __repr__ = line("trajectory", "mechanism", "duration", duration="s")

    def __init__(
        self,
        trajectory: Trajectory,
        mechanism: Mechanism,
        duration: float | None = None,
        *,
        limits: JointLimits = "respect",
    ) -> None:
        """Walk the way.

        Raises:
            InputError: a duration that is not > 0, a trajectory that gives no motion or that of another robot, a robot
                whose task cannot be told.
            UnreachableError: the trajectory leaves the workspace, or prescribes what is not led; it tells when.
            LimitError: it goes beyond the limits of a joint, and they are not to be ignored.
        """
        self.trajectory, self.mechanism, self.limits = trajectory, mechanism, limits
        self.duration = positive("duration", trajectory.duration if duration is None else duration, "s")
        self._known: dict[float, Desired] = {}
        self._writing = Lock()
        with self._telling(0.0):
            self._follower = follower(trajectory, mechanism, limits)
        # A way that repeats, or rests at its end, is walked once.
        end = min(self.duration, trajectory.duration)
        count = int(np.clip(np.ceil(end * ANCHORS_PER_SECOND), ANCHORS, MOST_ANCHORS))
        places, postures, missed = [], [], _Missed()
        near: Posture | None = None
        for t in np.linspace(0.0, end, count + 1).tolist():
            demand = self._follower.at(t)
            near = self._posture(t, demand, near)
            self._desired(t, demand, near)
            missed.see(t, demand.missed(near))
            places.append(demand.place)
            postures.append(near)
        missed.tell(trajectory, mechanism)
        self._places, self._postures = readonly(places), tuple(postures)

    def __getstate__(self) -> dict[str, object]:
        # The memo stays behind: it is large, and another thread may be writing into it.
        state = {**self.__dict__, "_known": {}}
        del state["_writing"]
        return state

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state, _writing=Lock())
        self._places.setflags(write=False)

    def at(self, t: float) -> Desired:
        """The desired motion at time `t` [s], which may lie past the duration.

        Raises:
            UnreachableError, LimitError: outside the workspace or the limits between two anchors, or past the duration.
        """
        try:
            known = self._known.get(t)
        except TypeError:
            known = None  # what cannot be looked up is no time
        if known is not None:
            return known
        of_type("t", t, float)
        if not isfinite(t):
            raise InputError(f"t must be a finite time [s], found {t!r}")
        demand = self._follower.at(t)
        away = self._places - demand.place
        nearest = self._postures[int(np.argmin(np.einsum("ij,ij->i", away, away)))]
        made = self._desired(t, demand, self._posture(t, demand, nearest))
        # A memo of a pure function: stages of a method and runs on one time grid ask for the same instants again.
        with self._writing:
            self._known[t] = made
            if len(self._known) > MEMORY:
                del self._known[next(iter(self._known))]
        return made

    def _posture(self, t: float, demand: Demand, near: Posture | None) -> Posture:
        with self._telling(t):
            return demand.posture(near)

    def _desired(self, t: float, demand: Demand, posture: Posture) -> Desired:
        with self._telling(t):
            v, a, tool = demand.rates(posture)
        return Desired(t, posture.q, v, a, tool, posture, self.mechanism)

    @contextmanager
    def _telling(self, t: float) -> Iterator[None]:
        """Says when and where it was that the robot could not follow."""
        try:
            yield
        except (UnreachableError, SingularError, ClosureError) as error:
            raise _cannot_follow(self.trajectory, self.mechanism, t, t / self.duration, error) from error


class _Missed:
    """The most by which coordinates are missed on a way, and when."""

    def __init__(self) -> None:
        self._most: dict[str, tuple[float, float]] = {}

    def see(self, t: float, missed: dict[str, float]) -> None:
        """What is missed at `t` [s]."""
        for name, size in missed.items():
            if size > self._most.get(name, (0.0, 0.0))[0]:
                self._most[name] = size, t

    def tell(self, trajectory: Trajectory, mechanism: Mechanism) -> None:
        """Raises UnreachableError where something was missed."""
        if not self._most:
            return
        parts = [
            f"{name} by {np.degrees(size):.4g} deg at t = {t:.4g} s"
            if name in ROTATION
            else f"{name} by {size:.4g} m at t = {t:.4g} s"
            for name, (size, t) in self._most.items()
        ]
        raise UnreachableError(
            f"trajectory '{trajectory.name}' cannot be followed by {mechanism.name}, which leads {mechanism.task}: it "
            f"would miss {', '.join(parts)}. Leave that as it is at home, or prescribe only what the robot leads",
            target=np.zeros(3),
        )


def _cannot_follow(
    trajectory: Trajectory, mechanism: Mechanism, t: float, part: float, error: CutjointError
) -> UnreachableError:
    motion = trajectory.at(t)
    if isinstance(motion, ToolMotion):
        target, where = motion.position, "tool at (" + ", ".join(f"{x:.4g}" for x in motion.position) + ") m"
    else:
        target, where = motion.q, "actuators at (" + ", ".join(f"{x:.4g}" for x in motion.q) + ")"
    if isinstance(error, LimitError):
        return LimitError(
            f"trajectory '{trajectory.name}' goes beyond the joint limits of {mechanism.name} at t = {t:.4g} s, "
            f"{where}: {error}. Make it smaller or move it",
            joint=error.joint,
            value=error.value,
            bounds=error.bounds,
            target=target,
            progress=part,
        )
    return UnreachableError(
        f"trajectory '{trajectory.name}' leaves the workspace of {mechanism.name} at t = {t:.4g} s, "
        f"{where}: {error}. Make it smaller or move it",
        target=target,
        reached=getattr(error, "reached", None),
        progress=part,
    )
