"""Constrained forward dynamics in full coordinates, with the forces in the cut joints.

    M a + h = tau + K' f,   K a + gamma = 0

Springs, dampers and friction of the joints (`cutjoint.chain.physics`) are taken from tau before anything else.

Both are solved in dimensionless coordinates, in which the rank of K is decided (`cutjoint.chain.rank`).  With N a basis
of the motions that the loops allow and a_0 the least acceleration with K a_0 = -gamma,

    a = a_0 + N z,   (N' M N) z = N' (tau - h - M a_0),   K' f = M a + h - tau

so redundant rows never enter, and f is the least one that does the work: least is L^2 |force|^2 + |moment|^2 over all
cuts, with L the characteristic length.  No equation tells how motions accelerate that move no mass, such as the spin of
a massless rod between two balls: where nothing pushes them, of all accelerations that solve both equations the least is
taken, in dimensionless coordinates; where something does, there is no answer.

Where the rows of all cuts are those of contacts (fixed, spherical, revolute), `pin.constraintDynamics` gives the same
accelerations by its proximal iteration, and quicker; it is used where it converged.  What is returned with forces
satisfies both equations, or an error is raised.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array, Values, readonly, readonly_mapping
from cutjoint.chain.closure import Closure, CutFrames, direction
from cutjoint.chain.joints import joints_of
from cutjoint.chain.kinematics import Kinematics, Moving
from cutjoint.chain.rank import Split, coordinates_of
from cutjoint.chain.rigid import RigidConstraints, is_rigid
from cutjoint.description.cuts import Kind
from cutjoint.errors import DynamicsError
from cutjoint.reprs import line


@dataclass(frozen=True, eq=False)
class Wrench(Values):
    """What body A of a cut exerts on body B: force (3,) [N], moment (3,) [N m] at the origin of frame b, world axes."""

    force: Array
    moment: Array


@dataclass(frozen=True, eq=False)
class FullMotion(Values):
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

    __repr__ = line(acceleration="m/s2 or rad/s2", loop_forces="N or N m", couplings="N or N m", residual="m/s2")


@dataclass(frozen=True, eq=False)
class Motions:
    """The motions that the loops allow at one configuration, by their mass.

    Attributes:
        basis: of them, one coordinate of the tree each, shape (nv, k), dimensionless.
        factor: columns in coordinates of the basis that the mass matrix makes orthonormal, shape (k, moved).
        idle: orthonormal motions that move no mass, in coordinates of the basis scaled by `size`, shape (k, massless).
        size: root of the mass that each column of the basis moves, the least one for those that move none, shape (k,).
    """

    basis: Array
    factor: Array
    idle: Array
    size: Array

    @cached_property
    def massless(self) -> Array:
        """Orthonormal basis of those that move no mass, dimensionless, shape (nv, massless)."""
        return np.linalg.qr(self.basis @ (self.idle / self.size[:, None]))[0]

    @staticmethod
    def of(allowed: Array, mass: Array) -> Motions:
        """From an orthonormal basis of the allowed motions and the mass matrix, both dimensionless in the motions.

        Raises:
            DynamicsError: a motion has less than no mass.
        """
        basis = coordinates_of(allowed)
        energy = basis.T @ mass @ basis
        size = np.sqrt(np.maximum(np.diag(energy), 0.0))
        # a rod that carries others may spin while these stand still: what they move must be more than rounding
        summed = np.abs(basis).T @ np.abs(mass) @ np.abs(basis)
        terms = np.diag(summed)
        _refuse_negative(np.diag(energy), terms)
        moves = (size > MASSLESS * np.sqrt(np.abs(mass).max(initial=0.0))) & (size**2 > MASSLESS * terms)
        size = np.where(moves, size, float(size[moves].min(initial=np.inf)) if moves.any() else 1.0)
        both = np.outer(moves, moves)
        values, vectors = np.linalg.eigh(np.where(both, energy, 0.0) / size[:, None] / size)
        # light motions that are differences of heavy terms, such as the spin of a bar that carries rods
        unsure = EPSILONS * np.where(both, summed, 0.0) / size[:, None] / size
        rounding = np.einsum("ik,ij,jk->k", np.abs(vectors), unsure, np.abs(vectors))
        _refuse_negative(values, np.maximum(rounding / NEGATIVE, 1.0))
        heavy = values > np.maximum(rounding, MASSLESS)
        factor = vectors[:, heavy] / size[:, None] / np.sqrt(values[heavy])
        return Motions(basis, factor, vectors[:, ~heavy], size)


MASSLESS = 1e-12
"""Motions that move less than this part of the mass of the others (by each joint's own measure) move none: rounding of
masses that cancel lies below, the spin of a wire above."""

EPSILONS = 4.0 * float(np.finfo(np.float64).eps)
"""Of the terms that an energy is the sum of, what may be rounding; up to a third of one epsilon was seen in 150
postures of a Delta with rods on spherical joints."""

NEGATIVE = 1e-9
"""Motions that move less than nothing by more than this part of the others are no rounding, but no body's either."""

PUSHED = 1e-6
"""Part of the largest component of a motion that is pushed, below which messages do not name a joint."""

ROUNDED = 1e-13
"""Part of a motion that rows leave which vanish but for rounding, such as those of a door's second hinge."""


class FullDynamics:
    """Constrained forward dynamics of one robot that is closed at `q` (nq,).  It raises `DynamicsError` where the
    acceleration does not respect the cuts, or the forces do not balance."""

    def __init__(self, kinematics: Kinematics, q: Array) -> None:
        self._k = k = kinematics
        self.rigid: RigidConstraints | None = None
        if is_rigid(k.closure):
            bent, every = k.after(k.tree.neutral, np.linspace(0.3, 0.7, k.model.nv)), np.eye(k.model.nv)
            # Pinocchio's constrained dynamics cannot stand motions of the open tree that move no mass
            rigid = None if massless_motions(k, bent, every).size else RigidConstraints(k, q)
            self.rigid = rigid if rigid is not None and rigid.usable else None

    def acceleration(self, q: Array, v: Array, effort: Array) -> Array:
        """Acceleration of all joints, shape (nv,), for inner loops: by Pinocchio where its iteration converged, else
        solved directly."""
        push = self._pushed(q, v, effort)
        if self.rigid is not None:
            acceleration = self.rigid.acceleration(q, v, push)
            if acceleration is not None:
                return acceleration
        return self._solve(self._k.moving(q, v), push)[0]

    def _pushed(self, q: Array, v: Array, effort: Array) -> Array:
        """What is left of an effort (nv,) beside springs and friction."""
        physics = self._k.physics
        if not physics.acts:
            return effort
        elastic = self._k.at(q).elastic if physics.cuts else None
        return np.asarray(effort - physics.springs(q, elastic) - physics.friction(q, v, elastic))

    def motion(self, q: Array, v: Array, effort: Array) -> FullMotion:
        """Acceleration and loop forces at a closed configuration."""
        placed = self._k.moving(q, v)
        acceleration, multipliers, residual = self._solve(placed, self._pushed(q, v, effort))
        closure = self._k.closure
        every = np.zeros(closure.all_rows)
        every[closure.trusted] = multipliers
        of_coupled = every[len(every) - len(closure.couplings) :]
        couplings = {one.name: float(f) for one, f in zip(closure.couplings, of_coupled, strict=True)}
        forces = wrenches(closure, placed.frames, every)
        return FullMotion(readonly(acceleration), readonly_mapping(forces), readonly_mapping(couplings), residual)

    def _solve(self, placed: Moving, effort: Array) -> tuple[Array, Array, float]:
        """Acceleration (nv,), multipliers of the rows (rows,) and the largest |K a + gamma| left."""
        k, scale = self._k, self._k.column_scale
        q, v = placed.q, placed.v
        split = Split.of(placed.scaled)
        gamma = k.row_scale * placed.drift
        mass = scale[:, None] * k.tree.mass_matrix(q) * scale
        bias = scale * k.tree.bias(q, v)
        push = scale * effort
        least = split.solve(-gamma)
        inertial = mass @ least
        motions = Motions.of(split.null, mass)
        load = motions.basis.T @ (push - bias - inertial)
        floor = tolerances.ROUNDED.value * (k.load(mass, v, scale * least) + float(np.abs(push).max(initial=0.0)))
        self._refuse_massless(motions, load, np.abs(push) + np.abs(bias) + np.abs(inertial), floor)
        moved = motions.factor @ (motions.factor.T @ load)
        scaled = least + motions.basis @ moved
        scaled = scaled - motions.massless @ (motions.massless.T @ scaled)
        pull = mass @ scaled + bias - push
        multipliers = split.solve_transposed(pull)
        acceleration = scale * scaled
        residual = self._check(placed, acceleration, multipliers, [mass @ scaled, bias, push], gamma)
        return acceleration, k.row_scale * multipliers, residual

    def _refuse_massless(self, motions: Motions, load: Array, acting: Array, floor: float) -> None:
        size = motions.size
        terms = np.abs(motions.basis).T @ acting / size
        pushes = motions.idle.T @ (load / size)
        bound = tolerances.DYNAMICS.value * (np.abs(motions.idle).T @ terms)
        rounding = tolerances.ROUNDED.value * float(terms.max(initial=0.0)) + floor / float(size.min(initial=np.inf))
        if (np.abs(pushes) > bound + rounding).any():
            pushed = motions.basis @ (motions.idle @ pushes / size)
            pushed = np.where(np.abs(pushed) > PUSHED * np.abs(pushed).max(), pushed, 0.0) / np.linalg.norm(pushed)
            joints = joints_of(self._k.model, pushed[:, None])
            raise DynamicsError(
                f"a force acts on a motion that moves no mass, of {', '.join(joints)}: a body at the end of a limb has "
                "no mass, or none that its joint moves; give it an inertia, or take away what acts there: an effort, "
                "a load, a spring or friction",
                residual=np.inf,
            )

    def _check(
        self, placed: Moving, acceleration: Array, multipliers: Array, forces: list[Array], gamma: Array
    ) -> float:
        """Largest |K a + gamma|, where both equations hold against the size of their own terms.

        Raises:
            DynamicsError: one of them does not.
        """
        if not (np.isfinite(acceleration).all() and np.isfinite(multipliers).all()):
            raise DynamicsError("forward dynamics gave a number that is not finite: singular posture", residual=np.inf)
        k = self._k
        moved, drift = placed.jacobian @ acceleration, gamma / k.row_scale
        left = np.abs(moved + drift)
        terms = k.row_scale * (np.abs(placed.jacobian) @ np.abs(acceleration) + np.abs(drift))
        open_by = float((k.row_scale * left).max(initial=0.0))
        # rows that vanish at every motion are differences of terms of the size of the motion itself
        speed = float(np.abs(placed.v / k.column_scale).max(initial=0.0))
        motion = float(np.abs(acceleration / k.column_scale).max(initial=0.0)) + speed**2
        inertial, bias, push = forces
        unbalanced = inertial + bias - push - placed.scaled.T @ multipliers
        acting = np.abs(inertial) + np.abs(bias) + np.abs(push) + np.abs(placed.scaled).T @ np.abs(multipliers)
        worst = float(np.abs(unbalanced).max(initial=0.0))
        for found, size, rounding, what in (
            (open_by, float(terms.max(initial=0.0)), ROUNDED * motion, "|K a + gamma|"),
            (worst, float(acting.max(initial=0.0)), 0.0, "|M a + h - tau - K' f|"),
        ):
            if found > tolerances.DYNAMICS.value * size + rounding:
                raise DynamicsError(
                    f"constrained forward dynamics has no solution here: {what} = {found:.3g} against terms of "
                    f"{size:.3g} (dimensionless); the posture is singular or not closed, or the velocity opens a loop",
                    residual=found,
                )
        return float(left.max(initial=0.0))


def _refuse_negative(moved: Array, terms: Array) -> None:
    """Raises DynamicsError where what motions move, shape (k,), is truly below 0 beside the terms it is the sum of."""
    if (moved < -NEGATIVE * terms).any():
        raise DynamicsError(
            "the kinetic energy of a motion is negative: links have moments of inertia below 0, as no body has; look "
            "for wrong signs in their inertias (`cutjoint check` names them)",
            residual=np.inf,
        )


def massless_motions(kinematics: Kinematics, q: Array, allowed: Array) -> Array:
    """Basis of those of the allowed motions (nv, m), orthonormal and dimensionless, that move no mass at `q` (nq,)."""
    k = kinematics
    return Motions.of(allowed, k.tree.mass_matrix(q) * k.column_scale[:, None] * k.column_scale).massless


def wrenches(closure: Closure, frames: CutFrames, multipliers: Array) -> dict[str, Wrench]:
    """Multipliers of all rows of the cuts, one after another, as wrenches on body B at frame b, world axes."""
    found: dict[str, Wrench] = {}
    row = 0
    sides = (frames.axes_a, frames.axes_b, frames.at_a, frames.at_b)
    for cut, a, b, at_a, at_b in zip(closure.cuts, *sides, strict=True):
        force, moment = np.zeros(3), np.zeros(3)
        for equation in cut.type.equations:
            f = multipliers[row : row + equation.rows]
            if closure.along_a and equation.kind in (Kind.POINT, Kind.LOCK):
                f = a @ f
            match equation.kind:
                case Kind.POINT:
                    force += f
                case Kind.LOCK:
                    moment += f
                case Kind.SLIDE:
                    force += a[:, equation.axes[0]] * f[0]
                case Kind.HINGE:
                    moment += f[0] * np.cross(b[:, 2], a[:, 0]) + f[1] * np.cross(b[:, 2], a[:, 1])
                case Kind.DOT:
                    i, j = equation.axes
                    moment += f[0] * np.cross(b[:, j], a[:, i])
                case Kind.DISTANCE:
                    force += f[0] * direction(at_b - at_a)
            row += equation.rows
        found[cut.name] = Wrench(readonly(force), readonly(moment))
    return found
