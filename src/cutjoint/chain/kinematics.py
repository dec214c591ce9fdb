"""Kinematics of the tree at one configuration, as values, and the scale that makes metres and radians comparable.

`Kinematics.at(q)` and `.moving(q, v)` are the one place that reads Pinocchio's workspace: what they return holds its
own arrays and never changes.  Every thread has a workspace of its own, so a robot can be shared between threads.

Singular values of a matrix that mixes lengths and angles mean nothing until it is scaled.  Lengths are divided by the
robot's characteristic length: the mean distance between neighbouring joint frames and cut frames that are apart.

A fixed base far from the world origin would cost digits in every product, so the model that is computed with stands
near the robot (`origin`); positions are given back in the world by the chain.
"""

from __future__ import annotations

import threading
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array, readonly
from cutjoint.chain.build import build_model
from cutjoint.chain.closure import Closure, Cut, CutFrames, bind_frame, support
from cutjoint.description.model import RobotDescription
from cutjoint.errors import InputError

FAR = 10.0
"""Distance of a fixed base from the world origin, in characteristic lengths, beyond which it is taken out."""


class Placed:
    """The tree at one configuration.

    Attributes:
        q: configuration, shape (nq,).
        twists: joint Jacobians about the origin in its axes, shape (6, nv).
        frames: of the cuts.
    """

    def __init__(self, kinematics: Kinematics, q: Array, placements: Array, twists: Array) -> None:
        k = self._k = kinematics
        self.q, self.twists = q, twists
        count = len(k.closure.cuts)
        axes, at = placements[:, :3, :3], placements[:, :3, 3]
        self.frames = CutFrames(axes[:count], axes[count : 2 * count], at[:count], at[count : 2 * count])
        self._tool_axes: Array = axes[-1]
        self._tool_at: Array = at[-1]

    @cached_property
    def gather(self) -> Array:
        """G of `cutjoint.chain.closure`, shape (cut rows, 12 cuts)."""
        return self._k.closure.gather(self.frames)

    @cached_property
    def jacobian(self) -> Array:
        """Of all rows, [m] and [rad] per velocity, shape (rows, nv)."""
        return self._k.closure.jacobian(self.gather, self.twists)

    @cached_property
    def scaled(self) -> Array:
        """The same, dimensionless."""
        return np.asarray(self.jacobian * self._k.scale)

    @cached_property
    def residual_of_all(self) -> Array:
        """Residual of all rows, also of those that are left out, [m] and [rad]."""
        return self._k.closure.residual(self.frames, self.q)

    @property
    def residual(self) -> Array:
        """Residual of the rows, shape (rows,), [m] and [rad]."""
        return self._k.closure.kept(self.residual_of_all)

    @property
    def gap(self) -> tuple[float, float, str]:
        """Worst distance [m] and angle [rad] of any cut, and the name of the worst cut."""
        lengths, angles = self._k.closure.gaps(self.residual_of_all)
        if not len(lengths):
            return 0.0, 0.0, ""
        worst = int(np.argmax(lengths / self._k.length + angles))
        return float(lengths.max()), float(angles.max()), self._k.closure.names[worst]

    @property
    def tool(self) -> pin.SE3:
        """Placement of the tool frame in the model, away from the world by its origin."""
        return pin.SE3(self._tool_axes, self._tool_at)

    @property
    def tool_position(self) -> Array:
        """Of the tool point in the model, shape (3,) [m]."""
        return self._tool_at

    @property
    def tool_jacobian(self) -> Array:
        """Linear velocity of the tool point and angular velocity of its body per velocity, shape (6, nv)."""
        assert self._k.tool_support is not None
        x, y, z = self._tool_at.tolist()
        shift = _UNIT.copy()
        shift[0, 4], shift[0, 5], shift[1, 5] = z, -y, x
        shift[1, 3], shift[2, 3], shift[2, 4] = -z, y, -x
        return np.asarray(shift.dot(self.twists * self._k.tool_support))


_UNIT = np.eye(6)


