"""What the friction of joints that stick holds, at states of a run that is over.

A result does not tell it, and it depends on the motion: the rates of joints that stick stay zero.  It is solved for as
in the run (`cutjoint.simulation.stiction`): a joint whose friction is not enough slips the way it is pushed, and where
several joints of one motion stick, the least forces hold it.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.mechanism import Loads, Posture
from cutjoint.simulation.constrained import ConstrainedPlant
from cutjoint.simulation.locks import Locks
from cutjoint.simulation.plant import State
from cutjoint.simulation.stiction import Stiction

RESTS = 1e-9
"""A rate below this part of the largest of the run is that of a joint which sticks."""


class HeldJoints:
    """The joints of a chain that stick.

    Args:
        chain: the robot.
        fastest: largest rate of joints with stiction in the run, [m/s] or [rad/s].
    """

    def __init__(self, chain: ClosedChain, fastest: float) -> None:
        self._chain, self._rest = chain, RESTS * fastest
        self._joints = np.array(list(chain.sticking), dtype=int)

    @cached_property
    def _plant(self) -> ConstrainedPlant:
        """The chain in full coordinates."""
        return ConstrainedPlant(self._chain, project=False)

    def motion(self, at: Posture, v: Array, effort: Array, loads: Loads) -> tuple[Array, Array]:
        """Velocity and effort of all joints, shape (nv,), those that stick at rest and held by their friction.

        Args:
            at: where the robot is.
            v: velocity of all joints, shape (nv,).
            effort: of the actuators, shape (n,).
            loads: from outside.
        """
        full = self._chain.full_effort(effort)
        at_rest = np.abs(v[self._joints]) <= self._rest
        if not at_rest.any():
            return v, full
        v = v.copy()
        v[self._joints[at_rest]] = 0.0
        state, push = State(at.q_full, v), self._chain.full_load_effort(at, loads)
        stiction = Stiction(self._plant, Locks(self._plant, ()), state)
        stiction.settle(state, effort, push)
        full = full.copy()
        full[self._joints[at_rest]] += stiction.forces(state, effort, push)[at_rest]
        return v, full
