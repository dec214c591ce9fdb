"""A robot at one state, by its model that is not compiled: what its compiled functions are compared with.

No expression, no order of elimination and no regrouped inertia is in it: chains answer by Pinocchio's recursions and
the singular values of their loops, published models by their own equations.  States are drawn in the robot's own units
(its length; the rate of a pendulum of that length under its gravity), and what must agree is compared in them, against
the size of the terms it is made of.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cutjoint.arrays import Array
from cutjoint.mechanism import Mechanism, Pose, Posture, Terms, Tool
from cutjoint.mechanism.rotations import vector_of

DIFFERENCE = 1e-5
"""Step of differences, in the robot's units."""
FURTHER = 1e-4
"""Step of differences in parameters, in their units: robots are built anew for them."""
MOST_BUILT = 6
"""For more parameters than these, robots are not built anew only to compare derivatives."""


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


# long: a property a quantity that something is compared with
class RobotSample:
    """A robot at one state, with a random velocity and acceleration of its actuators.  Arguments and right values of
    compiled functions by name; worked out when asked for.

    Args:
        model: the robot, not compiled.
        units: of the robot.
        at: where.
        chance: what is random.

    Attributes:
        q: position variables.
        far: how far the world's origin is from the robot's, in its lengths, plus 1.
        spin: least rate that its idle freedoms are taken to have, in its units.
        axes: units of the axes of results by name, see `ResultPart`.
        v_full, effort_full: where there are further joints, a random motion of all and random forces, shape (nv,).
    """

    v_full: Array
    effort_full: Array

    def __init__(self, model: Mechanism, units: RobotUnits, at: Posture, chance: np.random.Generator) -> None:
        self.model, self.units, self.at = model, units, at
        self.far, self.spin = 1.0, 0.0
        self.q, self.target, unit = at.q, at.q, units.coordinate
        self.v = units.rate * unit * chance.normal(size=len(unit))
        self.a = units.rate**2 * unit * chance.normal(size=len(unit))
        self.axes = {"q": unit, "1/q": 1.0 / unit, "1/v": 1.0 / (units.rate * unit), "m": np.full(3, units.length)}
        self.axes.update(
            {"J": np.ones(1), "1": np.ones(1), "t": np.repeat([units.length, 1.0], 3), "x": unit, "u": unit}
        )

    # -- arguments and right values ----------------------------------------------------------------------------------

    @cached_property
    def terms(self) -> Terms:
        """The equation of motion here."""
        return self.model.terms(self.at, self.v)

    def terms_at(self, at: Posture, v: Array) -> Terms:
        """The equation of motion elsewhere."""
        return self.model.terms(at, v)

    @cached_property
    def tool(self) -> Tool:
        """The tool."""
        return self.model.tool(self.at, self.v)

    @property
    def p(self) -> Array:
        """Where the tool is."""
        return self.tool.position

    @cached_property
    def effort(self) -> Array:
        """What gives the acceleration `a`."""
        return effort_for(self.terms, self.a)

    @property
    def jacobian(self) -> Array:
        """Frame Jacobian of the tool, shape (6, n)."""
        return self.tool.frame_jacobian

    @cached_property
    def wrench(self) -> Array:
        """Force and moment on the tool, as strong as the motors, shape (6,)."""
        return np.asarray(self.energy * np.array([0.3, -0.5, 0.7, 0.2, 0.6, -0.4]) / self.axes["t"])

    @property
    def push(self) -> Array:
        """Effort that does what `wrench` does."""
        return np.asarray(self.jacobian.T @ self.wrench)

    @cached_property
    def tangent(self) -> Array:
        """T, shape (nv, n)."""
        return np.eye(len(self.v))

    @property
    def drift(self) -> Array:
        """Accelerations of all joints at constant actuated rates, shape (nv,)."""
        return np.zeros(len(self.v))

    @property
    def a_full(self) -> Array:
        """Acceleration of all joints that `effort_full` gives, shape (nv,)."""
        raise NotImplementedError

    def q_rate(self, v_full: Array) -> Array:
        """Rates of the position variables at a velocity of all joints."""
        return v_full

    @property
    def lost_full(self) -> Array:
        """Power that friction takes at `v_full`, shape (1,)."""
        raise NotImplementedError

    @property
    def goal(self) -> Array:
        """Place in the model and rotation that the tool shall have, shape (12,)."""
        raise NotImplementedError

    @property
    def towards(self) -> Mapping[str, Array]:
        """A step of Newton's method to `goal`."""
        raise NotImplementedError

    def known_slopes(self, what: str) -> Mapping[str, Array]:
        """Derivatives in the parameters, of the tool or of the effort, where they can be told."""
        raise NotImplementedError

    def aside(self, k: int, step: float) -> Posture:
        """A posture with actuated coordinate `k` moved by a small step."""
        return self.model.close(self.at.q + step * np.eye(len(self.v))[k], self.at)

    # -- sizes of the terms that results are sums of, in the robot's units ---------------------------------------------

    @cached_property
    def weight(self) -> float:
        """Of the weights that may cancel in the gravity vector, an energy [J]."""
        return float(np.abs(self.units.coordinate * self.terms.gravity).max())

    @cached_property
    def held(self) -> float:
        """Of the springs that may cancel, an energy [J]."""
        return float(np.abs(self.units.coordinate * self.terms.springs).max())

    @cached_property
    def rubbed(self) -> float:
        """Of friction and dampers."""
        return float(np.abs(self.units.coordinate * self.terms.friction).max())

    @property
    def smooth(self) -> bool:
        """Whether differences tell the slopes: no friction changes its sign and no stop is met within them."""
        return True

    @property
    def speed(self) -> float:
        """The fastest motion that `v` makes."""
        return float(np.abs(self.tangent @ self.v / self.axes["u"]).max())

    @cached_property
    def energy(self) -> float:
        """Of an effort."""
        unit, terms = self.units.coordinate, self.terms
        moving = float(np.abs(unit * (terms.mass @ self.a)).max() + np.abs(unit * terms.coriolis).max())
        return moving + self.weight + self.held + self.rubbed

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


