"""How a mechanism is led: from the motion that a trajectory prescribes to the actuators, at one instant.

A tool motion is led in the rows of the robot's task.  With C the condition of the task (see `mechanism.task`), J the
frame Jacobian, V and A the prescribed twist and its rate, d the frame drift and T the turning of the condition,

    C J v = C V,    C J a = C (A - d) - T.

What is prescribed and not led must come by itself; what is led and not prescribed stays as at home.  Where the tool is
bound to a curve or a surface there are more rows than actuators: they must agree.  Where there are more actuators than
rows, these move only in the combinations that move the task with the least motion at the start of the way, q = q_0 +
B y: so a closed way of the tool is a closed way of the actuators, and the rates are exact derivatives.

A joint motion is what it says; the tool's follows from it.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.errors import SingularError, UnreachableError
from cutjoint.mechanism import JointLimits, Mechanism, Pose, Posture, Tool
from cutjoint.mechanism.task import NAMES
from cutjoint.motion.prescribed import joint_motion, tool_motion
from cutjoint.motion.values import POSITION, ROTATION, JointMotion, ToolMotion, Trajectory

CLOSED = 1e-14
"""What may be left of an error, beside the size of the robot, where the actuators are led in combinations."""
NOTHING, NANOMETRE = 1e-6, 1e-9
"""Levers that are rounding: beside the distance from the origin, and in metres."""
STEPS = 30
FAR_FROM_SINGULAR = 1e4
"""Largest over smallest singular value up to which rates are found by the inverse matrix; beyond, with more care."""


class Demand(Protocol):
    """What a trajectory prescribes at one instant, and how a mechanism follows it."""

    @property
    def place(self) -> Array:
        """Where the motion is, dimensionless: for the nearest of several."""

    def posture(self, near: Posture | None) -> Posture:
        """The posture then, on the branch of `near`."""

    def rates(self, posture: Posture) -> tuple[Array, Array, ToolMotion]:
        """Velocity and acceleration of the actuators at its posture, shape (n,), and the motion of the tool."""

    def missed(self, posture: Posture) -> dict[str, float]:
        """By how much what is prescribed and not led is missed, by name, [m] and [rad]; what is met is left out."""


class Follower(Protocol):
    """Follows one trajectory with one mechanism."""

    def at(self, t: float) -> Demand:
        """What is to be done at `t` [s].

        Raises:
            InputError: the trajectory gives no motion then, or one of another kind than at 0.
        """


def follower(trajectory: Trajectory, mechanism: Mechanism, limits: JointLimits) -> Follower:
    """What follows a trajectory with a mechanism.

    Raises:
        InputError: the trajectory gives no motion; or the robot has no tool, or its task cannot be told.
        UnreachableError, SingularError, ClosureError: no start.
    """
    if isinstance(trajectory.at(0.0), JointMotion):
        return JointFollower(trajectory, mechanism, limits)
    return ToolFollower(trajectory, mechanism, limits)


# ---- joint motions -------------------------------------------------------------------------------------------------


class JointFollower:
    """Follows a trajectory of the actuators."""

    def __init__(self, trajectory: Trajectory, mechanism: Mechanism, limits: JointLimits) -> None:
        self.trajectory, self.mechanism, self.limits = trajectory, mechanism, limits

    def at(self, t: float) -> JointDemand:
        """What is to be done at `t` [s]."""
        return JointDemand(self, joint_motion(self.trajectory, t, self.mechanism.n))


class JointDemand:
    """A joint motion at one instant: see `Demand`."""

    def __init__(self, whole: JointFollower, motion: JointMotion) -> None:
        self._whole, self._motion = whole, motion

    @property
    def place(self) -> Array:
        """The actuated coordinates."""
        return self._motion.q

    def posture(self, near: Posture | None) -> Posture:
        """Closed where the actuators are."""
        return self._whole.mechanism.close(self._motion.q, near, limits=self._whole.limits)

    def rates(self, posture: Posture) -> tuple[Array, Array, ToolMotion]:
        """Those that are prescribed, and what the tool does then."""
        v, a = self._motion.v, self._motion.a
        tool = self._whole.mechanism.tool(posture, v)
        rate = tool.frame_jacobian @ a + tool.frame_drift
        return v, a, ToolMotion(tool.position, tool.twist[:3], rate[:3], tool.rotation, tool.twist[3:], rate[3:])

    def missed(self, posture: Posture) -> dict[str, float]:
        """Nothing."""
        return {}


# ---- tool motions --------------------------------------------------------------------------------------------------


class ToolFollower:
    """Follows a trajectory of the tool.

    Attributes:
        task: of the mechanism.
        size: of the robot, see `size_of` [m].
        is_of_whole_point: whether the task is x, y and z.
        weights: what the rows of the task are divided by to have no dimension, shape (rows,).
        units: what a motion of the actuators is divided by to have none, shape (n,).
        combinations: B of the module's head for motions without dimension, orthonormal columns; or None.
        start: the posture at 0 where there is one.
    """

    def __init__(self, trajectory: Trajectory, mechanism: Mechanism, limits: JointLimits) -> None:
        self.trajectory, self.mechanism, self.limits = trajectory, mechanism, limits
        self.task, self.size = mechanism.task, size_of(mechanism)
        self.is_of_whole_point = self.task.names == POSITION
        self.weights = np.array([self.size if row < 3 else 1.0 for row in self.task.rows])
        self.units = np.array([1.0 if one.kind == "rotation" else self.size for one in mechanism.actuators])
        self.start: Posture | None = None
        self.combinations: Array | None = None
        if mechanism.n > len(self.task.rows):
            first = self.at(0.0)
            self.start = first.posture(None)
            led = first.led(mechanism.tool(self.start)) * self.units / self.weights[:, None]
            self.combinations = np.linalg.qr(led.T)[0]

    def at(self, t: float) -> ToolDemand:
        """What is to be done at `t` [s]."""
        motion, still = tool_motion(self.trajectory, t), np.zeros(3)
        prescribed = motion.prescribed
        place, speed, rate = motion.position, motion.velocity, motion.acceleration
        rotation, turning, change = self.task.home.rotation, still, still
        if not set(prescribed).isdisjoint(ROTATION):
            assert motion.rotation is not None
            assert motion.angular_velocity is not None
            assert motion.angular_acceleration is not None
            rotation, turning, change = motion.rotation, motion.angular_velocity, motion.angular_acceleration
        if not set(prescribed).issuperset(POSITION):
            basis, home = self.task.basis, self.task.home.position
            kept = basis @ np.diag([float(name in prescribed) for name in POSITION]) @ basis.T
            place, speed, rate = home + kept @ (place - home), kept @ speed, kept @ rate
        pose = Pose(place, rotation)
        return ToolDemand(self, motion, pose, np.concatenate([speed, turning]), np.concatenate([rate, change]))


class ToolDemand:
    """A tool motion at one instant: see `Demand`.  What is not prescribed is as at home."""

    def __init__(self, whole: ToolFollower, motion: ToolMotion, pose: Pose, twist: Array, twist_rate: Array) -> None:
        self._whole, self._motion = whole, motion
        self._pose, self._twist, self._twist_rate = pose, twist, twist_rate
        self._condition = whole.task.towards(pose, whole.task.rows)

    @property
    def place(self) -> Array:
        """Position beside the size of the robot, and rotation where that is led."""
        whole = self._whole
        place = self._pose.position / whole.size
        return place if whole.task.is_of_point else np.concatenate([place, self._pose.rotation.ravel()])

    def posture(self, near: Posture | None) -> Posture:
        """By inverse kinematics; where there are more actuators than rows, in their combinations."""
        whole = self._whole
        if whole.combinations is None or near is None:
            target = self._pose.position if whole.is_of_whole_point else self._pose
            return whole.start or whole.mechanism.reach(target, near, free=True, limits=whole.limits)
        at, last = near, np.inf
        for _ in range(STEPS):
            tool = whole.mechanism.tool(at)
            error = self._condition.error(tool.position, tool.rotation)
            left = float(np.abs(error / whole.weights).max())
            if left < CLOSED or (left < 1e3 * CLOSED and left >= last):
                return at
            last = left
            at = whole.mechanism.close(at.q - _Rates(whole, self.led(tool)).of(error, 0.0), at, limits=whole.limits)
        raise UnreachableError(
            f"{whole.mechanism.name} cannot be led there by the combinations of its {whole.mechanism.n} actuators that "
            "lead its tool at the start",
            target=self._pose.position,
        )

    def led(self, tool: Tool) -> Array:
        """Jacobian of the task, shape (rows, n)."""
        return np.asarray(self._condition.matrix(tool.rotation) @ tool.frame_jacobian)

    def rates(self, posture: Posture) -> tuple[Array, Array, ToolMotion]:
        """Those by which the task is led, and what the tool does then."""
        mechanism = self._whole.mechanism
        here = mechanism.tool(posture)
        condition = self._condition.matrix(here.rotation)
        rates = _Rates(self._whole, condition @ here.frame_jacobian)
        speed = 1.0 / self._whole.trajectory.duration
        v = rates.of(condition @ self._twist, speed)
        tool = mechanism.tool(posture, v)
        turning = self._condition.turning(here.rotation, tool.twist, self._twist)
        wanted, drift = condition @ self._twist_rate, condition @ tool.frame_drift + turning
        a = rates.of(wanted - drift, speed * speed + rates.size_of(wanted) + rates.size_of(drift))
        return v, a, self._tool_motion(tool, a)

    def missed(self, posture: Posture) -> dict[str, float]:
        """By how much what is prescribed and not led is missed."""
        whole, found = self._whole, {}
        for name in self._motion.prescribed:
            if name not in whole.task.names:
                row, tool = NAMES.index(name), whole.mechanism.tool(posture)
                error = whole.task.towards(self._pose, [row]).error(tool.position, tool.rotation)
                size = abs(float(error[0]))
                if size > tolerances.REACHED.value * (whole.size if row < 3 else 1.0):
                    found[name] = size
        return found

    def _tool_motion(self, tool: Tool, a: Array) -> ToolMotion:
        """What is prescribed, as it is; the rest as the posture gives it."""
        motion, whole_rotation = self._motion, set(self._motion.prescribed).issuperset(ROTATION)
        if whole_rotation and set(motion.prescribed).issuperset(POSITION):
            return motion
        rate = tool.frame_jacobian @ a + tool.frame_drift
        place, speed, change = tool.position, tool.twist[:3], rate[:3]
        if set(motion.prescribed).issuperset(POSITION):
            place, speed, change = motion.position, motion.velocity, motion.acceleration
        rotation, turning, bend = tool.rotation, tool.twist[3:], rate[3:]
        if whole_rotation:
            rotation, turning, bend = self._pose.rotation, self._twist[3:], self._twist_rate[3:]
        return ToolMotion(place, speed, change, rotation, turning, bend)


class _Rates:
    """The rates of the actuators that give rates of the task, at one posture."""

    def __init__(self, whole: ToolFollower, led: Array) -> None:
        self._whole = whole
        matrix = led * whole.units / whole.weights[:, None]
        self._matrix = matrix if whole.combinations is None else matrix @ whole.combinations
        self._inverse: Array | None = None
        self._is_regular = False

    def size_of(self, wanted: Array) -> float:
        """The largest of some rates of the task, in sizes of the robot."""
        return float(np.abs(wanted / self._whole.weights).max())

    def of(self, wanted: Array, scale: float) -> Array:
        """The x, shape (n,), with led @ x = wanted, in the combinations of the actuators where there are some.

        Args:
            wanted: rates of the task, shape (rows,).
            scale: what is small beside this may be rounding, in sizes of the robot.

        Raises:
            SingularError: the tool cannot move in a direction of its task.
            UnreachableError: more rows than actuators, which do not agree.
        """
        whole, matrix = self._whole, self._matrix
        if not wanted.any():
            return np.zeros(whole.mechanism.n)
        self._check()
        right = wanted / whole.weights
        if self._inverse is not None:
            found = self._inverse @ right
        elif matrix.shape[0] == matrix.shape[1]:
            found = np.linalg.solve(matrix, right)
        else:
            found = np.linalg.lstsq(matrix, right, rcond=None)[0]
            left = float(np.abs(matrix @ found - right).max() / (scale + np.abs(right).max()))
            if left > tolerances.REACHED.value:
                raise UnreachableError(
                    f"the tool of {whole.mechanism.name} cannot move so: of its {len(right)} coordinates {whole.task} "
                    f"it leads {len(found)}, and {left:.2g} of the motion is beside them",
                    target=wanted,
                )
        return np.asarray(whole.units * (found if whole.combinations is None else whole.combinations @ found))

    def _check(self) -> None:
        if self._is_regular:
            return
        self._inverse = _plain_inverse(self._matrix)
        if self._inverse is not None:
            self._is_regular = True
            return
        sizes = np.linalg.svd(self._matrix, compute_uv=False)
        if sizes[-1] <= tolerances.SINGULAR.value * sizes[0]:
            name, task = self._whole.mechanism.name, self._whole.task
            raise SingularError(
                f"the tool of {name} cannot move in some direction of its task {task} here",
                kind="type-1",
                measure=float(sizes[-1] / max(sizes[0], 1e-300)),
                limit=tolerances.SINGULAR.value,
            )
        self._is_regular = True


def _plain_inverse(matrix: Array) -> Array | None:
    """The inverse of a square matrix that is far from singular, else None.

    The product of both sizes is at least the largest singular value over the smallest one.
    """
    if matrix.shape[0] != matrix.shape[1]:
        return None
    try:
        inverse = np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        return None
    squares = matrix.ravel().dot(matrix.ravel()) * inverse.ravel().dot(inverse.ravel())
    return np.asarray(inverse) if squares < FAR_FROM_SINGULAR**2 else None


def size_of(mechanism: Mechanism) -> float:
    """A length of the robot [m]: the longest lever of an actuator that turns, or way from zero of one that slides.

    Where that is nothing, as on a wrist whose tool point is its centre, the distance from the world's origin, or 1 m.
    """
    tool = mechanism.tool(mechanism.home)
    levers = np.linalg.norm(tool.jacobian, axis=0)
    lengths = [
        lever if one.kind == "rotation" else abs(q)
        for one, lever, q in zip(mechanism.actuators, levers, mechanism.home.q, strict=True)
    ]
    away = float(np.linalg.norm(tool.position))
    size = float(max(lengths))
    if size < NOTHING * away:
        size = away
    return size if size > NANOMETRE else 1.0
