"""A robot at one state, known by another way than the compiled one: what its compiled functions are compared with.

States are drawn in the robot's own units (its length; the rate of a pendulum of that length under its gravity), and
what must agree is compared in them, against the size of the terms it is made of.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import CutjointError
from cutjoint.mechanism import Actuator, Posture, Terms, Tool

BESIDE = 0.02
"""How far from home the second state is, in the robot's units."""
DIFFERENCE = 1e-5
"""Step of differences, in the robot's units."""


@dataclass(frozen=True, eq=False)
class RobotUnits:
    """The units of one robot.

    Attributes:
        coordinate: of the actuated coordinates, shape (n,), [m] or [rad].
        turning: whether they are angles, shape (n,).
        length: one that tells how large the robot is [m].
        rate: of velocities [1/s].
    """

    coordinate: Array
    turning: tuple[bool, ...]
    length: float
    rate: float

    @staticmethod
    def of(actuators: Sequence[Actuator], length: float, gravity: float) -> RobotUnits:
        """Units of a robot with these actuators, this length [m] and this gravity [m/s2]."""
        turning = tuple(one.kind == "rotation" for one in actuators)
        coordinate = np.array([1.0 if turns else length for turns in turning])
        return RobotUnits(coordinate, turning, length, float(np.sqrt(gravity / length)) if gravity > 0.0 else 1.0)


@dataclass(frozen=True, eq=False)
class JointTerms(Terms):
    """The equation of motion at one state, and how all joints move.

    Attributes:
        tangent: T~, shape (nv, n).
        drift: accelerations of all joints at constant actuated rates, shape (nv,).
    """

    tangent: Array
    drift: Array


class RobotSample:
    """A robot at one state.  Arguments and right values of compiled functions by name.

    Args:
        units: of the robot.
        q: position variables.
        target: actuated coordinates, shape (n,).
        v, a: their velocity and acceleration.
        far: how far the world's origin is from the robot's, in its lengths, plus 1.

    Attributes that every robot adds, known by another way than the compiled one:
        potential: potential energy [J].
        weight: size of the weights that may cancel in the gravity vector, as an energy [J].

    Attributes of robots that have joints beside the actuated ones:
        v_full, effort_full: a random motion of all joints and random forces on them, shape (nv,).
    """

    potential: float
    weight: float
    v_full: Array
    effort_full: Array

    def __init__(self, units: RobotUnits, q: Array, target: Array, v: Array, a: Array, far: float) -> None:
        self.units, self.q, self.target, self.v, self.a, self.far = units, q, target, v, a, far
        unit = units.coordinate
        self.axes = {"q": unit, "1/q": 1.0 / unit, "1/v": 1.0 / (units.rate * unit), "m": np.full(3, units.length)}
        self.axes["J"] = np.ones(1)

    def beside(self, k: int, step: float, v: Array) -> JointTerms:
        """The equation of motion with actuated coordinate `k` moved by a small step, at the velocity `v`."""
        raise NotImplementedError

    @cached_property
    def tool(self) -> Tool:
        """The tool point."""
        raise NotImplementedError

    @cached_property
    def a_full(self) -> Array:
        """Acceleration of all joints that `effort_full` gives, shape (nv,)."""
        raise NotImplementedError

    # -- arguments and right values ----------------------------------------------------------------------------------

    @cached_property
    def terms(self) -> JointTerms:
        """The equation of motion here."""
        return self.beside(0, 0.0, self.v)

    @cached_property
    def effort(self) -> Array:
        """What gives the acceleration `a`."""
        return effort_for(self.terms, self.a)

    @property
    def p(self) -> Array:
        """Where the tool is."""
        return self.tool.position

    @property
    def kinetic(self) -> float:
        """Kinetic energy [J]."""
        return 0.5 * float(self.v @ self.terms.mass @ self.v)

    def slopes(self, value: Callable[[Terms], Array]) -> dict[str, Array]:
        """Derivatives of a value of the equation of motion, by central differences along the tangent of the loops."""
        by_q, by_v = [], []
        for k, unit in enumerate(self.units.coordinate):
            step = float(DIFFERENCE * unit)
            faster = self.units.rate * step * np.eye(len(self.v))[k]
            by_q.append((value(self.beside(k, step, self.v)) - value(self.beside(k, -step, self.v))) / (2 * step))
            change = value(self.beside(0, 0.0, self.v + faster)) - value(self.beside(0, 0.0, self.v - faster))
            by_v.append(change / (2 * faster[k]))
        return {"by_q": np.stack(by_q, axis=1), "by_v": np.stack(by_v, axis=1)}

    # -- sizes of the terms that results are sums of, in the robot's units ---------------------------------------------

    @property
    def speed(self) -> float:
        """The fastest motion that `v` makes."""
        return float(np.abs(self.terms.tangent @ self.v / self.axes["u"]).max())

    @property
    def bending(self) -> float:
        """Of the drift of all joints."""
        return self.speed**2

    @cached_property
    def energy(self) -> float:
        """Of an effort."""
        unit, terms = self.units.coordinate, self.terms
        return float(np.abs(unit * (terms.mass @ self.a)).max() + np.abs(unit * terms.coriolis).max()) + self.weight

    @cached_property
    def inertia(self) -> Array:
        """The mass matrix."""
        unit = self.units.coordinate
        return np.asarray(unit[:, None] * self.terms.mass * unit)

    @property
    def acceleration(self) -> float:
        """Of an acceleration that an effort gives."""
        return float(np.abs(np.linalg.inv(self.inertia)).max() * self.energy)

    @property
    def moving(self) -> float:
        """Of the Coriolis vector."""
        rate = np.abs(self.v / self.units.coordinate)
        return float((np.abs(self.inertia) @ rate).max() * rate.max())


class Truth(Protocol):
    """One robot, known by another way than the compiled one."""

    def samples(self, chance: np.random.Generator) -> list[RobotSample]:
        """The robot at a few states, random in velocity and acceleration."""


def near_home(home: Posture, unit: Array, close: Callable[[Array], Posture]) -> list[Posture]:
    """Home and a posture beside it, where one can be closed."""
    for sign in (1.0, -1.0):
        try:
            return [home, close(home.q + sign * BESIDE * unit * (1.0 + np.abs(home.q / unit)))]
        except CutjointError:
            continue
    return [home]


def drawn(units: RobotUnits, chance: np.random.Generator) -> tuple[Array, Array]:
    """A random velocity and acceleration of the actuators, in the robot's units."""
    n = len(units.coordinate)
    v = units.rate * units.coordinate * chance.normal(size=n)
    return v, units.rate**2 * units.coordinate * chance.normal(size=n)


def effort_for(terms: Terms, a: Array) -> Array:
    """Effort that gives an acceleration."""
    return np.asarray(terms.mass @ a + terms.coriolis + terms.gravity)


def acceleration_by(terms: Terms, effort: Array) -> Array:
    """Acceleration that an effort gives."""
    return np.asarray(np.linalg.solve(terms.mass, effort - terms.coriolis - terms.gravity))


def nearest_turn(q: Array, near: Array, turning: Sequence[bool]) -> Array:
    """`q` with whole turns added to its angles, so that they come next to `near`."""
    return np.asarray(q + np.where(turning, 2.0 * np.pi * np.round((near - q) / (2.0 * np.pi)), 0.0))
