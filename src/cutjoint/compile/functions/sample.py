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
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.rank import null_space
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.mechanism import Mechanism, Pose, Posture, Terms, Tool
from cutjoint.mechanism.rotations import vector_of

DIFFERENCE = 1e-5
"""Step of differences, in the robot's units."""
FURTHER = 1e-4
"""Step of differences in parameters, in their units: robots are built anew for them."""
MOST_BUILT = 6
"""For more parameters than these, robots are not built anew only to compare derivatives."""
ASIDE = 1e-6
"""How far away the goal of a step of Newton's method is, in the robot's units."""


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

    @property
    def speed(self) -> float:
        """The fastest motion that `v` makes."""
        return float(np.abs(self.tangent @ self.v / self.axes["u"]).max())

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


class ChainSample(RobotSample):
    """A closed chain at one state, of which all joints are known; `source` is what is traced, and its model stands at
    `origin`."""

    def __init__(
        self,
        source: ChainSource,
        units: RobotUnits,
        at: Posture,
        chance: np.random.Generator,
        origin: Array | None = None,
    ) -> None:
        self.origin = source.chain.origin if origin is None else origin
        super().__init__(source.chain, units, at, chance)
        self.source, self.chain, self.q, scale = source, source.chain, at.q_full, source.rate_scale
        self.far = float(np.abs(np.array(source.origin) / units.length).max()) + 1.0
        self.spin = units.rate if source.idle else 0.0
        self.axes.update(x=source.position_scale, u=scale, r=1.0 / source.row_scale)
        self.axes["1/p"] = 1.0 / source.arguments.units(source.scale)
        self.mass = sum(float(inertia.mass) for inertia in list(source.model.inertias)[1:])
        motions = null_space(source.scaled_jacobian(self.q))
        self.v_full = np.asarray(units.rate * scale * (motions @ chance.normal(size=motions.shape[1])))
        energy = self.mass * units.length**2 * units.rate**2
        self.effort_full = np.asarray(energy / scale * chance.normal(size=source.nv))

    @cached_property
    def tangent(self) -> Array:
        return self.chain.tangent(self.at)

    @property
    def drift(self) -> Array:
        return self.chain.drift(self.at, self.v)

    @property
    def a_full(self) -> Array:
        return self.chain.full_forward_dynamics(self.at, self.v_full, self.effort_full).acceleration

    def known_slopes(self, what: str) -> Mapping[str, Array]:
        names, nominal = self.source.parameters, self.source.nominal
        if len(names) > MOST_BUILT or (self.source.idle and what != "tool_by_parameters"):
            return {}
        columns = []
        for k, unit in enumerate(1.0 / self.axes["1/p"]):
            step = FURTHER * float(unit)
            places = (-1.0, 1.0) if nominal[k] >= step or self.source.low[k] != 0.0 else (0.0, 1.0, 2.0)
            weights = (-0.5, 0.5) if len(places) == 2 else (-1.5, 2.0, -0.5)
            found = [self._built(what, nominal + place * step * np.eye(len(names))[k]) for place in places]
            if what == "tool_by_parameters":
                found = [_twist(one, self.tool.rotation) for one in found]
            columns.append(sum(weight * one for weight, one in zip(weights, found, strict=True)) / step)
        return {"by_parameters": np.stack(columns, axis=1)}

    def _built(self, what: str, values: Array) -> Array:
        """The tool's frame (3, 4), or the effort, of the robot built anew with other parameters."""
        source = self.source
        robot = self.chain.rebuilt(source.arguments.rebuilt(dict(zip(source.parameters, values.tolist(), strict=True))))
        at = robot.assemble(self.q)
        if what == "tool_by_parameters":
            tool = robot.tool(at)
            return np.column_stack([tool.rotation, tool.position])
        return robot.inverse_dynamics(at, self.v, self.a)

    @cached_property
    def wanted(self) -> Pose:
        """Where the tool shall be: a little aside; with idle freedoms, which the steps need not share, where it is."""
        aside = 0.0 if self.source.idle else ASIDE / self.units.rate
        twist = aside * self.tool.twist
        return self.tool.pose.moved(twist[:3], twist[3:])

    @property
    def goal(self) -> Array:
        return goal_of(self.wanted, self.origin)

    @property
    def towards(self) -> Mapping[str, Array]:
        source, task, tool, unit = self.source, self.chain.task, self.tool, self.units.coordinate
        condition = task.towards(self.wanted, task.rows)
        missed = condition.error(tool.position, tool.rotation)
        jacobian = condition.matrix(tool.rotation) @ tool.frame_jacobian
        scale = self.axes["t"][list(task.rows)]
        change = np.linalg.lstsq(jacobian * unit / scale[:, None], -missed / scale, rcond=None)[0]
        q_next = np.asarray(pin.integrate(source.model, self.q, self.tangent @ (unit * change)))
        return {
            "q_next": q_next,
            "place": tool.position - self.origin,
            "rotation": tool.rotation,
            "size": np.array([np.abs((q_next - self.q) / source.position_scale).max()]),
            "gap": np.array([np.abs(missed / scale).max()]),
        }

    def aside(self, k: int, step: float) -> Posture:
        return self.chain.assemble(pin.integrate(self.source.model, self.q, step * self.tangent[:, k]))

    @cached_property
    def weight(self) -> float:
        return self.mass * float(np.linalg.norm(self.source.model.gravity.linear)) * self.units.length


def goal_of(pose: Pose, origin: Array) -> Array:
    """A pose for compiled functions: place in a model that stands at `origin`, and rotation, shape (12,)."""
    goal = np.empty(12)
    goal[:3], goal[3:] = pose.position - origin, pose.rotation.ravel()
    return goal


def _twist(frame: Array, rotation: Array) -> Array:
    """Place, and small turn since `rotation`, of a frame (3, 4), shape (6,)."""
    return np.concatenate([frame[:, 3], vector_of(frame[:, :3] @ rotation.T)])


def effort_for(terms: Terms, a: Array) -> Array:
    """Effort that gives an acceleration."""
    return np.asarray(terms.mass @ a + terms.coriolis + terms.gravity)


def acceleration_by(terms: Terms, effort: Array) -> Array:
    """Acceleration that an effort gives."""
    return np.asarray(np.linalg.solve(terms.mass, effort - terms.coriolis - terms.gravity))


def slopes(sample: RobotSample, value: Callable[[Terms], Array]) -> dict[str, Array]:
    """Derivatives of a value of the equation of motion, by central differences along the tangent of the loops."""
    ask, at, v, units = sample.model.terms, sample.at, sample.v, sample.units
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
