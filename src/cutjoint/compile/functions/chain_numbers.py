"""A closed chain in numbers and actuated coordinates, by another way than the one that is compiled.

Tree by Pinocchio's recursions (crba, rnea), loops by the singular values of the chain's own constraint Jacobian, made
dimensionless with the robot's length; the drift of the loops by differences of that Jacobian along the motion.  No
expression, no order of elimination, no regrouped inertia: what agrees with this to 1e-9 was traced right.
"""

from __future__ import annotations

import threading

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.build import bind_frame
from cutjoint.chain.rank import Split
from cutjoint.compile.equations.carried import NO_MASS, joint_inertia
from cutjoint.compile.functions.sample import JointTerms
from cutjoint.compile.sources.chain import ChainSource

STENCIL = ((1, 3.0 / 4.0), (2, -3.0 / 20.0), (3, 1.0 / 60.0))
"""Weights of the central difference of order six."""
STEP = 4e-3
"""Its step, as the largest dimensionless motion of a rate: to the sixth power it is rounding."""


class ChainNumbers:
    """The numbers of one chain; `source` is the chain as it is traced, `total_mass` the mass of all that moves [kg]."""

    def __init__(self, source: ChainSource) -> None:
        source.need_all_rows()
        self.chain = source.chain
        self.model = source.model
        self._own = threading.local()
        self.rates = list(source.actuated_rates)
        self.scale, self.row_scale = source.rate_scale, source.row_scale
        self.source = source
        self.total_mass = sum(float(inertia.mass) for inertia in list(self.model.inertias)[1:])

    @property
    def data(self) -> pin.Data:
        """Pinocchio's workspace of this thread."""
        if not hasattr(self._own, "data"):
            self._own.data = self.model.createData()
        return self._own.data

    def jacobian(self, q: Array) -> Array:
        """Dimensionless constraint Jacobian, shape (rows, nv)."""
        given = np.reshape(self.chain.constraint_jacobian(q), (len(self.row_scale), self.model.nv))
        return np.asarray(self.row_scale[:, None] * given * self.scale)

    def bent(self, q: Array, v: Array) -> Array:
        """Drift of the dimensionless rows, shape (rows,)."""
        u = v / self.scale
        size = float(np.abs(u).max(initial=0.0))
        total = np.zeros(len(self.row_scale))
        if size == 0.0 or not len(total):
            return total
        h = STEP / size
        for k, weight in STENCIL:
            ahead = self.jacobian(pin.integrate(self.model, q, k * h * v))
            behind = self.jacobian(pin.integrate(self.model, q, -k * h * v))
            total += weight / h * (ahead - behind) @ u
        return total

    def mass(self, q: Array) -> Array:
        """Mass matrix of the tree, shape (nv, nv)."""
        nv = self.model.nv
        upper = np.triu(np.asarray(pin.crba(self.model, self.data, q)).reshape(nv, nv))
        return np.asarray(upper + np.triu(upper, 1).T)

    def forces(self, q: Array, v: Array, a: Array) -> Array:
        """Forces on the joints of the tree, shape (nv,)."""
        return np.array(pin.rnea(self.model, self.data, q, v, a))

    def at(self, q: Array, v: Array) -> JointTerms:
        """The chain at the closed configuration `q` (nq,) and actuated velocity `v` (n,)."""
        nv, n = self.model.nv, len(self.rates)
        passive = np.setdiff1d(np.arange(nv), self.rates)
        jacobian, mass = self.jacobian(q), self.mass(q)
        idle = self.source.idle or 0
        left, values, right = np.linalg.svd(jacobian[:, passive])
        rank = len(passive) - idle
        inverse = right[:rank].T @ (left[:, :rank].T / values[:rank, None])
        tangent = np.zeros((nv, n))
        tangent[self.rates, range(n)] = 1.0
        at_rest = self.scale[passive, None] * -inverse
        tangent[passive] = at_rest @ jacobian[:, self.rates] / self.scale[self.rates]
        spin = np.zeros((nv, idle))
        spin[passive] = self.scale[passive, None] * right[rank:].T
        pull = self._pull(spin, mass)
        tangent = tangent - spin @ pull @ mass @ tangent

        v_full, drift = tangent @ v, np.zeros(nv)
        drift[passive] = at_rest @ self.bent(q, v_full)
        drift = drift - spin @ pull @ self.forces(q, v_full, drift)
        gravity = self.forces(q, np.zeros(nv), np.zeros(nv))
        coriolis = tangent.T @ (self.forces(q, v_full, drift) - gravity)
        return JointTerms(tangent.T @ mass @ tangent, coriolis, tangent.T @ gravity, tangent, drift)

    def _pull(self, motions: Array, mass: Array) -> Array:
        """(U' M U)^+ U', without the motions that move no mass, shape (k, nv)."""
        scale, model = self.scale, self.model
        joints = [range(model.idx_vs[i], model.idx_vs[i] + model.nvs[i]) for i in range(1, model.njoints)]
        values, basis = np.linalg.eigh(motions.T @ mass @ motions)
        least = NO_MASS * joint_inertia((basis.T @ motions.T) / scale, np.diag(mass) * scale**2, joints)
        heavy = values > least
        return np.asarray((basis[:, heavy] / values[heavy]) @ basis[:, heavy].T @ motions.T)

    def full_acceleration(self, q: Array, v_full: Array, effort: Array) -> Array:
        """Acceleration of all joints, shape (nv,), in a basis of the motions that the loops allow."""
        jacobian, mass = self.jacobian(q), self.mass(q)
        split = Split.of(jacobian)
        motions, start = self.scale[:, None] * split.null, -self.scale * split.solve(self.bent(q, v_full))
        force = motions.T @ (effort - self.forces(q, v_full, start))
        return np.asarray(start + motions @ np.linalg.solve(motions.T @ mass @ motions, force))

    def tool(self, q: Array, v_full: Array, drift: Array) -> tuple[Array, Array, Array]:
        """Position (3,) and Jacobian (3, nv) of the tool point, and its acceleration (3,) with the given ones."""
        frame, model, data = self.chain.description.tool, self.model, self.data
        assert frame is not None, "see `lacks`"
        joint, placement = bind_frame(model, frame)
        pin.computeJointJacobians(model, data, q)
        pin.forwardKinematics(model, data, q, v_full, drift)
        own = pin.getJointJacobian(model, data, joint, pin.ReferenceFrame.LOCAL)
        here = data.oMi[joint] * placement
        speed, pull = placement.actInv(data.v[joint]), placement.actInv(data.a[joint])
        jacobian = here.rotation @ (placement.toActionMatrixInverse() @ own.reshape(6, model.nv))[:3]
        acceleration = here.rotation @ (pull.linear + np.cross(speed.angular, speed.linear))
        return np.array(here.translation) + np.array(self.source.origin), jacobian, acceleration

    def potential(self, q: Array) -> float:
        """Potential energy [J]."""
        own = float(pin.computePotentialEnergy(self.model, self.data, q))
        return own - self.total_mass * float(self.model.gravity.linear @ np.array(self.source.origin))