class Moving(Placed):
    """The tree at one configuration and velocity.

    Attributes:
        v: velocity, shape (nv,).
        rates: time derivatives of the joint Jacobians, shape (6, nv).
    """

    def __init__(
        self, kinematics: Kinematics, q: Array, v: Array, placements: Array, twists: Array, rates: Array
    ) -> None:
        super().__init__(kinematics, q, placements, twists)
        self.v, self.rates = v, rates

    @property
    def drift(self) -> Array:
        """Time derivative of the constraint Jacobian times v, shape (rows,), [m/s2] and [rad/s2]."""
        return self._k.closure.drift(self.frames, self.gather, self.twists, self.rates, self.v)

    @property
    def tool_drift(self) -> Array:
        """Classical acceleration of the tool point with zero joint accelerations, shape (3,) [m/s2]."""
        assert self._k.tool_support is not None
        masked = self._k.tool_support * self.v
        twist, rate = self.twists @ masked, self.rates @ masked
        velocity = twist[:3] + np.cross(twist[3:], self._tool_at)
        classical: Array = rate[:3] + np.cross(rate[3:], self._tool_at) + np.cross(twist[3:], velocity)
        return classical


class Kinematics:
    """The model of a robot that is computed with, its closure equations and its scales.

    Attributes:
        model: the open tree, standing near the origin.
        origin: where the model's origin is in the world, shape (3,) [m].
        length: characteristic length [m].
        reach: longest way along the tree's and the cuts' frames [m], the size of the robot.
        tool_joint: the joint that moves the tool's body, 0 for the base.
        tool_support: 1 for every velocity that moves the tool, shape (nv,); None where there is no tool.
        row_scale, column_scale: factors per row and per velocity that make the constraint Jacobian dimensionless.
        scales: what systems of equations have in common, by the kind of their driver; filled as they are met.
        travels: whether bodies of it may be anywhere.
        rounded: distance [m] to which a point in the world is rounded, where the base stands far from its origin.
        closed_length: distance [m] below which a cut counts as closed; `tolerances.CLOSURE` is the same for angles.
    """

    def __init__(self, description: RobotDescription, trusted: Array | None = None) -> None:
        model = build_model(description)
        centre, far = _base(model, Closure(model, description))
        self.origin = readonly(centre if far else np.zeros(3))
        self.model = build_model(description, self.origin) if far else model
        self.rounded = float(np.spacing(np.abs(self.origin).max())) if far else 0.0
        self.description = description
        self.closure = Closure(self.model, description, trusted)
        self.length, self.reach = characteristic_length(self.model, self.closure, description)
        joints = [cut.joint_a for cut in self.closure.cuts] + [cut.joint_b for cut in self.closure.cuts]
        places = [cut.placement_a for cut in self.closure.cuts] + [cut.placement_b for cut in self.closure.cuts]
        self.tool_support: Array | None = None
        if description.tool is not None:
            joint, placement = bind_frame(self.model, description.tool)
            self.tool_support = support(self.model, joint)
        else:
            joint, placement = 0, pin.SE3.Identity()
        self.tool_joint = joint
        self._joints = sorted({*joints, joint})
        self._frame_joint = np.array([self._joints.index(j) for j in [*joints, joint]])
        self._frame_place = np.array([place.homogeneous for place in [*places, placement]])
        self._first_axes = [
            (int(self.model.idx_vs[joint]), support(self.model, self.model.parents[joint]))
            for joint in range(1, self.model.njoints)
            if self.model.joints[joint].shortname() == "JointModelUniversal"
        ]
        self._travelling = _travelling(self.model)
        self.travels = bool(len(self._travelling))
        self.closed_length = tolerances.CLOSURE.value * self.reach
        self._furthest = 0.1 * tolerances.RANK.value * self.length / float(np.finfo(float).eps)
        self.row_scale = np.where(self.closure.is_length, 1.0 / self.length, 1.0)
        self.column_scale = velocity_scale(self.model, self.length)
        self.scale = self.row_scale[:, None] * self.column_scale
        self._own = threading.local()
        self.scales: dict[object, Any] = {}

    @property
    def data(self) -> pin.Data:
        """Pinocchio's workspace of this thread."""
        try:
            return self._own.data
        except AttributeError:
            self._own.data = self.model.createData()
            return self._own.data

    def at(self, q: Array) -> Placed:
        """The tree at `q`, shape (nq,)."""
        self._refuse_far(q)
        data = self.data
        pin.computeJointJacobians(self.model, data, q)
        return Placed(self, q, self._placements(data), self.twists(data))

    def moving(self, q: Array, v: Array) -> Moving:
        """The tree at `q` (nq,) and `v` (nv,)."""
        self._refuse_far(q)
        data = self.data
        rates = self.rates(data, q, v)
        return Moving(self, q, v, self._placements(data), self.twists(data), rates)

    def rates(self, data: pin.Data, q: Array, v: Array) -> Array:
        """Time derivatives of the joint Jacobians, shape (6, nv); `twists` are the Jacobians then.

        Pinocchio 4.1 leaves out that the first axis of a universal joint turns with the parent alone; that column is
        set right here.
        """
        pin.computeJointJacobiansTimeVariation(self.model, data, q, v)
        rates = self._matrix(data.dJ)
        if self._first_axes:
            twists = self.twists(data)
            for column, below in self._first_axes:
                axis = twists[:, column]
                carrier = twists @ (below * v)
                w, u = carrier[3:], carrier[:3]
                rates[:3, column] = np.cross(w, axis[:3]) + np.cross(u, axis[3:])
                rates[3:, column] = np.cross(w, axis[3:])
        return rates

    def twists(self, data: pin.Data) -> Array:
        """The joint Jacobians of the last call of Pinocchio that made them, shape (6, nv)."""
        return self._matrix(data.J)

    def mass(self, q: Array) -> Array:
        """Mass matrix of the tree, symmetric, shape (nv, nv)."""
        upper = np.triu(np.reshape(pin.crba(self.model, self.data, q), (self.model.nv, self.model.nv)))
        return np.asarray(upper + np.triu(upper, 1).T)

    def forces(self, q: Array, v: Array, a: Array) -> Array:
        """Generalised forces that make the tree move so: M a + C v + g, shape (nv,)."""
        return np.array(pin.rnea(self.model, self.data, q, v, a))

    def load(self, mass: Array, v: Array, a: Array) -> float:
        """How large the loads of a motion are that inverse dynamics adds up, dimensionless in the motions: what its
        rounding is relative to.

        Args:
            mass: mass matrix, dimensionless in the motions, shape (nv, nv).
            v, a: velocity and acceleration, shape (nv,).
        """
        speed = float(np.abs(v / self.column_scale).max(initial=0.0))
        change = float(np.abs(a / self.column_scale).max(initial=0.0))
        weight = float(sum(inertia.mass for inertia in list(self.model.inertias)[1:])) * self.length
        pull = float(np.linalg.norm(self.model.gravity.linear))
        return float(np.abs(mass).max(initial=0.0)) * (speed**2 + change) + weight * pull

    def gravity(self, q: Array) -> Array:
        """Generalised gravity, shape (nv,)."""
        return np.array(pin.computeGeneralizedGravity(self.model, self.data, q))

    def bodies(self, q: Array) -> tuple[Array, Array]:
        """Axes (joints + 1, 3, 3) and origins (joints + 1, 3) of all joints' bodies in the model, the base first."""
        pin.forwardKinematics(self.model, self.data, q)
        placed = np.array([placement.homogeneous for placement in self.data.oMi])
        return placed[:, :3, :3], placed[:, :3, 3]

    def integrate(self, q: Array, motion: Array) -> Array:
        """Configuration after the tangent motion (nv,), on the manifold."""
        return np.asarray(pin.integrate(self.model, q, motion))

    def closed_within(self, q: Array) -> float:
        """Distance [m] below which a cut counts as closed at `q`: bodies that travel far from the origin are rounded to
        their distance from it.  For angles it is `tolerances.CLOSURE`."""
        if not self.travels:
            return self.closed_length
        return self.closed_length + tolerances.CLOSURE.value * float(np.abs(q[self._travelling]).max())

    def _refuse_far(self, q: Array) -> None:
        """Bodies so far away that the rounding of their place is not small against RANK have no rank.

        Raises:
            InputError: `q` (nq,) has one.
        """
        if self.travels and (far := float(np.abs(q[self._travelling]).max())) > self._furthest:
            raise InputError(
                f"{self.description.name} is {far:.3g} m from where its coordinates count from, where positions are "
                f"rounded to {np.spacing(far):.2g} m: too coarse for a robot whose links are {self.length:.3g} m long; "
                f"keep it within {self._furthest:.2g} m"
            )

    def _placements(self, data: pin.Data) -> Array:
        """Placements of the frames a and b of all cuts and of the tool, shape (frames, 4, 4)."""
        placed = data.oMi
        joints = np.array([placed[joint].homogeneous for joint in self._joints])
        found: Array = joints.take(self._frame_joint, 0) @ self._frame_place
        return found

    def _matrix(self, values: Array) -> Array:
        """A copy of a matrix (6, nv) of Pinocchio's, which hands it back as (6,) where nv is 1."""
        return np.array(values).reshape(6, self.model.nv)


