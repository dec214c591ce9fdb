"""What the published models have in common: a reduced model in the coordinates of its actuators.

A paper's own part is its equations, evaluated at one posture: an `EquationState`.  From that comes the whole interface
of `cutjoint.mechanism.Mechanism` but for finding the postures.  A model whose forward kinematics is closed form can
also be asked for its state on symbols, which is all that the compiler needs (`ClosedFormModel`).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Hashable, Sequence
from copy import copy
from dataclasses import Field, replace
from functools import cached_property
from typing import Any, ClassVar, Generic, Protocol, Self, TypeVar

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, as_vector, readonly
from cutjoint.doors import door, of_type
from cutjoint.errors import InputError, UnreachableError
from cutjoint.mechanism import (
    NO_LOADS,
    ActuatedCoordinates,
    Actuator,
    JointLimits,
    JointPhysics,
    Layout,
    Loads,
    Posture,
    TargetLike,
    Task,
    Terms,
    Tool,
)
from cutjoint.mechanism.interface import are_respected
from cutjoint.mechanism.loads import as_loads, tool_wrench
from cutjoint.mechanism.physics import LARGEST_PAYLOAD
from cutjoint.papers import motors
from cutjoint.papers.scalars import NUMBERS, Functions, Matrix3, Scalar, Vector, Vector3
from cutjoint.tolerances import REACHED


class PaperParameters(Protocol):
    """Geometry and masses of a robot, in a frozen dataclass of numbers."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    @property
    def g(self) -> float:
        """Size of gravity [m/s2]."""
        ...


P = TypeVar("P", bound=PaperParameters)
B = TypeVar("B", bound=Hashable)


class EquationState(ABC):
    """A paper's equations at one posture, on floats, arrays or symbols alike; `v` are rates of the n actuators."""

    __slots__ = ()

    @abstractmethod
    def mass(self) -> Sequence[Vector]:
        """Rows of the mass matrix, (n, n)."""

    @abstractmethod
    def coriolis(self, v: Vector) -> Vector:
        """Coriolis vector."""

    @abstractmethod
    def gravity(self) -> Vector:
        """Effort that holds the posture."""

    @abstractmethod
    def potential_energy(self) -> Scalar:
        """Potential energy of gravity [J]."""

    @abstractmethod
    def tool(self, v: Vector | None = None) -> tuple[Vector3, Sequence[Vector], Vector3]:
        """Position [m], rows of the Jacobian (3, n) and drift [m/s2] of the tool; without `v` the drift is zero."""

    def turning(self, v: Vector | None = None) -> tuple[Matrix3, Sequence[Vector], Vector3] | None:
        """Axes of the tool as columns (3, 3), rows of the Jacobian of its angular velocity (3, n) and the drift of that
        [rad/s2], without `v` zero; None of a tool that never turns, as most papers have it."""
        return None

    @abstractmethod
    def strains(self) -> Vector:
        """Numbers whose size tells how badly conditioned the posture is: about 1 far from singularities."""


