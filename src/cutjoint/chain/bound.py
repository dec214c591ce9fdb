"""Cut joints and couplings bound to a model: joint indices and placements in place of the names of links and joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.build import bind_frame
from cutjoint.chain.joints import support, type_of
from cutjoint.description.model import Coupling, CutJoint, CutType


@dataclass(frozen=True, eq=False)
class BoundCut:
    """A cut joint: the joints that carry its frames, the frames in them, and what moves these, shape (nv,) each."""

    name: str
    type: CutType
    joint_a: int
    placement_a: pin.SE3
    joint_b: int
    placement_b: pin.SE3
    support_a: Array
    support_b: Array

    @staticmethod
    def of(model: pin.Model, cut: CutJoint) -> BoundCut:
        """A cut of the description that the model was built from."""
        (joint_a, placement_a), (joint_b, placement_b) = bind_frame(model, cut.a), bind_frame(model, cut.b)
        supports = support(model, joint_a), support(model, joint_b)
        return BoundCut(cut.name, cut.type, joint_a, placement_a, joint_b, placement_b, *supports)

    @property
    def sides(self) -> tuple[tuple[int, pin.SE3], tuple[int, pin.SE3]]:
        """Joint and placement in it of both frames."""
        return (self.joint_a, self.placement_a), (self.joint_b, self.placement_b)


@dataclass(frozen=True)
class BoundCoupling:
    """A coupling: the weighted sum of coordinates of the tree, plus a constant, is zero.

    Attributes:
        q_index, v_index: of the coordinates in a configuration, and of their velocities.
        weights: of each.
        constant: [m] or [rad].
        is_length: whether the sum is a length; it is measured like the first coordinate.
    """

    name: str
    q_index: tuple[int, ...]
    v_index: tuple[int, ...]
    weights: tuple[float, ...]
    constant: float
    is_length: bool

    @staticmethod
    def of(model: pin.Model, coupling: Coupling) -> BoundCoupling:
        """A coupling of the description that the model was built from."""
        joints = [model.getJointId(name) for name in coupling.weights]
        return BoundCoupling(
            coupling.name,
            tuple(int(model.idx_qs[joint]) for joint in joints),
            tuple(int(model.idx_vs[joint]) for joint in joints),
            tuple(coupling.weights.values()),
            coupling.constant,
            type_of(model, joints[0]).slides,
        )

    def residual(self, q: Array) -> float:
        """What the sum is at a configuration (nq,), [m] or [rad]."""
        return float(sum(w * q[i] for w, i in zip(self.weights, self.q_index, strict=True)) + self.constant)

    def row(self, nv: int) -> Array:
        """Its derivative, shape (nv,)."""
        row = np.zeros(nv)
        np.add.at(row, list(self.v_index), self.weights)
        return row
