"""The values that models hand out: posture, terms of the equation of motion, tool kinematics.

All arrays in them are read-only, also after pickling and copying.  SI units and radians throughout.
"""

from __future__ import annotations

from dataclasses import dataclass

from cutjoint.arrays import Array, Frozen


@dataclass(frozen=True, eq=False)
class Posture(Frozen):
    """A closed configuration.  Only `close()` and `reach()` of a mechanism make one, so it is always closed.

    Attributes:
        q: actuated coordinates, shape (n,), [m] or [rad].
        q_full: the owner's own layout, shape (nq,) for a chain.  It also tells the branch (working and assembly mode).
        gap: worst residual over all loops, ([m], [rad]).
    """

    q: Array
    q_full: Array
    gap: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Terms(Frozen):
    """The equation of motion in actuated coordinates: `mass @ a + coriolis + gravity = effort`.

    Attributes:
        mass: symmetric positive definite, shape (n, n), [kg], [kg m] or [kg m2].
        coriolis: the vector C(q, v) v, shape (n,), [N] or [N m].  The vector is unique; the matrix C is not.
        gravity: effort that holds the posture at rest, shape (n,), [N] or [N m].
    """

    mass: Array
    coriolis: Array
    gravity: Array


@dataclass(frozen=True, eq=False)
class Tool(Frozen):
    """Kinematics of the tool point.

    Attributes:
        position: in the world frame, shape (3,), [m].
        jacobian: tool velocity = jacobian @ v, shape (3, n).
        drift: time derivative of the Jacobian times v, shape (3,), [m/s2]; tool acceleration = jacobian @ a + drift.
    """

    position: Array
    jacobian: Array
    drift: Array
