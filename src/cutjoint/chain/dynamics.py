"""Constrained forward dynamics in full coordinates, with the forces in the cut joints.

Fixed, spherical and revolute cuts are Pinocchio `RigidConstraintModel`s (a revolute cut is two coincident points on its
axis) and go through `pin.constraintDynamics`.  Universal and prismatic cuts and couplings, which Pinocchio has no rigid
constraint for, go through the same equations in numpy:

    M a + h = tau + K' f,   K a + gamma = 0   =>   (K M^-1 K') f = -(K M^-1 (tau - h) + gamma)

Redundant rows are the rule (both papers' robots have three), so f is the least one that does the work, and the
solution is accepted only if |K a + gamma| vanishes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array, readonly
from cutjoint.chain.kinematics import Kinematics
from cutjoint.chain.mobility import null_space
from cutjoint.chain.rigid import RigidConstraints, Wrench, is_rigid
from cutjoint.description.model import CutType
from cutjoint.errors import DynamicsError


@dataclass(frozen=True, eq=False)
class FullMotion:
    """Result of constrained forward dynamics.

    Attributes:
        acceleration: of all joints, shape (nv,), [m/s2] and [rad/s2].
        loop_forces: cut joint -> wrench.  Where rows are redundant the split among cuts is the one of least norm.
        couplings: coupling -> generalised force [N] or [N m] on its joint.
        residual: largest |K a + gamma| left [m/s2, rad/s2].
    """

    acceleration: Array
    loop_forces: Mapping[str, Wrench]
    couplings: Mapping[str, float]
    residual: float


class FullDynamics:
    """Constrained forward dynamics of one robot."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._k = kinematics
        closure = kinematics.closure
        self.massless = has_massless_joint(kinematics)
        rigid = is_rigid(closure) and not self.massless
        self.rigid = RigidConstraints(kinematics.model, closure.cuts, kinematics.length) if rigid else None

    def acceleration(self, q: Array, v: Array, effort: Array) -> Array:
        """Acceleration of all joints, shape (nv,), not checked against the constraints: for inner loops."""
        if self.rigid is not None:
            return self.rigid.acceleration(q, v, effort)
        return self._solve(q, v, effort)[0]

    def checked(self, q: Array, v: Array, effort: Array) -> Array:
        """As `acceleration`, checked: where Pinocchio's iteration did not converge, solved directly.

        Raises:
            DynamicsError: the acceleration does not respect the cuts.
        """
        if self.rigid is not None:
            acceleration = self.rigid.acceleration(q, v, effort)
            left, size = self.rigid.unmet(acceleration)
            if left <= tolerances.DYNAMICS.value * max(size, 1.0):  # false for a NaN too
                return acceleration
        acceleration, _ = self._solve(q, v, effort)
        self.check(q, v, acceleration)
        return acceleration

    def motion(self, q: Array, v: Array, effort: Array) -> FullMotion:
        """Acceleration and loop forces at a closed configuration.

        Raises:
            DynamicsError: the acceleration does not respect the cuts.
        """
        couplings: dict[str, float] = {}
        if self.rigid is not None:
            acceleration = self.rigid.acceleration(q, v, effort)
            forces = self.rigid.wrenches()
        else:
            acceleration, multipliers = self._solve(q, v, effort)
            multipliers = self._k.closure.spread(multipliers)
            forces = self._wrenches(q, multipliers)
            ratios = self._k.closure.ratios
            couplings = {
                r.name: float(f) for r, f in zip(ratios, multipliers[len(multipliers) - len(ratios) :], strict=True)
            }
        residual = self.check(q, v, acceleration)
        return FullMotion(readonly(acceleration), forces, couplings, residual)

    def check(self, q: Array, v: Array, acceleration: Array) -> float:
        """Largest |K a + gamma| of an acceleration.

        Raises:
            DynamicsError: it is not finite or not small against its own terms.
        """
        k = self._k
        if not np.isfinite(acceleration).all():
            raise DynamicsError("forward dynamics gave a number that is not finite: singular posture", residual=np.inf)
        k.update_rates(q, v)
        moved, drift = k.closure.jacobian(k.data) @ acceleration, k.closure.drift(k.data, v)
        residual = float(np.abs(moved + drift).max(initial=0.0))
        size = float(max(np.abs(moved).max(initial=0.0), np.abs(drift).max(initial=0.0), 1.0))
        if residual > tolerances.DYNAMICS.value * size:
            raise DynamicsError(
                f"constrained forward dynamics did not converge: |K a + gamma| = {residual:.3g} against terms of "
                f"{size:.3g}; the posture is singular or not closed",
                residual=residual,
            )
        return residual

    def _solve(self, q: Array, v: Array, effort: Array) -> tuple[Array, Array]:
        k = self._k
        mass = pin.crba(k.model, k.data, q)
        mass = np.triu(mass) + np.triu(mass, 1).T
        bias = np.array(pin.nonLinearEffects(k.model, k.data, q, v))
        k.update_rates(q, v)
        jacobian, drift = k.closure.jacobian(k.data), k.closure.drift(k.data, v)
        if self.massless:
            return self._solve_by_motions(mass, effort - bias, jacobian, drift)
        free = np.linalg.solve(mass, np.column_stack([effort - bias, jacobian.T]))
        if not len(jacobian):
            return free[:, 0], np.zeros(0)
        compliance = jacobian @ free[:, 1:]
        wanted = -(jacobian @ free[:, 0] + drift)
        scale = 1.0 / np.sqrt(np.maximum(np.diag(compliance), 1e-300))
        scaled = scale[:, None] * compliance * scale
        multipliers = scale * np.linalg.lstsq(scaled, scale * wanted, rcond=tolerances.RANK.value**1.5)[0]
        return free[:, 0] + free[:, 1:] @ multipliers, multipliers

    def _solve_by_motions(self, mass: Array, force: Array, jacobian: Array, drift: Array) -> tuple[Array, Array]:
        """The same where the tree has joints that move no mass: in a basis of the motions that the loops allow.

        Raises:
            DynamicsError: even a motion that the loops allow moves no mass.
        """
        scale = self._k.column_scale
        basis = scale[:, None] * null_space(jacobian * scale)
        start = scale * np.linalg.lstsq(jacobian * scale, -drift, rcond=tolerances.RANK.value)[0]
        energy = basis.T @ mass @ basis
        values = np.linalg.eigvalsh(energy) if energy.size else np.ones(1)
        if values[0] <= 1e-12 * values[-1]:
            raise DynamicsError(
                "the robot has a motion that moves no mass: a body at the end of a limb has none, or none that its "
                "joint moves; give it an inertia",
                residual=np.inf,
            )
        acceleration = start + basis @ np.linalg.solve(energy, basis.T @ (force - mass @ start))
        multipliers = np.linalg.lstsq(jacobian.T, mass @ acceleration - force, rcond=tolerances.RANK.value)[0]
        return acceleration, multipliers

    def _wrenches(self, q: Array, multipliers: Array) -> dict[str, Wrench]:
        """Multipliers of the closure rows as wrenches on body B at frame b, world axes."""
        k = self._k
        found: dict[str, Wrench] = {}
        row = 0
        for cut, (_, a, b) in zip(k.closure.cuts, k.closure.placements(k.data), strict=True):
            part = multipliers[row : row + cut.rows]
            row += cut.rows
            moment = np.zeros(3)
            if cut.type is CutType.PRISMATIC:
                force, moment = a.rotation[:, :2] @ part[:2], part[2:5]
            else:
                force = part[:3]
            if cut.type is CutType.FIXED:
                moment = part[3:6]
            elif cut.type is CutType.REVOLUTE:
                z = b.rotation[:, 2]
                moment = part[3] * np.cross(z, a.rotation[:, 0]) + part[4] * np.cross(z, a.rotation[:, 1])
            elif cut.type is CutType.UNIVERSAL:
                moment = part[3] * np.cross(b.rotation[:, 1], a.rotation[:, 0])
            found[cut.name] = Wrench(readonly(force), readonly(moment))
        return found


def has_massless_joint(kinematics: Kinematics) -> bool:
    """Whether some motion of the open tree moves no mass, which Pinocchio's constrained dynamics cannot stand."""
    k = kinematics
    if not k.model.nv:
        return False
    bent = k.integrate(np.array(pin.neutral(k.model)), k.column_scale * np.linspace(0.3, 0.7, k.model.nv))
    upper = pin.crba(k.model, k.data, bent)
    mass = (np.triu(upper) + np.triu(upper, 1).T) * k.column_scale[:, None] * k.column_scale
    size = np.sqrt(np.maximum(np.diag(mass), 0.0))
    if size.min() <= 0.0:
        return True
    return bool(np.linalg.eigvalsh(mass / size[:, None] / size)[0] < 1e-12)
