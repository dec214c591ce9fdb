"""Random starts for a search: every joint anywhere it can be.

Limited joints start within their limits, turning ones anywhere in a turn (in two turns behind a gear), sliding ones
within the size of the robot around where they are, ball joints and free bodies in any orientation (uniform on SO(3)),
free bodies anywhere within the size of the robot around its middle.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.build import UNBOUNDED
from cutjoint.chain.joints import JOINTS, type_of
from cutjoint.chain.kinematics import Kinematics
from cutjoint.chain.modes.limits import JointLimits

SEED = 0
"""Every search draws the same numbers; what it finds must not depend on them."""


class Starts:
    """Draws configurations around `q` (nq,); the same ones in every run."""

    def __init__(self, kinematics: Kinematics, limits: JointLimits, q: Array) -> None:
        model = kinematics.model
        self._model, self._q = model, q
        axes, at = kinematics.tree.bodies(q)
        places = at[1:]
        middle = np.mean(places, axis=0) if len(places) else np.zeros(3)
        apart = max((float(np.linalg.norm(place - middle)) for place in places), default=0.0)
        self._reach = max(apart, kinematics.length) + kinematics.length
        self._middle = [
            model.jointPlacements[joint].actInv(axes[parent].T @ (middle - at[parent]))
            for joint in range(1, model.njoints)
            if (parent := model.parents[joint]) >= 0
        ]
        self._random = np.random.default_rng(SEED)
        self._turns = {index: 2.0 if index in limits.geared else 1.0 for index in limits.angles}

    def draw(self, joints: Iterable[int], q: Array) -> Array:
        """`q` (nq,) with these joints anywhere they can be."""
        drawn = q.copy()
        for joint in joints:
            where = slice(self._model.idx_qs[joint], self._model.idx_qs[joint] + self._model.nqs[joint])
            drawn[where] = self._anywhere(joint, where)
        return drawn

    def _anywhere(self, joint: int, where: slice) -> Array:
        anywhere = JOINTS[type_of(self._model, joint)].anywhere
        if anywhere is not None:
            return anywhere(self._random, self._middle[joint - 1], self._reach)
        uniform = self._random.uniform
        return np.array([uniform(*self._range(index)) for index in range(where.start, where.stop)])

    def _range(self, index: int) -> tuple[float, float]:
        """Where to look for a single coordinate."""
        model, centre = self._model, float(self._q[index])
        lower, upper = float(model.lowerPositionLimit[index]), float(model.upperPositionLimit[index])
        low, high = lower > -UNBOUNDED, upper < UNBOUNDED
        half = np.pi * self._turns[index] if index in self._turns else self._reach
        if low and high and (index not in self._turns or upper - lower <= 2.0 * half):
            return lower, max(lower, upper)
        if low:
            centre = max(centre, lower + half)
        if high:
            centre = min(centre, upper - half)
        return centre - half, centre + half
