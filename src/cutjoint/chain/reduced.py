"""The closed robot in actuated coordinates, wherever the actuators determine the motion.

With K = [K_a K_p] the constraint Jacobian, split into actuated and passive columns,

    v_full = T v,   T = [1; -K_p^+ K_a]          a_full = T a + d,   d = [0; -K_p^+ K_dot v_full]
    mass = T' M T,  coriolis = T' (M d + C v_full),  gravity = T' g,  springs = T' s,  friction = T' r

where M, C and g of the tree come from Pinocchio (crba, rnea), s and r from its joints (`cutjoint.chain.physics`).  The
pseudo-inverse keeps exactly as many singular values as there are passive velocities, so redundant rows do no harm and a
singular posture raises an error.

Idle motions, such as a rod between two balls that spins about itself, need no actuator: T gives them no momentum
(`cutjoint.chain.tangent`), and they accelerate as no motor pushes them.

The drift d is made of the rates of the joint Jacobians and of the turning of the cuts' rows (`cutjoint.chain.closure`).
Where all cuts hold points or lock rotations the second is the difference of the centripetal accelerations
w x (u + w x p) of the points that are held together, so both are a matrix of the posture times a vector.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array, as_vector, readonly
from cutjoint.chain.closure import cross
from cutjoint.chain.dynamics import Motions
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.mobility import Mobility
from cutjoint.chain.tangent import QuickTangent, TangentMap
from cutjoint.doors import of_type
from cutjoint.errors import DynamicsError, SingularError
from cutjoint.mechanism import Posture, Terms, Tool


class AtPosture:
    """A robot at one posture; it never changes.

    Attributes:
        posture: where.
        placed: the tree there.
        map: T with v_full = T @ v, shape (nv, n).
        transposed: T', shape (n, nv).
        idle: idle motions as in `TangentMap`, shape (nv, k).
    """

    def __init__(
        self, kinematics: Kinematics, passive: Array, posture: Posture, placed: Placed, found: QuickTangent | TangentMap
    ) -> None:
        self._k, self._passive, self._found = kinematics, passive, found
        self.posture, self.placed = posture, placed
        self.map, self.transposed = readonly(found.map), readonly(found.map.T)
        self.idle = found.idle if isinstance(found, TangentMap) else self.map[:, :0]

    def drift(self, v_full: Array) -> Array:
        """d with a_full = T a + d, shape (nv,), the idle motions at rest, for a velocity T v of all joints.

        Raises:
            SingularError: the velocity opens the loops in the next moment, whatever the accelerations.
        """
        k, closure = self._k, self._k.closure
        q = self.posture.q_full
        moving = closure.moved * v_full
        if closure.holds_points and isinstance(self._found, QuickTangent):
            drift: Array = self._from_rates.dot(moving.dot(k.tree.rates(q, v_full).T).ravel())
            if closure.turns:
                speeds = self._speeds.dot(v_full)
                half = speeds.size // 2
                inward = cross(speeds[:half].reshape(-1, 3), speeds[half:].reshape(-1, 3))
                drift += self._from_inward.dot(inward.ravel())
            return drift
        rates, twists = k.tree.rates(q, v_full), k.tree.twists()
        drift = np.zeros(k.model.nv)
        placed = self.placed
        gamma = closure.drift(placed.frames, placed.gather, twists, rates, placed.q, v_full)
        drift[self._passive] = self._back @ gamma
        if isinstance(self._found, TangentMap):
            self._check(v_full, drift, gamma)
        return drift

    def _check(self, v_full: Array, drift: Array, gamma: Array) -> None:
        k = self._k
        speed = float(np.abs(v_full / k.column_scale).max(initial=0.0))
        scaled, wanted = drift / k.column_scale, k.row_scale * gamma
        left = float(np.abs(self.placed.scaled @ scaled + wanted).max(initial=0.0))
        terms = speed**2 + float((np.abs(self.placed.scaled) @ np.abs(scaled) + np.abs(wanted)).max(initial=0.0))
        if left > tolerances.REACHED.value * terms:
            raise SingularError(
                f"{k.description.name} moves here only for a moment: at this velocity the loops open, whatever the "
                f"accelerations (by {left:.2g} of terms of {terms:.2g}, dimensionless)",
                kind="type-2",
                measure=0.0,
                limit=tolerances.REACHED.value,
            )

    def forces(self, v_full: Array, a_full: Array) -> Array:
        """Generalised forces of the tree that a motion needs, against springs and friction too, shape (nv,)."""
        placed = self.placed
        inertial = self._k.tree.forces(placed.q, v_full, a_full)
        if not self._k.physics.acts:
            return inertial
        return np.asarray(inertial + placed.springs + placed.friction(v_full))

    def pushes_idle(self, forces: Array) -> bool:
        """Whether generalised forces of all joints (nv,) push an idle motion."""
        scale = self._k.column_scale[:, None]
        idle, scaled = self.idle / scale, scale[:, 0] * forces
        rounding = tolerances.ROUNDED.value * np.abs(scaled).max(initial=0.0) * np.abs(idle).sum(axis=0)
        size = tolerances.REACHED.value * (np.abs(idle).T @ np.abs(scaled))
        return bool((np.abs(idle.T @ scaled) > size + rounding).any())

    @cached_property
    def inverse_mass(self) -> Array:
        """Inverse of the mass matrix in actuated coordinates, shape (n, n).

        Raises:
            DynamicsError: a motion of the actuators moves no mass.
        """
        mass = self.transposed @ self._k.tree.mass_matrix(self.placed.q) @ self.map
        motions = Motions.of(np.eye(len(mass)), mass)
        if motions.idle.size:
            raise DynamicsError(
                f"{self._k.description.name} has a motion that moves no mass: a body at the end of a limb has none, or "
                "none that its joint moves; give it an inertia",
                residual=np.inf,
            )
        return np.asarray(motions.basis @ motions.factor @ motions.factor.T @ motions.basis.T)

    @cached_property
    def _back(self) -> Array:
        """Passive accelerations from the drift of the rows, shape (passive, rows)."""
        found = self._found
        if isinstance(found, TangentMap):
            return -found.inverse
        back = np.zeros((len(found.back), self._k.closure.rows))
        back[:, found.rows] = found.back
        return back

    def _from(self, rows: Array) -> Array:
        """Accelerations of all joints from what rows of the cuts (cut rows, k) make of something, shape (nv, k)."""
        closure, found = self._k.closure, np.zeros((self._k.model.nv, rows.shape[1]))
        of_couplings = np.zeros((len(closure.couplings), rows.shape[1]))
        found[self._passive] = self._back @ closure.kept(np.concatenate([rows, of_couplings]))
        return found

    @cached_property
    def _from_rates(self) -> Array:
        """Accelerations of all joints from the rates of the cut frames' twists, shape (nv, 12 cuts)."""
        return self._from(self.placed.gather)

    @cached_property
    def _from_inward(self) -> Array:
        """Accelerations of all joints from the centripetal ones of the cut frames' origins, shape (nv, 6 cuts)."""
        return self._from(self._k.closure.apart)

    @cached_property
    def _speeds(self) -> Array:
        """Angular velocities of all cut frames, then velocities of their origins, shape (12 cuts, nv)."""
        frames = self.placed.frames
        twists = self._k.closure.support * self.placed.twists
        points = np.concatenate([frames.at_a, frames.at_b])
        w = twists[:, 3:].transpose(0, 2, 1)
        velocity = twists[:, :3] + cross(w.reshape(-1, 3), np.repeat(points, w.shape[1], axis=0)).reshape(
            w.shape
        ).transpose(0, 2, 1)
        return np.concatenate([twists[:, 3:].reshape(-1, w.shape[1]), velocity.reshape(-1, w.shape[1])])


