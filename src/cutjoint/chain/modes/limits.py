"""Whole turns and joint limits: which of the coordinates that place the links alike is meant, is it allowed, and where
a search starts.

Starts are random: every joint anywhere it can be.  Limited joints start within their limits, turning ones anywhere in a
turn (in two turns behind a gear), sliding ones within the size of the robot around where they are, ball joints and free
bodies in any orientation (uniform on SO(3)), free bodies anywhere within the size of the robot around its middle.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.build import UNBOUNDED
from cutjoint.chain.joints import JOINTS, angles, type_of
from cutjoint.chain.kinematics import Kinematics

OPEN = 1e-9
"""A loop is open where a joint turned by a whole turn moves it by more than this [lengths, rad]: it is geared."""
BEYOND = 1e-6
"""How far beyond a limit a joint may be and still count as at it [m, rad]."""
SEED = 0
"""Every search draws the same numbers; what it finds must not depend on them."""


class JointLimits:
    """The joint limits of one robot, seen from the closed configuration `q` (nq,).

    Attributes:
        angles: indices in q of the coordinates that are angles, each with its index in v.
        geared: those of them that cannot be turned by a whole turn alone, because others go along.
        geared_velocities: their indices in v.
    """

    def __init__(self, kinematics: Kinematics, q: Array) -> None:
        self._k, self._q = kinematics, q
        self.angles = angles(kinematics.model)
        # a curve may take the same value a turn later, and still not everywhere
        self.geared = {index for one in kinematics.closure.couplings for index in one.q_index if index in self.angles}
        for index in self.angles:
            turned = q.copy()
            turned[index] += 2.0 * np.pi
            distance, angle, _ = kinematics.at(turned).gap
            if max(distance / kinematics.length, angle) > OPEN:
                self.geared.add(index)
        self.geared_velocities = [self.angles[index] for index in sorted(self.geared)]

    def turned_back(self, q: Array) -> Array:
        """`q` with every angle that is not geared as near to the one it is seen from as its limits allow."""
        turned = q.copy()
        for index in self.angles:
            if index not in self.geared:
                turned[index] = self._near(index, float(q[index]))
        return turned

    def allow(self, q: Array, joint: int) -> bool:
        """Whether a joint is within its limits."""
        model = self._k.model
        if model.nqs[joint] != 1:
            return True
        index = model.idx_qs[joint]
        lower, upper = model.lowerPositionLimit[index], model.upperPositionLimit[index]
        return bool(lower > upper or lower - BEYOND <= q[index] <= upper + BEYOND)

    def _near(self, index: int, value: float) -> float:
        model, turn, first = self._k.model, 2.0 * np.pi, float(self._q[index])
        lower, upper = model.lowerPositionLimit[index], model.upperPositionLimit[index]
        value = first + (value - first + np.pi) % turn - np.pi
        if value < lower and value + turn <= upper:
            return value + turn
        return value - turn if value > upper and value - turn >= lower else value


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