def velocity_scale(model: pin.Model, length: float) -> Array:
    """Factor per velocity coordinate that turns dimensionless rates into [m/s] or [rad/s], shape (nv,)."""
    scale = np.ones(model.nv)
    for joint in range(1, model.njoints):
        name, start, count = model.joints[joint].shortname(), model.idx_vs[joint], model.nvs[joint]
        if name.startswith("JointModelP") and name != "JointModelPlanar":
            scale[start] = length
        elif name == "JointModelFreeFlyer":
            scale[start : start + 3] = length
        elif name == "JointModelPlanar":
            scale[start : start + 2] = length
        elif name == "JointModelTranslation":
            scale[start : start + count] = length
    scale.setflags(write=False)
    return scale


def characteristic_length(model: pin.Model, closure: Closure, description: RobotDescription) -> tuple[float, float]:
    """Mean distance [m] between neighbouring joint and cut frames that are apart, and the longest way along them from
    the base to a frame.

    Frames that the base carries count from their middle; what flies is where it is, so the place of its joint does not
    count.  A robot whose frames all coincide is measured by its tool or its centres of mass; 1 where those are there
    too.
    """
    middle, _ = _base(model, closure)
    way = np.zeros(model.njoints)
    distances: list[float] = []

    def step(parent: int, place: Array) -> float:
        distances.append(float(np.linalg.norm(place - middle if parent == 0 else place)))
        return float(way[parent]) + distances[-1]

    for joint in range(1, model.njoints):
        if not _flies(model, joint):
            way[joint] = step(model.parents[joint], model.jointPlacements[joint].translation)
    ends = [step(cut.joint_a, cut.placement_a.translation) for cut in closure.cuts]
    ends += [step(cut.joint_b, cut.placement_b.translation) for cut in closure.cuts]
    if not max(distances, default=0.0) > 0.0:
        if description.tool is not None:
            joint, place = bind_frame(model, description.tool)
            distances.append(float(np.linalg.norm(place.translation)) if joint else 0.0)
        distances += [float(np.linalg.norm(inertia.lever)) for inertia in list(model.inertias)[1:] if inertia.mass > 0]
    longest = max(distances, default=0.0)
    apart = [distance for distance in distances if distance > 1e-9 * longest]
    length = float(np.mean(apart)) if apart else 1.0
    return length, max(float(way.max(initial=0.0)), max(ends, default=0.0), length)


