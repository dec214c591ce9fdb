"""Kinematics of the tree on a private `pin.Data`, and the scale that makes metres and radians comparable.

Singular values of a matrix that mixes lengths and angles mean nothing until it is scaled.  Lengths are divided by the
robot's characteristic length: the mean distance between neighbouring joint frames and cut frames that are apart.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.closure import Closure, support
from cutjoint.description.model import RobotDescription


class Kinematics:
    """The model, its closure equations and one workspace (`data`) that nobody else sees."""

    def __init__(self, model: pin.Model, description: RobotDescription, trusted: Array | None = None) -> None:
        self.model = model
        self.data = model.createData()
        self.closure = Closure(model, description, trusted)
        self.length = characteristic_length(model, self.closure)
        self._first_axes = [
            (int(model.idx_vs[joint]), support(model, model.parents[joint]))
            for joint in range(1, model.njoints)
            if model.joints[joint].shortname() == "JointModelUniversal"
        ]
        self.row_scale = np.where(self.closure.is_length, 1.0 / self.length, 1.0)
        self.column_scale = velocity_scale(model, self.length)

    def update(self, q: Array) -> None:
        """Placements and joint Jacobians at `q`."""
        pin.computeJointJacobians(self.model, self.data, q)

    def update_rates(self, q: Array, v: Array) -> None:
        """Placements, joint Jacobians and their time derivatives at `q` (nq,) and `v` (nv,).

        Pinocchio 4.1 leaves out that the first axis of a universal joint turns with the parent alone; that column is
        set right here.
        """
        pin.computeJointJacobiansTimeVariation(self.model, self.data, q, v)
        for column, below in self._first_axes:
            axis = self.data.J[:, column]
            carrier = self.data.J @ (below * v)
            w, u = carrier[3:], carrier[:3]
            self.data.dJ[:3, column] = np.cross(w, axis[:3]) + np.cross(u, axis[3:])
            self.data.dJ[3:, column] = np.cross(w, axis[3:])

    def integrate(self, q: Array, motion: Array) -> Array:
        """Configuration after the tangent motion (nv,), on the manifold."""
        return np.asarray(pin.integrate(self.model, q, motion))

    def scaled_jacobian(self) -> Array:
        """Constraint Jacobian at the updated configuration, dimensionless, shape (rows, nv)."""
        scaled: Array = self.row_scale[:, None] * self.closure.jacobian(self.data) * self.column_scale
        return scaled

    def gap(self, q: Array) -> tuple[float, float, str]:
        """Worst distance [m] and angle [rad] of any cut at the updated configuration, and the name of the worst cut."""
        gaps = self.closure.gaps(self.data, q)
        if not gaps:
            return 0.0, 0.0, ""
        worst = max(gaps, key=lambda gap: gap[1] / self.length + gap[2])
        return max(gap[1] for gap in gaps), max(gap[2] for gap in gaps), worst[0]


class ToolPoint:
    """Kinematics of a frame fixed to a joint: position, pose error and Jacobians in world axes."""

    def __init__(self, model: pin.Model, joint: int, placement: pin.SE3) -> None:
        self.joint, self.placement = joint, placement
        self._support = support(model, joint)

    def pose(self, data: pin.Data) -> pin.SE3:
        """World placement."""
        return data.oMi[self.joint] * self.placement

    def jacobian(self, data: pin.Data) -> Array:
        """Linear velocity of the point and angular velocity of the body per velocity, shape (6, nv)."""
        twist = np.asarray(data.J) * self._support
        x, y, z = self.pose(data).translation
        w = twist[3:]
        linear = twist[:3] + np.stack([w[1] * z - w[2] * y, w[2] * x - w[0] * z, w[0] * y - w[1] * x])
        return np.concatenate([linear, w])

    def drift(self, data: pin.Data, v: Array) -> Array:
        """Classical acceleration of the point with zero joint accelerations, shape (3,) [m/s2]; needs `data.dJ`."""
        masked = self._support * v
        twist, rate = np.asarray(data.J) @ masked, np.asarray(data.dJ) @ masked
        at = self.pose(data).translation
        velocity = twist[:3] + np.cross(twist[3:], at)
        classical: Array = rate[:3] + np.cross(rate[3:], at) + np.cross(twist[3:], velocity)
        return classical


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


def characteristic_length(model: pin.Model, closure: Closure) -> float:
    """Mean distance [m] between neighbouring joint and cut frames that are apart; 1 where all coincide."""
    distances = [float(np.linalg.norm(placement.translation)) for placement in list(model.jointPlacements)[1:]]
    for cut in closure.cuts:
        distances += [float(np.linalg.norm(place.translation)) for place in (cut.placement_a, cut.placement_b)]
    apart = [distance for distance in distances if distance > 1e-9]
    return float(np.mean(apart)) if apart else 1.0
