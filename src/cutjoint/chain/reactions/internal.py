"""The loops' own forces as wrenches on links, and the internal stresses that loops can hold.

The rows of all cuts and couplings are K = G J, with G over the twists of the cut frames (`cutjoint.chain.closure`): a
multiplier f presses with G' f on the bodies that the cuts join.  Where rows are redundant, K' N = 0 for a basis N:
stresses that the loops hold in themselves, whatever the motion.

Rows that are left out for the rounding of exported lengths (`cutjoint.chain.closing.rounding`) hold forces like all
others, but what they hold is balanced by the others only up to that rounding.  So nobody knows their part: they are
taken to hold nothing, and what they could hold is a loose stress, which marks what is not unique.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.rank import Split
from cutjoint.errors import DynamicsError


@dataclass(frozen=True, eq=False)
class CarriedLoops:
    """Forces of all cuts and couplings that make a motion, and how else they could.

    All have 1 + k columns: what does the work with the least multipliers, then the stresses, the loose ones last.

    Attributes:
        on_a, on_b: wrenches of every cut on its bodies about the model's origin, shape (cuts, 6, 1 + k).
        couplings: generalised forces of every coupling on its joint, shape (couplings, 1 + k).
        stresses: k.
        loose: how many of them are loose.
    """

    on_a: Array
    on_b: Array
    couplings: Array
    stresses: int
    loose: int


class LoopForces:
    """Forces of the loops of one robot."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._k = k = kinematics
        own = k.closure
        self._trusted = own.trusted
        self._loose = np.setdiff1d(np.arange(own.all_rows), own.trusted)
        self._row_scale = np.where(own.all_lengths, 1.0 / k.length, 1.0)

    def carrying(self, placed: Placed, pull: Array, size: Array) -> CarriedLoops:
        """Forces that do what the generalised forces `pull` (nv,) do; `size` (nv,) is that of the terms of these.

        Raises:
            DynamicsError: no forces of the loops do.
        """
        k, closure = self._k, self._k.closure
        split = Split.of(placed.scaled)
        least = split.solve_transposed(k.column_scale * pull)
        self._check(placed, pull, size, least)
        exact = np.linalg.svd(placed.scaled)[0][:, split.rank :] if len(least) else np.zeros((0, 0))
        every = np.zeros((closure.all_rows, 1 + exact.shape[1] + self._loose.size))
        every[self._trusted, : 1 + exact.shape[1]] = np.column_stack([least, exact])
        if self._loose.size:
            rows = closure.jacobian_of_all(placed.gather, placed.twists, placed.q)
            rows = rows * self._row_scale[:, None] * k.column_scale
            balanced = -split.solve_transposed(rows[self._loose].T)
            sizes = np.sqrt(1.0 + np.sum(balanced**2, axis=0))
            every[self._trusted, 1 + exact.shape[1] :] = balanced / sizes
            every[self._loose, 1 + exact.shape[1] + np.arange(self._loose.size)] = 1.0 / sizes
        every *= self._row_scale[:, None]
        count, cut_rows, columns = len(closure.cuts), len(placed.gather), every.shape[1]
        on_bodies = (placed.gather.T @ every[:cut_rows]).reshape(2, count, 6, columns)
        return CarriedLoops(on_bodies[0], on_bodies[1], every[cut_rows:], columns - 1, self._loose.size)

    def _check(self, placed: Placed, pull: Array, size: Array, least: Array) -> None:
        k = self._k
        unmet = float(np.abs(k.column_scale * pull - placed.scaled.T @ least).max(initial=0.0))
        terms = float((k.column_scale * size + np.abs(placed.scaled).T @ np.abs(least)).max(initial=0.0))
        if unmet > tolerances.DYNAMICS.value * terms:
            raise DynamicsError(
                f"the joints of {k.name} do not move so with these efforts and loads: {unmet:.3g} of terms of "
                f"{terms:.3g} stays unbalanced (dimensionless in the motions); give the effort that makes this "
                "acceleration, or only one of the two",
                residual=unmet,
            )
