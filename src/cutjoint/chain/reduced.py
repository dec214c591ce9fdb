"""The closed robot in actuated coordinates, wherever the actuators determine the motion.

With K = [K_a K_p] the constraint Jacobian, split into actuated and passive columns,

    v_full = T v,   T = [1; -K_p^+ K_a]          a_full = T a + d,   d = [0; -K_p^+ K_dot v_full]
    mass = T' M T,  coriolis = T' (M d + C v_full),  gravity = T' g

where M, C and g of the tree come from Pinocchio (crba, rnea).  The pseudo-inverse keeps exactly as many singular
values as there are passive velocities, so redundant rows do no harm and a singular posture raises an error.

Idle motions, such as a rod between two balls that spins about itself, need no actuator: T gives them no momentum
(`cutjoint.chain.tangent`), and they accelerate as no motor pushes them.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, as_vector
from cutjoint.chain.actuated import Actuated
from cutjoint.chain.at_posture import AtPosture
from cutjoint.chain.kinematics import Kinematics
from cutjoint.chain.mobility import Mobility
from cutjoint.chain.postures import Postures
from cutjoint.mechanism import Posture, Terms, Tool


class ReducedDynamics:
    """Kinematics and dynamics of one robot by its actuated coordinates.  All raise what `Mobility.tangent` does."""

    def __init__(self, kinematics: Kinematics, actuated: Actuated, postures: Postures, mobility: Mobility) -> None:
        self._k, self._actuated, self._postures, self._mobility = kinematics, actuated, postures, mobility
        self._n, self._tree = actuated.n, kinematics.tree
        self._last: AtPosture | None = None

    def at(self, at: Posture) -> AtPosture:
        """The robot at a posture; at the last one it is kept, since several calls at one posture are the rule."""
        last = self._last
        if last is None or last.posture is not at:
            placed = self._postures.placed(at)
            found = self._mobility.quick_tangent(placed) or self._mobility.tangent(placed)
            last = self._last = AtPosture(self._k, self._actuated.passive, at, placed, found)
        return last

    def velocity(self, at: Posture, v: npt.ArrayLike) -> Array:
        """Velocity of all joints, shape (nv,)."""
        return self.at(at).map @ as_vector("v", v, self._n)

    def drift(self, at: Posture, v: npt.ArrayLike) -> Array:
        """d with a_full = T @ a + d, shape (nv,)."""
        here, v_full = self.at(at), self.velocity(at, v)
        drift = here.drift(v_full)
        if here.idle.size:
            drift = drift - here.idle @ (here.idle.T @ self._tree.forces(at.q_full, v_full, drift))
        return drift

    def tool(self, at: Posture, v: npt.ArrayLike | None) -> Tool:
        """The tool point in world axes."""
        k = self._k
        k.need_tool()
        here = self.at(at)
        if v is None:
            placed, drift = here.placed, np.zeros(3)
        else:
            v_full = self.velocity(at, v)
            placed = moving = k.moving(at.q_full, v_full)
            drift = moving.tool_drift + moving.tool_jacobian[:3] @ here.drift(v_full)
        return Tool(placed.tool_position + k.origin, placed.tool_jacobian[:3] @ here.map, drift)

    def terms(self, at: Posture, v: npt.ArrayLike | None) -> Terms:
        """Mass matrix (n, n), Coriolis vector (n,) and gravity (n,)."""
        here, tree, q = self.at(at), self._tree, at.q_full
        mass, gravity = tree.mass_matrix(q), tree.gravity(q)
        coriolis = np.zeros(self._n)
        if v is not None:
            v_full = self.velocity(at, v)
            coriolis = here.transposed @ (tree.forces(q, v_full, here.drift(v_full)) - gravity)
        reduced = here.transposed @ mass @ here.map
        return Terms(0.5 * (reduced + reduced.T), coriolis, here.transposed @ gravity)

    def inverse(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Array:
        """Effort (n,) of an acceleration: T' rnea(q, T v, T a + d)."""
        here = self.at(at)
        v_full = here.map.dot(as_vector("v", v, self._n))
        full = here.map.dot(as_vector("a", a, self._n)) + here.drift(v_full)
        effort: Array = here.transposed.dot(self._tree.forces(at.q_full, v_full, full))
        return effort

    def forward(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike) -> Array:
        """Acceleration (n,) of an effort: (T' M T)^-1 (effort - T' rnea(q, T v, d))."""
        here = self.at(at)
        v_full = here.map.dot(as_vector("v", v, self._n))
        held = self._tree.forces(at.q_full, v_full, here.drift(v_full))
        push = as_vector("effort", effort, self._n) - here.transposed.dot(held)
        acceleration: Array = here.inverse_mass.dot(push)
        return acceleration