def joints_of(model: pin.Model, motions: Array) -> tuple[str, ...]:
    """Names of the joints that take part in any of the dimensionless motions, shape (nv, k)."""
    moving = np.abs(motions).max(axis=1, initial=0.0) > 1e-6
    return tuple(
        model.names[joint]
        for joint in range(1, model.njoints)
        if moving[model.idx_vs[joint] : model.idx_vs[joint] + model.nvs[joint]].any()
    )


def _flies(model: pin.Model, joint: int) -> bool:
    """Whether a joint lets a body fly from the base."""
    return bool(model.parents[joint] == 0 and model.joints[joint].shortname() == "JointModelFreeFlyer")


def _base(model: pin.Model, closure: Closure) -> tuple[Array, bool]:
    """Middle of all frames that the base carries, shape (3,) [m], and whether that is far from the world origin."""
    first = [j for j in range(1, model.njoints) if model.parents[j] == 0]
    carried = [np.array(model.jointPlacements[joint].translation) for joint in first if not _flies(model, joint)]
    for cut in closure.cuts:
        carried += [np.array(place.translation) for place in _on_base(cut)]
    if not carried:
        return np.zeros(3), False
    middle = np.mean(carried, axis=0)
    spread = max(float(np.linalg.norm(place - middle)) for place in carried)
    others = [np.linalg.norm(model.jointPlacements[j].translation) for j in range(1, model.njoints) if j not in first]
    size = max([spread, *map(float, others)])
    for inertia in list(model.inertias)[1:]:
        size = max(size, float(np.linalg.norm(inertia.lever)))
    return middle, float(np.linalg.norm(middle)) > FAR * size


def _on_base(cut: Cut) -> list[pin.SE3]:
    sides = ((cut.joint_a, cut.placement_a), (cut.joint_b, cut.placement_b))
    return [place for joint, place in sides if joint == 0]


def _travelling(model: pin.Model) -> Array:
    """Indices in q of the positions of free bodies, which may be anywhere."""
    found: list[int] = []
    for joint in range(1, model.njoints):
        name, start = model.joints[joint].shortname(), model.idx_qs[joint]
        if name == "JointModelFreeFlyer":
            found += range(start, start + 3)
        elif name == "JointModelPlanar":
            found += range(start, start + 2)
    return np.array(found, dtype=int)
