"""The interface of a robot whose actuators determine its motion, in actuated coordinates.

`ClosedChain` (Pinocchio) and the published reduced models both offer it.  A controller, plant or comparison that is
written against it takes either.
"""

from __future__ import annotations

from inspect import getattr_static
from typing import Literal, Protocol, Self, TypeGuard, runtime_checkable

import numpy.typing as npt

from cutjoint.arrays import Array, as_vector
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.mechanism.loads import NO_LOADS, Loads
from cutjoint.mechanism.names import ActuatedCoordinates, Actuator
from cutjoint.mechanism.task import TargetLike, Task
from cutjoint.mechanism.types import Posture, Terms, Tool

JointLimits = Literal["respect", "ignore"]
"""What is done about joints that would go beyond their limits."""


def are_respected(limits: JointLimits) -> bool:
    """Whether joint limits are respected.

    Raises:
        InputError: it is neither "respect" nor "ignore".
    """
    if limits not in ("respect", "ignore"):
        raise InputError(f'limits must be "respect" or "ignore", found {limits!r}')
    return limits == "respect"


# long: the interface itself
@runtime_checkable
class Mechanism(Protocol):
    """A closed robot in its n actuated coordinates.

    `at` is a `Posture` that this mechanism made; `v` and `a` are velocity and acceleration of the actuated
    coordinates, shape (n,), [m/s] or [rad/s] and [m/s2] or [rad/s2]; `effort` is the force or torque of the actuators,
    shape (n,), [N] or [N m].
    """

    @property
    def name(self) -> str:
        """Name of the model, for messages and tables."""

    @property
    def n(self) -> int:
        """Number of actuated coordinates (equal to the mobility)."""

    @property
    def actuators(self) -> tuple[Actuator, ...]:
        """The actuated joints in the order of the coordinates."""

    @property
    def home(self) -> Posture:
        """The posture that calls without `near` start from; it picks the branch."""

    @property
    def task(self) -> Task:
        """Which motions of the tool are led.

        Raises:
            InputError: the robot has no tool, or its task cannot be told.
        """

    def close(self, q: ActuatedCoordinates, near: Posture | None = None, *, limits: JointLimits = "respect") -> Posture:
        """The closed posture with actuated coordinates `q`, on the branch of `near` (default: of `home`).

        Args:
            q: of all actuators, [m] or [rad]: in their order, shape (n,), or by name.
            near: picks the branch; default home.
            limits: whether joint limits are respected or ignored.

        Raises:
            InputError: wrong shape, not finite, or an actuator is missing.
            UnknownNameError: there is no actuator of a name.
            ClosureError: the loops cannot be closed there.
            LimitError: a joint would go beyond its limits, and they are not to be ignored.
            SingularError: a singular posture lies at or before `q`.
        """

    def reach(
        self, target: TargetLike, near: Posture | None = None, *, free: bool = False, limits: JointLimits = "respect"
    ) -> Posture:
        """The closed posture with the tool at `target` (inverse kinematics), on the branch of `near`.

        Args:
            target: a point (3,) [m]; a pose (`Pose`, (4, 4), x y z qx qy qz qw, or pin.SE3); or coordinates of the task
                by name, such as {"x": 0.1, "y": 0.0, "rz": 0.2}, [m] and [rad].
            near: picks the branch; default home.
            free: whether what the target does not say may be as it likes; it moves as little as it can then.
            limits: whether joint limits are respected or ignored.

        Raises:
            InputError: it is no target, or does not fix the task, and the rest is not free.
            UnreachableError: outside the workspace of this branch, or a pose that this tool cannot have.
            LimitError: a joint would go beyond its limits, and they are not to be ignored.
            SingularError: a singular posture lies at or before the target.
        """

    def tool(self, at: Posture, v: npt.ArrayLike | None = None) -> Tool:
        """Pose, frame Jacobian, its drift and twist of the tool.  Without `v` drift and twist are zero."""

    def terms(self, at: Posture, v: npt.ArrayLike | None = None) -> Terms:
        """Mass matrix, Coriolis vector and gravity.  Without `v` the Coriolis vector is zero."""

    def potential_energy(self, at: Posture) -> float:
        """Potential energy of gravity, zero where the owner's world frame has its origin, and of springs [J]."""

    @property
    def dissipates(self) -> bool:
        """Whether it has dampers or friction that may take work."""

    def dissipation(self, at: Posture, v: npt.ArrayLike) -> float:
        """Power that dampers and friction take [W], at least 0."""

    def load_effort(self, at: Posture, loads: Loads) -> Array:
        """Effort that does what `loads` do: J' wrench, shape (n,), [N] or [N m].

        Raises:
            InputError: they are no loads, or act where this model does not know a place.
            UnknownNameError: there is no such link.
        """

    def inverse_dynamics(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike, loads: Loads = NO_LOADS) -> Array:
        """Effort that gives the acceleration `a` against `loads` from outside, shape (n,), [N] or [N m]."""

    def forward_dynamics(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike, loads: Loads = NO_LOADS) -> Array:
        """Acceleration that `effort` and `loads` from outside give, shape (n,), [m/s2] or [rad/s2]."""

    def with_payload(self, mass: float) -> Self:
        """The same robot carrying a further point mass [kg] at the tool point."""


def is_mechanism(robot: object) -> TypeGuard[Mechanism]:
    """Whether an object has all that a `Mechanism` has.  Unlike `isinstance` in Python 3.11 it asks for none of it: the
    task of a robot that is one cannot always be told."""
    members = [name for name in vars(Mechanism) if not name.startswith("_")]
    return all(getattr_static(robot, name, None) is not None for name in members)


@door
def kinetic_energy(mechanism: Mechanism, at: Posture, v: npt.ArrayLike) -> float:
    """Kinetic energy v' M v / 2 [J].

    Raises:
        InputError: no mechanism, a posture of another one, or a speed of another shape than (n,).
    """
    speed = as_vector("v", v, mechanism.n)
    return 0.5 * float(speed @ mechanism.terms(at).mass @ speed)