def goal_of(pose: Pose, origin: Array) -> Array:
    """A pose for compiled functions: place in a model that stands at `origin`, and rotation, shape (12,)."""
    goal = np.empty(12)
    goal[:3], goal[3:] = pose.position - origin, pose.rotation.ravel()
    return goal


def twist_of(frame: Array, rotation: Array) -> Array:
    """Place, and small turn since `rotation`, of a frame (3, 4), shape (6,)."""
    return np.concatenate([frame[:, 3], vector_of(frame[:, :3] @ rotation.T)])


def effort_for(terms: Terms, a: Array) -> Array:
    """Effort that gives an acceleration."""
    return np.asarray(terms.mass @ a + terms.bias)


def acceleration_by(terms: Terms, effort: Array) -> Array:
    """Acceleration that an effort gives."""
    return np.asarray(np.linalg.solve(terms.mass, effort - terms.bias))


def slopes(sample: RobotSample, value: Callable[[Terms], Array]) -> dict[str, Array]:
    """Derivatives of a value of the equation of motion, by central differences along the tangent of the loops; none
    where these do not tell."""
    if not sample.smooth:
        return {}
    ask, at, v, units = sample.terms_at, sample.at, sample.v, sample.units
    by_q, by_v = [], []
    for k, unit in enumerate(units.coordinate):
        step = float(DIFFERENCE * unit)
        ahead, behind = (value(ask(sample.aside(k, s), v)) for s in (step, -step))
        by_q.append((ahead - behind) / (2 * step))
        faster = units.rate * step * np.eye(len(v))[k]
        by_v.append((value(ask(at, v + faster)) - value(ask(at, v - faster))) / (2 * faster[k]))
    return {"by_q": np.stack(by_q, axis=1), "by_v": np.stack(by_v, axis=1)}


def nearest_turn(q: Array, near: Array, turning: Sequence[bool]) -> Array:
    """`q` with whole turns added to its angles, so that they come next to `near`."""
    return np.asarray(q + np.where(turning, 2.0 * np.pi * np.round((near - q) / (2.0 * np.pi)), 0.0))
