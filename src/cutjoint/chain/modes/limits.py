"""Whole turns and joint limits: which of the coordinates that place the links alike is meant, and is it allowed."""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.joints import angles
from cutjoint.chain.kinematics import Kinematics

OPEN = 1e-9
"""A loop is open where a joint turned by a whole turn moves it by more than this [lengths, rad]: it is geared."""
BEYOND = 1e-6
"""How far beyond a limit a joint may be and still count as at it [m, rad]."""


class JointLimits:
    """The joint limits of one robot, seen from the closed configuration `q` (nq,).

    Attributes:
        angles: indices in q of the coordinates that are angles.
        geared: those of them that cannot be turned by a whole turn alone, because others go along.
        geared_velocities: their indices in v.
    """

    def __init__(self, kinematics: Kinematics, q: Array) -> None:
        self._k, self._q = kinematics, q
        model = kinematics.model
        self.angles = angles(model)
        self.geared: set[int] = set()
        velocities = {
            model.idx_qs[joint] + i: model.idx_vs[joint] + i
            for joint in range(1, model.njoints)
            for i in range(model.nvs[joint])
        }
        for index in self.angles:
            turned = q.copy()
            turned[index] += 2.0 * np.pi
            distance, angle, _ = kinematics.at(turned).gap
            if max(distance / kinematics.length, angle) > OPEN:
                self.geared.add(index)
        self.geared_velocities = [velocities[index] for index in sorted(self.geared)]

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
