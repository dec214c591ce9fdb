"""Constrained dynamics by Pinocchio itself, of robots whose cuts are all contacts (`cutjoint.chain.contacts`)."""

from __future__ import annotations

import threading
from math import inf

import numpy as np
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closure import Closure
from cutjoint.chain.contacts import constraint_datas, contact_models, is_contact
from cutjoint.chain.kinematics import Kinematics

ITERATIONS = 4
CONVERGED_SQUARED = tolerances.CONVERGED.value**2

HARDLY = 1e-6
"""Rows that are smaller than this, dimensionless, or that yield less than this part of the others hardly move."""


def is_rigid(closure: Closure) -> bool:
    """Whether Pinocchio has constraint models for all of a robot's cuts (and there are cuts)."""
    whole = bool(closure.cuts) and not closure.couplings and not closure.left_out
    return whole and all(is_contact(cut) for cut in closure.cuts)


class RigidScratch(threading.local):
    """What `pin.constraintDynamics` writes into; every thread makes its own."""

    def __init__(self, model: pin.Model, models: pin.StdVec_RigidConstraintModel, regularisation: float) -> None:
        self.data, self.datas = model.createData(), constraint_datas(models)
        pin.initConstraintDynamics(model, self.data, models, self.datas)
        # no accuracy at which to stop: Pinocchio's relative one means another thing for every mass
        self.settings = pin.ProximalSettings(0.0, 0.0, regularisation, ITERATIONS)


class RigidConstraints:
    """Pinocchio's constraint models of the cuts; `q`, shape (nq,), is a closed configuration."""

    def __init__(self, kinematics: Kinematics, q: Array) -> None:
        model = kinematics.model
        self._model, self._tree = model, kinematics.tree
        length = kinematics.length
        self._scale = 1.0 / kinematics.column_scale
        self._floor = (1e-13 * float(np.linalg.norm(model.gravity.linear)) / length) ** 2
        self.models = contact_models(model, kinematics.closure.cuts, length)
        sizes = [constraint.residualSize() for constraint in self.models]
        self._row_scale = np.concatenate([np.where(np.arange(size) < 3, 1.0 / length, 1.0) for size in sizes])
        # relative accuracy, so that a robot of grams and one of tonnes are solved alike
        self._regularisation = tolerances.REGULARISATION.value * self._compliance(q)
        self.workspace = RigidScratch(model, self.models, self._regularisation)

    @property
    def usable(self) -> bool:
        """Whether its rows do anything: those of a hinge beside a hinge are rounding alone."""
        return self._regularisation > 0.0

    def acceleration(self, q: Array, v: Array, effort: Array) -> Array | None:
        """`pin.constraintDynamics`: acceleration of all joints (nv,); None where its iteration did not converge: what
        it leaves of K a + gamma is looked at, in its own rows."""
        own = self.workspace
        effort = effort + self._tree.held_up.lift(q)
        found = pin.constraintDynamics(self._model, own.data, q, v, effort, self.models, own.datas, own.settings)
        rows = pin.getConstraintsJacobian(self._model, own.data, self.models, own.datas)
        moved = rows.reshape(-1, self._model.nv).dot(found)  # one column comes as a vector
        wanted = own.data.primal_rhs_contact * self._row_scale
        left = moved * self._row_scale - wanted
        scaled = found * self._scale
        allowed = CONVERGED_SQUARED * (scaled.dot(scaled) + wanted.dot(wanted)) + self._floor
        return np.asarray(found) if left.dot(left) <= allowed < inf else None  # None for a NaN too

    def _compliance(self, q: Array) -> float:
        """Smallest acceleration that a unit force on a row causes at that row, at `q` (nq,); 0 where no row does
        anything.

        Rows that hardly move are left out: those of a planar robot that point out of its plane.
        """
        model, data, datas = self._model, self._model.createData(), constraint_datas(self.models)
        pin.computeJointJacobians(model, data, q)
        for constraint, one in zip(self.models, datas, strict=True):
            constraint.calc(model, data, one)
        jacobian = np.reshape(pin.getConstraintsJacobian(model, data, self.models, datas), (-1, model.nv))
        try:
            moved = np.linalg.solve(self._tree.mass_matrix(q), jacobian.T)
        except np.linalg.LinAlgError:
            return 0.0
        moves = np.linalg.norm(self._row_scale[:, None] * jacobian / self._scale, axis=1) > HARDLY
        own = np.einsum("ij,ji->i", jacobian, moved)[moves]
        largest = float(own.max(initial=0.0))
        return float(own[own > HARDLY * largest].min()) if np.isfinite(own).all() and largest > 0.0 else 0.0