class ReducedDynamics:
    """Kinematics and dynamics of one robot by its actuated coordinates.  All raise what `Mobility.tangent` does."""

    def __init__(self, mobility: Mobility) -> None:
        self._mobility, self._postures, self._chosen = mobility, mobility.postures, mobility.chosen
        self._k, self._tree, self._n = mobility.postures.k, mobility.postures.k.tree, self._chosen.n
        self._last: AtPosture | None = None

    def at(self, at: Posture) -> AtPosture:
        """The robot at a posture; at the last one it is kept, since several calls at one posture are the rule."""
        last = self._last
        if last is None or last.posture is not at:
            of_type("at", at, Posture)
            placed = self._postures.placed(at)
            found = self._mobility.quick_tangent(placed) or self._mobility.tangent(placed)
            last = self._last = AtPosture(self._k, self._chosen.passive, at, placed, found)
        return last

    def velocity(self, at: Posture, v: npt.ArrayLike) -> Array:
        """Velocity of all joints, shape (nv,)."""
        return self.at(at).map @ as_vector("v", v, self._n)

    def drift(self, at: Posture, v: npt.ArrayLike) -> Array:
        """d with a_full = T @ a + d, shape (nv,)."""
        here, v_full = self.at(at), self.velocity(at, v)
        drift = here.drift(v_full)
        if here.idle.size:
            drift = drift - here.idle @ (here.idle.T @ here.forces(v_full, drift))
        return drift

    def tool(self, at: Posture, v: npt.ArrayLike | None) -> Tool:
        """The tool in world axes."""
        k = self._k
        k.need_tool()
        here = self.at(at)
        placed, drift, twist = here.placed, np.zeros(6), np.zeros(6)
        if v is not None:
            v_full = self.velocity(at, v)
            placed = moving = k.moving(at.q_full, v_full)
            drift = moving.tool_drift + moving.tool_jacobian @ here.drift(v_full)
            twist = moving.tool_jacobian @ v_full
        pose = placed.tool_pose
        return Tool(pose.position + k.origin, pose.rotation, placed.tool_jacobian @ here.map, drift, twist)

    def terms(self, at: Posture, v: npt.ArrayLike | None) -> Terms:
        """Mass matrix (n, n), Coriolis vector (n,) and gravity (n,)."""
        here, tree, q = self.at(at), self._tree, at.q_full
        mass, gravity = tree.mass_matrix(q), tree.gravity(q)
        coriolis, v_full = np.zeros(self._n), np.zeros(self._k.model.nv)
        if v is not None:
            v_full = self.velocity(at, v)
            coriolis = here.transposed @ (tree.forces(q, v_full, here.drift(v_full)) - gravity)
        reduced = here.transposed @ mass @ here.map
        terms = Terms(0.5 * (reduced + reduced.T), coriolis, here.transposed @ gravity)
        if not self._k.physics.acts:
            return terms
        springs = here.transposed @ here.placed.springs
        return replace(terms, springs=springs, friction=here.transposed @ here.placed.friction(v_full))

    def inverse(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Array:
        """Effort (n,) of an acceleration: T' rnea(q, T v, T a + d)."""
        here = self.at(at)
        v_full = here.map.dot(as_vector("v", v, self._n))
        full = here.map.dot(as_vector("a", a, self._n)) + here.drift(v_full)
        effort: Array = here.transposed.dot(here.forces(v_full, full))
        return effort

    def forward(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike) -> Array:
        """Acceleration (n,) of an effort: (T' M T)^-1 (effort - T' rnea(q, T v, d))."""
        here = self.at(at)
        v_full = here.map.dot(as_vector("v", v, self._n))
        held = here.forces(v_full, here.drift(v_full))
        push = as_vector("effort", effort, self._n) - here.transposed.dot(held)
        acceleration: Array = here.inverse_mass.dot(push)
        return acceleration
