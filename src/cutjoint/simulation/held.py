"""What the friction of joints that stick holds, at states of a run that is over.

A result does not tell it, and it depends on the motion: the rates of joints that stick stay zero.  Accelerations are
affine in the forces, so those that hold are solved for, as the run did (`cutjoint.simulation.stiction`); a joint whose
friction is not enough slips the way it is pushed.  Where several joints of one motion stick, the least forces hold it.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.mechanism import Loads, Posture

RESTS = 1e-9
"""A rate below this part of the largest of the run is that of a joint which sticks."""
ENOUGH = 1e-9
"""By what part a force may exceed the friction that holds it, for rounding."""


def with_held(
    chain: ClosedChain, at: Posture, motion: tuple[Array, Array], loads: Loads, fastest: float
) -> tuple[Array, Array]:
    """Velocity and effort of all joints, shape (nv,), those that stick at rest and held by their friction.

    Args:
        motion: velocity and effort of all joints without it.
        fastest: largest rate of joints with stiction in the run, [m/s] or [rad/s].
    """
    v, effort = (one.copy() for one in motion)
    index = np.array([i for i in chain.sticking if abs(v[i]) <= RESTS * fastest], dtype=int)
    if not index.size:
        return v, effort
    v[index] = 0.0
    friction = np.array([chain.sticking[int(i)] for i in index])

    def accelerates(forces: Array) -> Array:
        given = effort.copy()
        given[index] += forces
        return np.asarray(chain.full_forward_dynamics(at, v, given, loads).acceleration[index])

    free = accelerates(np.zeros(len(index)))
    per_force = np.column_stack(
        [(accelerates(one) - free) / size for one, size in zip(np.diag(friction), friction, strict=True)]
    )
    forces, sticks = np.zeros(len(index)), np.ones(len(index), dtype=bool)
    while sticks.any():
        wanted = -(free + per_force[:, ~sticks] @ forces[~sticks])
        own = per_force[np.ix_(sticks, sticks)] * friction[sticks]
        forces[sticks] = friction[sticks] * np.linalg.lstsq(own, wanted[sticks], rcond=RESTS)[0]
        excess = np.where(sticks, np.abs(forces) / friction - 1.0, -1.0)
        worst = int(excess.argmax())
        if excess[worst] <= ENOUGH:
            break
        sticks[worst] = False
        forces[worst] = friction[worst] * np.sign(forces[worst])
    effort[index] += forces
    return v, effort
