"""A trajectory seen through a mechanism: what the actuators must do so that the tool follows it.

Positions by inverse kinematics; rates from tool velocity = J v and tool acceleration = J a + drift.
"""

from __future__ import annotations

from dataclasses import dataclass
from threading import Lock

import numpy as np

from cutjoint.arrays import Array, Frozen, positive, readonly
from cutjoint.errors import ClosureError, CutjointError, InputError, SingularError, UnreachableError
from cutjoint.mechanism import Mechanism, Posture
from cutjoint.motion.values import ToolMotion, Trajectory

# Anchors to a way: near enough to one another that inverse kinematics from the nearest one stays on its branch.
ANCHORS = 64
# Instants that are remembered: a few seconds of RK4 at 1 kHz, some ten megabytes.
MEMORY = 10000


@dataclass(frozen=True, eq=False)
class Desired(Frozen):
    """The desired motion at one instant.

    Attributes:
        t: time [s].
        q, v, a: actuated coordinates, velocity and acceleration, shape (n,).
        tool: position, velocity and acceleration of the tool.
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

    def posture_of(self, model: Mechanism) -> Posture:
        """The desired posture as `model` makes it: its own where it made it, else closed at the same `q`.

        Raises:
            ClosureError, SingularError: `model` cannot be closed there.
        """
        return self.posture if model is self.mechanism else model.close(self.q)


class Reference:
    """The motion of the actuators of `mechanism` that follows `trajectory` for `duration` [s] from time 0 on.

    The whole way is walked once when it is made, so that a trajectory that leaves the workspace is found before
    anything moves; the postures on the way are kept and start the inverse kinematics later on.

    Attributes:
        trajectory: the motion of the tool.
        mechanism: whose inverse kinematics are used.
        duration: how long it is followed [s].
    """

    def __init__(self, trajectory: Trajectory, mechanism: Mechanism, duration: float | None = None) -> None:
        """Walk the way.

        Raises:
            InputError: a duration that is not > 0, or more than three actuators.
            UnreachableError: the trajectory leaves the workspace; the message tells when and where.
        """
        if mechanism.n > 3:
            raise InputError(
                f"a trajectory of the tool point cannot tell the {mechanism.n} actuators of {mechanism.name} what to "
                "do; three are the most"
            )
        self.trajectory = trajectory
        self.mechanism = mechanism
        self.duration = positive("duration", trajectory.duration if duration is None else duration, "s")
        self._known: dict[float, Desired] = {}
        self._writing = Lock()
        anchors: list[tuple[Array, Posture]] = []
        near: Posture | None = None
        # A way that repeats, or rests at its end, is walked once.
        for t in np.linspace(0.0, min(self.duration, trajectory.duration), ANCHORS + 1):
            tool = trajectory.at(float(t))
            near = self._reach(float(t), tool, near)
            anchors.append((tool.position, near))
        self._places = readonly([place for place, _ in anchors])
        self._postures = tuple(posture for _, posture in anchors)

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
            UnreachableError: outside the workspace between two anchors, or past the duration.
        """
        known = self._known.get(t)
        if known is not None:
            return known
        tool = self.trajectory.at(t)
        away = self._places - tool.position
        nearest = self._postures[int(np.argmin(np.einsum("ij,ij->i", away, away)))]
        posture = self._reach(t, tool, nearest)
        jacobian = self.mechanism.tool(posture).jacobian
        v = _actuator_rates(jacobian, tool.velocity)
        a = _actuator_rates(jacobian, tool.acceleration - self.mechanism.tool(posture, v).drift)
        made = Desired(t, posture.q, v, a, tool, posture, self.mechanism)
        # A memo of a pure function: stages of a method and runs on one time grid ask for the same instants again.
        with self._writing:
            self._known[t] = made
            if len(self._known) > MEMORY:
                del self._known[next(iter(self._known))]
        return made

    def _reach(self, t: float, tool: ToolMotion, near: Posture | None) -> Posture:
        try:
            return self.mechanism.reach(tool.position, near)
        except (UnreachableError, SingularError, ClosureError) as error:
            raise _left_workspace(self.trajectory, self.mechanism, t, tool, error) from error


def _actuator_rates(jacobian: Array, tool: Array) -> Array:
    """The x with jacobian @ x = tool, shape (n,), for one to three actuators."""
    if jacobian.shape == (3, 3):
        return np.asarray(np.linalg.solve(jacobian, tool))
    return np.asarray(np.linalg.lstsq(jacobian, tool, rcond=None)[0])


def _left_workspace(
    trajectory: Trajectory, mechanism: Mechanism, t: float, tool: ToolMotion, error: CutjointError
) -> UnreachableError:
    where = ", ".join(f"{x:.4g}" for x in tool.position)
    reached = getattr(error, "reached", None)
    return UnreachableError(
        f"trajectory '{trajectory.name}' leaves the workspace of {mechanism.name} at t = {t:.4g} s, "
        f"tool at ({where}) m: {error}. Make it smaller or move it",
        target=readonly(tool.position),
        reached=reached,
        progress=0.0,
    )
