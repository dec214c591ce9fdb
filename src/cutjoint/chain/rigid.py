"""Fixed, spherical and revolute cuts as Pinocchio's `RigidConstraintModel`s.

A revolute cut is two coincident points on its axis: six rows of rank five.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array, readonly
from cutjoint.chain.closure import Closure, Cut
from cutjoint.description.model import CutType

_RIGID = (CutType.FIXED, CutType.SPHERICAL, CutType.REVOLUTE)


def is_rigid(closure: Closure) -> bool:
    """Whether Pinocchio has constraint models for all of a robot's cuts (and there are cuts)."""
    whole = bool(closure.cuts) and not closure.ratios and not closure.left_out
    return whole and all(cut.type in _RIGID for cut in closure.cuts)


@dataclass(frozen=True, eq=False)
class Wrench:
    """What body A of a cut exerts on body B: force (3,) [N], moment (3,) [N m] at the origin of frame b, world axes."""

    force: Array
    moment: Array


class RigidConstraints:
    """Pinocchio's constraint models of the cuts, with a private workspace."""

    def __init__(self, model: pin.Model, cuts: tuple[Cut, ...], length: float) -> None:
        self._model, self._cuts = model, cuts
        self._arm = 0.5 * length
        self.models = pin.StdVec_RigidConstraintModel()
        for cut in cuts:
            kind = pin.ContactType.CONTACT_6D if cut.type is CutType.FIXED else pin.ContactType.CONTACT_3D
            for shift in self._shifts(cut):
                offset = pin.SE3(np.eye(3), np.array([0.0, 0.0, shift]))
                constraint = pin.RigidConstraintModel(
                    kind,
                    model,
                    cut.joint_a,
                    cut.placement_a * offset,
                    cut.joint_b,
                    cut.placement_b * offset,
                    pin.ReferenceFrame.LOCAL,
                )
                constraint.name = cut.name
                self.models.append(constraint)
        self.datas = pin.StdVec_RigidConstraintData()
        for constraint in self.models:
            self.datas.append(constraint.createData())
        self.data = model.createData()
        pin.initConstraintDynamics(model, self.data, self.models, self.datas)
        self.is_length = np.array(
            [row < 3 for constraint in self.models for row in range(constraint.residualSize())], dtype=bool
        )
        sizes = [constraint.residualSize() for constraint in self.models]
        starts = np.concatenate([[0], np.cumsum(sizes)[:-1]]).tolist()
        # the method, the data, the first row and whether the rotation is locked too, looked up once
        self._each = [
            (constraint.calc, data, row, size == 6)
            for constraint, data, row, size in zip(self.models, self.datas, starts, sizes, strict=True)
        ]
        # relative accuracy, so that a robot of grams and one of tonnes are solved alike
        self._settings = pin.ProximalSettings(0.0, 1e-10, tolerances.REGULARISATION.value * self._compliance(), 6)

    def _compliance(self) -> float:
        """Smallest acceleration that a unit force on a row causes at that row, at the neutral posture.

        Rows that hardly move are left out: those of a planar robot that point out of its plane.
        """
        neutral = pin.neutral(self._model)
        self.update(neutral)
        jacobian = self.jacobian()
        mass = np.triu(pin.crba(self._model, self.data, neutral))
        try:
            moved = np.linalg.solve(mass + np.triu(mass, 1).T, jacobian.T)
        except np.linalg.LinAlgError:
            return 1.0
        own = np.einsum("ij,ji->i", jacobian, moved)
        largest = float(own.max(initial=0.0))
        return float(own[own > 1e-6 * largest].min()) if np.isfinite(own).all() and largest > 0.0 else 1.0

    def _shifts(self, cut: Cut) -> tuple[float, ...]:
        return (-self._arm, self._arm) if cut.type is CutType.REVOLUTE else (0.0,)

    def acceleration(self, q: Array, v: Array, effort: Array) -> Array:
        """`pin.constraintDynamics`: acceleration of all joints, shape (nv,)."""
        found = pin.constraintDynamics(self._model, self.data, q, v, effort, self.models, self.datas, self._settings)
        return np.array(found)

    def unmet(self, acceleration: Array) -> tuple[float, float]:
        """Norm of K a + gamma, and of the larger of its terms, with K and gamma of the last `acceleration` call."""
        moved = np.asarray(pin.getConstraintsJacobian(self._model, self.data, self.models, self.datas)) @ acceleration
        drift = np.empty(len(moved))
        for _, data, row, locked in self._each:
            apart = data.contact1_acceleration_drift.vector - data.contact2_acceleration_drift.vector
            drift[row : row + (6 if locked else 3)] = apart if locked else apart[:3]
        left = moved + drift
        size = max(moved.dot(moved), drift.dot(drift))
        return sqrt(left.dot(left)), sqrt(size)

    def update(self, q: Array) -> None:
        """Placements, joint Jacobians and constraint frames at `q` (nq,), for `jacobian` and `residual`."""
        pin.computeJointJacobians(self._model, self.data, q)
        for calc, data, _, _ in self._each:
            calc(self._model, self.data, data)

    def jacobian(self) -> Array:
        """Pinocchio's constraint Jacobian at the updated configuration, shape (rows, nv), in the frames a."""
        return np.asarray(pin.getConstraintsJacobian(self._model, self.data, self.models, self.datas))

    def residual(self) -> Array:
        """What the Jacobian is the derivative of at a closed configuration, shape (rows,), [m] and [rad]."""
        residual = np.empty(len(self.is_length))
        for _, data, row, locked in self._each:
            apart = data.c1Mc2
            residual[row : row + 3] = -apart.translation
            if locked:
                residual[row + 3 : row + 6] = -pin.log3(apart.rotation)
        return residual

    def wrenches(self) -> dict[str, Wrench]:
        """Loop forces of the last `acceleration` call."""
        found: dict[str, Wrench] = {}
        row, index = 0, 0
        forces = np.asarray(self.data.lambda_c)
        for cut in self._cuts:
            frame = self.data.oMi[cut.joint_a] * cut.placement_a
            force, moment = np.zeros(3), np.zeros(3)
            for shift in self._shifts(cut):
                size = self.models[index].residualSize()
                push = -frame.rotation @ forces[row : row + 3]
                force += push
                moment += np.cross(shift * frame.rotation[:, 2], push)
                if size == 6:
                    moment -= frame.rotation @ forces[row + 3 : row + 6]
                row, index = row + size, index + 1
            found[cut.name] = Wrench(readonly(force), readonly(moment))
        return found