# long: what every `Mechanism` has, a few lines a method
class ReducedModel(ABC, Generic[P]):
    """A published model in its n actuated coordinates, with `parameters`.

    A subclass is a `Mechanism` once it has what is abstract here.

    Attributes:
        name: for messages and tables.
        actuators: in the order of the coordinates.
        payload: the parameter that a payload adds to.
        stored: names of the numbers that a posture stores in `q_full`, each with its unit, as `x[m]`.
        motors: what every motor does that the paper leaves out; none as a rule (see `with_motors`).
    """

    name: str
    actuators: ClassVar[tuple[Actuator, ...]]
    payload: ClassVar[str]
    stored: ClassVar[tuple[str, ...]]
    motors: tuple[JointPhysics, ...] = ()

    def __init__(self, parameters: P) -> None:
        self.parameters = parameters
        self.n = len(self.actuators)
        self._shape = (len(self.stored),)
        unit = self.actuators[0].unit
        self._rate, self._acceleration, self._effort = f"{unit}/s", f"{unit}/s2", self.actuators[0].effort_unit

    @cached_property
    def layout(self) -> Layout:
        """What the numbers of its postures are called."""
        return Layout.of_numbers(self.name, self.actuators, self.stored)

    @property
    @abstractmethod
    def length(self) -> float:
        """Characteristic length [m]."""

    @cached_property
    @abstractmethod
    def home(self) -> Posture:
        """The posture that calls without `near` start from; it picks the branch."""

    @abstractmethod
    def close(self, q: ActuatedCoordinates, near: Posture | None = None, *, limits: JointLimits = "respect") -> Posture:
        """The posture with the actuators at `q`, on the branch of `near` (default: of `home`).  The papers give no
        limits of joints."""

    @abstractmethod
    def reach_point(self, p: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """The posture with the tool at `p` [m], on the branch of `near` (default: of `home`)."""

    @cached_property
    def task(self) -> Task:
        """Where the tool point is, in the axes of the world."""
        return Task(("x", "y", "z"), self.tool(self.home).pose, self.name)

    def reach(
        self, target: TargetLike, near: Posture | None = None, *, free: bool = False, limits: JointLimits = "respect"
    ) -> Posture:
        """The posture with the tool at a target, see `Mechanism.reach`; what is raised besides is that of
        `reach_point`.

        Raises:
            InputError: it is no target.
            UnreachableError: a pose that is turned otherwise than the tool is there.
        """
        are_respected(limits)
        of_type("free", free, bool)
        if isinstance(target, np.ndarray) and target.shape == (3,):
            return self.reach_point(target, near)
        wanted = self.task.target(target, free)
        point = wanted.pose.position
        if not set(wanted.led) >= {0, 1, 2}:
            start = self.tool(self.home if near is None else near).position
            point = np.array([point[i] if i in wanted.led else start[i] for i in range(3)])
        found = self.reach_point(point, near)
        if not set(wanted.asked) <= {0, 1, 2}:
            _, angle = self.task.left(self.tool(found).pose, wanted)
            if angle > REACHED.value:
                raise UnreachableError(
                    f"{self.name} cannot give its tool {wanted}: there it is turned by {math.degrees(angle):.3g} deg "
                    "away from it; ask for the point alone",
                    target=point,
                    progress=0.0,
                )
        return found

    @abstractmethod
    def state(self, at: Posture) -> EquationState:
        """The equations at a posture."""

    @abstractmethod
    def rebuilt(self, parameters: P) -> Self:
        """The same kind of robot, on the same branch at home, with other parameters."""

    def tool(self, at: Posture, v: npt.ArrayLike | None = None) -> Tool:
        """Pose, frame Jacobian, its drift and twist of the tool."""
        state, speed = self.state(at), None if v is None else self._numbers("v", v, self._rate)
        (position, jacobian, drift), turning = state.tool(speed), state.turning(speed)
        if turning is None:
            given = None if speed is None else np.array(speed)
            return Tool.of_point(np.array(position), np.array(jacobian), np.array(drift), given)
        rotation, turns, turned = turning
        rows = np.array([*jacobian, *turns])
        twist = np.zeros(6) if speed is None else rows @ speed
        return Tool(np.array(position), np.array(rotation), rows, np.array([*drift, *turned]), twist)

    def terms(self, at: Posture, v: npt.ArrayLike | None = None) -> Terms:
        """Mass matrix, Coriolis vector and gravity."""
        state = self.state(at)
        coriolis = (0.0,) * self.n if v is None else state.coriolis(self._numbers("v", v, self._rate))
        found = Terms(np.array(state.mass()), np.array(coriolis), np.array(state.gravity()))
        if not self.motors:
            return found
        q, speed = tuple(at.q.tolist()), (0.0,) * self.n if v is None else self._numbers("v", v, self._rate)
        return replace(
            found,
            mass=found.mass + np.diag([one.armature for one in self.motors]),
            springs=np.array(motors.springs(self.motors, q)),
            friction=np.array(motors.friction(self.motors, speed)),
        )

    def potential_energy(self, at: Posture) -> float:
        """Potential energy of gravity, and of springs at the motors [J]."""
        weights = float(self.state(at).potential_energy())
        return weights + float(motors.spring_energy(self.motors, tuple(at.q))) if self.motors else weights

    @property
    def dissipates(self) -> bool:
        """Whether motors have anything that may take work."""
        return any(one.acts for one in self.motors)

    def dissipation(self, at: Posture, v: npt.ArrayLike) -> float:
        """Power that the friction of the motors takes [W]."""
        self.full(at)  # it is one of this model
        speed = self._numbers("v", v, self._rate)
        if not self.motors:
            return 0.0
        return float(np.dot(motors.friction(self.motors, speed), speed))

    def load_effort(self, at: Posture, loads: Loads) -> Array:
        """Effort that does what loads at the tool do, shape (n,).

        Raises:
            InputError: they are no loads, or one acts on a link: the papers name none.
        """
        tool = self.tool(at)
        return readonly(tool.frame_jacobian.T @ tool_wrench(as_loads(loads), tool, self.name))

    def inverse_dynamics(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike, loads: Loads = NO_LOADS) -> Array:
        """Effort of the actuators for their acceleration `a`, shape (n,)."""
        terms = self.terms(at, v)
        effort = terms.mass @ self._numbers("a", a, self._acceleration) + terms.bias
        return readonly(self._relieved(effort, at, loads))

    def forward_dynamics(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike, loads: Loads = NO_LOADS) -> Array:
        """Acceleration of the actuators that `effort` gives, shape (n,)."""
        terms = self.terms(at, v)
        given = self._aided(as_vector("effort", effort, self.n, self._effort), at, loads)
        return readonly(np.linalg.solve(terms.mass, given - terms.bias))

    def _aided(self, effort: Array, at: Posture, loads: Loads) -> Array:
        """An effort (n,) and what loads do."""
        return effort if loads is NO_LOADS else effort + self.load_effort(at, loads)

    def _relieved(self, effort: Array, at: Posture, loads: Loads) -> Array:
        """An effort (n,) without what loads do."""
        return effort if loads is NO_LOADS else effort - self.load_effort(at, loads)

    @door
    def with_payload(self, mass: float) -> Self:
        """The same robot with `mass` [kg] more at the tool.

        Raises:
            InputError: the mass is not from 0 to `LARGEST_PAYLOAD`.
        """
        if not 0.0 <= mass <= LARGEST_PAYLOAD:
            raise InputError(f"a payload must be a mass from 0 to {LARGEST_PAYLOAD:g} kg, found {mass!r}")
        carried = getattr(self.parameters, self.payload)
        return self.with_parameters(replace(self.parameters, **{self.payload: carried + float(mass)}))

    def with_parameters(self, parameters: P) -> Self:
        """The same robot, motors too, with other parameters."""
        return self.rebuilt(parameters)._with(self.motors)

    def with_motors(self, physics: JointPhysics | Sequence[JointPhysics]) -> Self:
        """The same robot with dampers, friction, springs and rotors at its motors, one for all or n of them.

        Raises:
            InputError: not as many as motors, a number out of range, or what a published model cannot have.
        """
        return copy(self)._with(motors.checked(physics, self.actuators))

    def _with(self, physics: tuple[JointPhysics, ...]) -> Self:
        self.motors = physics
        return self

    def full(self, at: Posture) -> list[float]:
        """What a posture of this model stores.

        Raises:
            InputError: it is of another mechanism.
        """
        if not hasattr(at, "q_full"):
            of_type("at", at, Posture)
        if at.q_full.shape != self._shape:
            raise InputError(
                f"a posture of {self.name} holds ({', '.join(self.stored)}), shape {self._shape}; found shape "
                f"{at.q_full.shape}: a posture belongs to the mechanism that made it"
            )
        found: list[float] = at.q_full.tolist()
        return found

    def _numbers(self, name: str, values: npt.ArrayLike, unit: str) -> Vector:
        return tuple(as_vector(name, values, self.n, unit).tolist())


class ClosedFormModel(ReducedModel[P], Generic[P, B]):
    """A reduced model whose forward kinematics is closed form, so that its equations run on symbols too.

    A branch can be hashed and written as JSON, and does not change between singularities.
    """

    @abstractmethod
    def branch(self, at: Posture) -> B:
        """The branch that a posture is on."""

    @abstractmethod
    def on_branch(self, branch: B) -> Self:
        """The same robot with its home on another branch."""

    @abstractmethod
    def state_at(self, parameters: P, q: Vector, branch: B, fn: Functions = NUMBERS) -> EquationState:
        """The equations at the actuated coordinates `q`; they and the parameters may be symbols."""

    @abstractmethod
    def inverse_kinematics(self, parameters: P, p: Vector3, branch: B, fn: Functions = NUMBERS) -> Vector:
        """Actuated coordinates that hold the tool at `p` [m]."""
