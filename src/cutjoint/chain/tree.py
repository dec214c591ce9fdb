"""The open tree in Pinocchio: the one place that has its workspace filled, and reads it.

What is handed out are arrays of its own.  Every thread has a workspace of its own, so a robot can be shared between
threads; what a function says of "the last call" is that of the same thread.
"""

from __future__ import annotations

import threading

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array, readonly
from cutjoint.chain.joints import JOINTS, support, type_of


class _Workspaces(threading.local):
    """Pinocchio's workspace, which every thread makes for itself."""

    def __init__(self, model: pin.Model) -> None:
        self.data = model.createData()


class HeldUp:
    """Masses whose weight is compensated: a tree of nothing else, or None where there are none."""

    def __init__(self, model: pin.Model | None) -> None:
        self._model = model
        self._own = None if model is None else _Workspaces(model)

    def lift(self, q: Array) -> Array | float:
        """Generalised force that compensates the weights, shape (nv,); 0 where there are none."""
        return 0.0 if self._own is None else np.asarray(pin.computeGeneralizedGravity(self._model, self._own.data, q))

    def energy(self, q: Array) -> float:
        """Potential energy of the weights [J], zero at the model's origin."""
        return 0.0 if self._own is None else float(pin.computePotentialEnergy(self._model, self._own.data, q))


class TreeModel:
    """The model of a tree with its workspaces.

    Args:
        model: the tree.
        held_up: the same with the masses whose weight is compensated, where there are any.

    Attributes:
        model: the tree.
        neutral: the zero configuration, shape (nq,).
        mass: of all links that move [kg].
        weighing: what of it gravity pulls [kg].
        held_up: what compensates weights.
    """

    def __init__(self, model: pin.Model, held_up: pin.Model | None = None) -> None:
        self.model, self.held_up = model, HeldUp(held_up)
        self._own = _Workspaces(model)
        self.neutral = readonly(pin.neutral(model))
        self.mass = _moving_mass(model)
        self.weighing = self.mass - (0.0 if held_up is None else _moving_mass(held_up))
        self._first_axes = [
            (int(model.idx_vs[joint]), support(model, model.parents[joint]))
            for joint in range(1, model.njoints)
            if JOINTS[type_of(model, joint)].first_with_parent
        ]

    # ---- where its joints are --------------------------------------------------------------------------------------

    def jacobians(self, q: Array) -> Array:
        """Joint Jacobians about the origin in its axes at `q` (nq,), shape (6, nv)."""
        pin.computeJointJacobians(self.model, self._own.data, q)
        return self.twists()

    def rates(self, q: Array, v: Array) -> Array:
        """Time derivatives of the joint Jacobians, shape (6, nv); `twists` are the Jacobians then.

        Pinocchio 4.1 leaves out that the first axis of a universal joint turns with the parent alone; that column is
        set right here.
        """
        data = self._own.data
        pin.computeJointJacobiansTimeVariation(self.model, data, q, v)
        rates = np.array(data.dJ).reshape(6, self.model.nv)  # (6,) where nv is 1
        if self._first_axes:
            twists = self.twists()
            for column, below in self._first_axes:
                axis = twists[:, column]
                carrier = twists @ (below * v)
                w, u = carrier[3:], carrier[:3]
                rates[:3, column] = np.cross(w, axis[:3]) + np.cross(u, axis[3:])
                rates[3:, column] = np.cross(w, axis[3:])
        return rates

    def twists(self) -> Array:
        """The joint Jacobians of the last call that made them, shape (6, nv)."""
        return np.array(self._own.data.J).reshape(6, self.model.nv)

    def joints_at(self, joints: list[int]) -> Array:
        """Placements of joints in the last call that made Jacobians, shape (k, 4, 4)."""
        placed = self._own.data.oMi
        return np.array([placed[joint].homogeneous for joint in joints])

    def bodies(self, q: Array) -> tuple[Array, Array]:
        """Axes (joints + 1, 3, 3) and origins (joints + 1, 3) of all joints' bodies in the model, the base first."""
        data = self._own.data
        pin.forwardKinematics(self.model, data, q)
        placed = np.array([placement.homogeneous for placement in data.oMi])
        return placed[:, :3, :3], placed[:, :3, 3]

    def integrate(self, q: Array, motion: Array) -> Array:
        """Configuration after the tangent motion (nv,), on the manifold."""
        return np.asarray(pin.integrate(self.model, q, motion))

    def normalised(self, q: Array) -> Array:
        """A configuration (nq,) with its quaternions and turned vectors of length 1."""
        return np.asarray(pin.normalize(self.model, q))

    def difference(self, q: Array, other: Array) -> Array:
        """The tangent motion (nv,) that leads from one configuration to another."""
        return np.asarray(pin.difference(self.model, q, other))

    # ---- its masses ------------------------------------------------------------------------------------------------

    def mass_matrix(self, q: Array) -> Array:
        """Mass matrix of the tree, symmetric, shape (nv, nv)."""
        upper = np.triu(np.reshape(pin.crba(self.model, self._own.data, q), (self.model.nv, self.model.nv)))
        return np.asarray(upper + np.triu(upper, 1).T)

    def forces(self, q: Array, v: Array, a: Array) -> Array:
        """Generalised forces that make the tree move so: M a + C v + g, shape (nv,)."""
        return np.asarray(pin.rnea(self.model, self._own.data, q, v, a)) - self.held_up.lift(q)

    def bias(self, q: Array, v: Array) -> Array:
        """Those that keep its velocity: C v + g, shape (nv,)."""
        return np.asarray(pin.nonLinearEffects(self.model, self._own.data, q, v)) - self.held_up.lift(q)

    def gravity(self, q: Array) -> Array:
        """Generalised gravity, less what is compensated, shape (nv,)."""
        return np.asarray(pin.computeGeneralizedGravity(self.model, self._own.data, q)) - self.held_up.lift(q)

    def potential_energy(self, q: Array) -> float:
        """Of gravity and what compensates it [J], zero at the model's origin."""
        return float(pin.computePotentialEnergy(self.model, self._own.data, q)) - self.held_up.energy(q)

    def centre_of_mass(self, q: Array) -> Array:
        """Of all links that move, in the model, shape (3,) [m]."""
        return np.array(pin.centerOfMass(self.model, self._own.data, q))


def _moving_mass(model: pin.Model) -> float:
    return float(sum(inertia.mass for inertia in list(model.inertias)[1:]))
