"""Dry friction of joints at rest, all at once: forces within their bounds, and the accelerations that are left.

Accelerations of the joints are affine in their friction forces, a = free + R f with R symmetric and positive
semidefinite.  The forces are those of least f' R f / 2 + free' f with |f_i| <= friction_i, which is Gauss's principle
with Coulomb's law: a joint whose force is within its bound does not accelerate, and one that accelerates has its whole
friction against it.  What accelerates is unique; where several joints hold one motion, forces are not, and the least of
them are given.

Solved by principal pivoting, K. G. Murty, Linear Complementarity, Linear and Nonlinear Programming, 1988, chapter 4.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import InputError

SOFT = 1e-13
"""What is added to a diagonal of 1: it picks the least of equal forces."""
NOTHING = 1e-12
"""A joint whose response is below this part of the largest, in roots, yields to no force."""
QUICK = 12
"""Rounds in which all joints change sides that should, before only one does, which is sure to end."""
ROUNDED = 1e-12
"""By what part a force may pass its bound."""


def bounded(response: Array, free: Array, friction: Array) -> tuple[Array, Array]:
    """Forces [N] or [N m] and accelerations [m/s2] or [rad/s2], shape (k,) each.

    Args:
        response: R, shape (k, k).
        free: accelerations without friction, shape (k,).
        friction: the bounds, shape (k,), above 0.

    Raises:
        InputError: no forces are found: the numbers are not finite.
    """
    if not (np.isfinite(response).all() and np.isfinite(free).all()):
        raise InputError("what holds the joints that stick cannot be told: the posture is singular")
    size = np.sqrt(np.maximum(response.diagonal(), 0.0))
    yields = size > NOTHING * size.max(initial=0.0)
    # no force of its own changes the acceleration of the others
    forces = -friction * np.sign(free)
    own, unit = np.ix_(yields, yields), size[yields]
    found = _pivoted(response[own] / unit[:, None] / unit, free[yields] / unit, friction[yields] * unit)
    forces[yields] = found / unit
    return forces, free + response @ forces


def _pivoted(matrix: Array, right: Array, bound: Array) -> Array:
    """Forces (k,) for a response whose diagonal is 1."""
    count = len(right)
    matrix = 0.5 * (matrix + matrix.T) + SOFT * np.eye(count)
    side = np.zeros(count)
    for turn in range(QUICK + 50 * (count + 1)):
        forces = side * bound
        within = side == 0.0
        if within.any():
            known = right[within] + matrix[np.ix_(within, ~within)] @ forces[~within]
            forces[within] = -np.linalg.solve(matrix[np.ix_(within, within)], known)
        slope = right + matrix @ forces
        leaves = within & (np.abs(forces) > bound * (1.0 + ROUNDED))
        returns = ~within & (side * slope > 0.0)
        wrong = np.flatnonzero(leaves | returns)
        if not wrong.size:
            return np.clip(forces, -bound, bound)
        chosen = wrong if turn < QUICK else wrong[-1:]
        side[chosen] = np.where(leaves[chosen], np.sign(forces[chosen]), 0.0)
    raise InputError("what holds the joints that stick cannot be told: the posture is singular, or nearly")
