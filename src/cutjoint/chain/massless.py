"""Motions that move no mass, and of which no run can tell how they go.

Where dampers, friction, springs, stops or bushings act on a motion without inertia, forces on it balance at every
instant and give a velocity, or nothing at all, but no acceleration: that is no equation of motion.  Where the
actuators lead to a posture at which it has some, from nothing, its acceleration jumps on the way.  What carries nothing
anywhere, and is let be, just rests.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.closed_chain import ClosedChain
from cutjoint.chain.dynamics import massless_motions
from cutjoint.chain.joints import joints_of
from cutjoint.chain.rank import null_space
from cutjoint.errors import CutjointError

BENT = 0.1
"""How far actuators go to see what has mass there, in radians or lengths of the robot."""


def undetermined_motions(chain: ClosedChain, q: Array) -> tuple[str, ...]:
    """Joints of the motions without mass at a closed configuration (nq,) that no equation of motion tells, in the order
    of the tree; none where there is no such motion."""
    k = chain._k
    placed = k.at(q)
    motions = massless_motions(k, q, null_space(placed.scaled))
    if not motions.size:
        return ()
    elastic = placed.elastic if k.physics.acts and k.physics.cuts else None
    dragged = k.physics.acts and any(k.physics.drags(one, elastic) for one in (motions * k.column_scale[:, None]).T)
    return joints_of(chain.model, motions) if dragged or _get_mass(chain, q, motions.shape[1]) else ()


def _get_mass(chain: ClosedChain, q: Array, count: int) -> bool:
    """Whether fewer than `count` motions of a configuration (nq,) are without mass a little further on."""
    units = np.array([1.0 if one.kind == "rotation" else chain.length for one in chain.actuators])
    ahead = BENT * np.linspace(0.3, 0.7, chain.n) * units
    try:
        there = chain.close(chain.actuated(q) + ahead, chain.posture(q), limits="ignore").q_full
    except CutjointError:  # the actuators do not lead there, or not alone
        return False
    return bool(massless_motions(chain._k, there, null_space(chain._k.at(there).scaled)).shape[1] < count)
