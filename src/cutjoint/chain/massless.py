"""Motions that move no mass while something acts on them by itself: what no run can tell.

Where dampers, friction, springs, stops or bushings act on a motion without inertia, forces on it balance at every
instant and give a velocity, or nothing at all, but no acceleration: that is no equation of motion.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.closed_chain import ClosedChain
from cutjoint.chain.dynamics import massless_motions
from cutjoint.chain.joints import joints_of
from cutjoint.chain.rank import null_space


def dragged_massless(chain: ClosedChain, q: Array) -> tuple[str, ...]:
    """Joints of the motions that move no mass at a closed configuration (nq,), and on which joint physics acts, in the
    tree's order; none where there is no such motion."""
    k = chain._k
    if not k.physics.acts:
        return ()
    placed = k.at(q)
    motions = massless_motions(k, q, null_space(placed.scaled))
    elastic = placed.elastic if k.physics.cuts else None
    dragged = [one for one in motions.T if k.physics.drags(one * k.column_scale, elastic)]
    return joints_of(chain.model, np.column_stack(dragged)) if dragged else ()
