"""A closed chain at one state, by Pinocchio and the singular values of its loops; see
`cutjoint.compile.functions.sample`."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.dynamics import Motions
from cutjoint.chain.rank import null_space
from cutjoint.chain.tree import TreeModel
from cutjoint.compile.functions.sample import (
    DIFFERENCE,
    FURTHER,
    MOST_BUILT,
    RobotSample,
    RobotUnits,
    goal_of,
    twist_of,
)
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.description.model import CutType, JointType, RobotDescription
from cutjoint.mechanism import Pose, Posture

ASIDE = 1e-6
"""How far away the goal of a step of Newton's method is, in the robot's units."""
FORGIVEN = 1e-4
"""Part of the strength of springs and dampers that counts as a force: what the rounding of a place makes of them."""


# long: a property a quantity that something is compared with
class ChainSample(RobotSample):
    """A closed chain at one state, of which all joints are known; where it is built anew with other values of its
    parameters, `traced` is what the function was made from, whose origin and scales are in it."""

    def __init__(
        self,
        source: ChainSource,
        units: RobotUnits,
        at: Posture,
        chance: np.random.Generator,
        traced: ChainSource | None = None,
    ) -> None:
        own = source if traced is None else traced
        self.origin, self.position_scale = own.chain.origin, own.position_scale
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
        effort = energy * chance.normal(size=source.nv)
        mass = scale[:, None] * TreeModel(source.model).mass_matrix(self.q) * scale
        massless = Motions.of(motions, mass).massless  # a force on what moves no mass has no answer
        self.effort_full = np.asarray((effort - massless @ (massless.T @ effort)) / scale)

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
                found = [twist_of(one, self.tool.rotation) for one in found]
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

    def q_rate(self, v_full: Array) -> Array:
        step = DIFFERENCE / self.units.rate
        ahead, behind = (pin.integrate(self.source.model, self.q, s * v_full) for s in (step, -step))
        return np.asarray((ahead - behind) / (2.0 * step))

    @property
    def lost_full(self) -> Array:
        return np.array([self.chain.full_dissipation(self.at, self.v_full)])

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
            "size": np.array([np.abs((q_next - self.q) / self.position_scale).max()]),
            "gap": np.array([np.abs(missed / scale).max()]),
        }

    def aside(self, k: int, step: float) -> Posture:
        return self.chain.assemble(pin.integrate(self.source.model, self.q, step * self.tangent[:, k]))

    @cached_property
    def weight(self) -> float:
        return self.mass * float(np.linalg.norm(self.source.model.gravity.linear)) * self.units.length

    @cached_property
    def held(self) -> float:
        stiff, _ = strength(self.chain.description, self.units.length)
        return super().held + FORGIVEN * stiff * self._reach**2

    @cached_property
    def rubbed(self) -> float:
        _, steep = strength(self.chain.description, self.units.length)
        return super().rubbed + FORGIVEN * steep * self.units.rate * self._reach**2

    @property
    def _reach(self) -> float:
        """How far the joints move for a motor, dimensionless."""
        unit = self.units.coordinate
        return float(np.abs(self.tangent * unit / self.axes["u"][:, None]).max(initial=1.0))

    @property
    def smooth(self) -> bool:
        step, model = 10.0 * DIFFERENCE * self._reach, self.source.model
        u, scale = np.abs(self.tangent @ self.v), self.axes["u"]
        for joint in range(1, model.njoints):
            one = self.chain.description.joint(model.names[joint])
            rates = slice(model.idx_vs[joint], model.idx_vs[joint] + model.nvs[joint])
            if one.physics.friction:
                faster = step * self.units.rate * float(scale[rates].max())
                if not (one.physics.speed > 1e2 * faster or u[rates].min() > one.physics.speed + faster):
                    return False
            if one.physics.stop_stiffness:
                at, near = self.q[model.idx_qs[joint]], step * scale[rates].max()
                limits = (model.lowerPositionLimit, model.upperPositionLimit)
                if any(abs(at - limit[model.idx_qs[joint]]) < near for limit in limits):
                    return False
        return not any(cut.physics.friction for cut in self.chain.description.closing)


def strength(description: RobotDescription, length: float) -> tuple[float, float]:
    """How stiff all springs, bushings and stops are together [J], and how steep all dampers and friction [J s]."""
    stiff = steep = 0.0
    joints = [(one.physics, one.type is JointType.PRISMATIC) for one in description.joints]
    cuts = [(one.physics, one.type is CutType.PRISMATIC) for one in description.cuts]
    for physics, slides in (*joints, *cuts):
        unit = length**2 if slides else 1.0
        stiff += unit * (physics.stiffness + physics.stop_stiffness)
        rubbing = physics.friction / physics.speed if physics.friction and physics.speed else 0.0
        steep += unit * (physics.damping + physics.stop_damping + 2.0 * rubbing)
    for bushing in (cut.bushing for cut in description.cuts if cut.bushing is not None):
        stiff += length**2 * bushing.stiffness + bushing.turning_stiffness
        steep += length**2 * bushing.damping + bushing.turning_damping
    return stiff, steep
