"""The tree of a robot at one configuration, as a value: it holds its own arrays and never changes."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.closure import CutFrames

if TYPE_CHECKING:
    from cutjoint.chain.kinematics import Kinematics

_UNIT = np.eye(6)


class Placed:
    """The tree at one configuration.

    Attributes:
        q: configuration, shape (nq,).
        twists: joint Jacobians about the origin in its axes, shape (6, nv).
        frames: of the cuts.
    """

    def __init__(self, kinematics: Kinematics, q: Array, placements: Array, twists: Array) -> None:
        k = self._k = kinematics
        self.q, self.twists = q, twists
        count = len(k.closure.cuts)
        axes, at = placements[:, :3, :3], placements[:, :3, 3]
        self.frames = CutFrames(axes[:count], axes[count : 2 * count], at[:count], at[count : 2 * count])
        self._tool_axes: Array = axes[-1]
        self._tool_at: Array = at[-1]

    @cached_property
    def gather(self) -> Array:
        """G of `cutjoint.chain.closure`, shape (cut rows, 12 cuts)."""
        return self._k.closure.gather(self.frames)

    @cached_property
    def jacobian(self) -> Array:
        """Of all rows, [m] and [rad] per velocity, shape (rows, nv)."""
        return self._k.closure.jacobian(self.gather, self.twists)

    @cached_property
    def scaled(self) -> Array:
        """The same, dimensionless."""
        return np.asarray(self.jacobian * self._k.scale)

    @cached_property
    def residual_of_all(self) -> Array:
        """Residual of all rows, also of those that are left out, [m] and [rad]."""
        return self._k.closure.residual(self.frames, self.q)

    @property
    def residual(self) -> Array:
        """Residual of the rows, shape (rows,), [m] and [rad]."""
        return self._k.closure.kept(self.residual_of_all)

    @property
    def gap(self) -> tuple[float, float, str]:
        """Worst distance [m] and angle [rad] of any cut, and the name of the worst cut."""
        lengths, angles = self._k.closure.gaps(self.residual_of_all)
        if not len(lengths):
            return 0.0, 0.0, ""
        worst = int(np.argmax(lengths / self._k.length + angles))
        return float(lengths.max()), float(angles.max()), self._k.closure.names[worst]

    @property
    def tool(self) -> pin.SE3:
        """Placement of the tool frame in the model, away from the world by its origin."""
        return pin.SE3(self._tool_axes, self._tool_at)

    @property
    def tool_position(self) -> Array:
        """Of the tool point in the model, shape (3,) [m]."""
        return self._tool_at

    @property
    def tool_jacobian(self) -> Array:
        """Linear velocity of the tool point and angular velocity of its body per velocity, shape (6, nv)."""
        assert self._k.tool_support is not None
        x, y, z = self._tool_at.tolist()
        shift = _UNIT.copy()
        shift[0, 4], shift[0, 5], shift[1, 5] = z, -y, x
        shift[1, 3], shift[2, 3], shift[2, 4] = -z, y, -x
        return np.asarray(shift.dot(self.twists * self._k.tool_support))


class Moving(Placed):
    """The tree at one configuration and velocity.

    Attributes:
        v: velocity, shape (nv,).
        rates: time derivatives of the joint Jacobians, shape (6, nv).
    """

    def __init__(
        self, kinematics: Kinematics, q: Array, v: Array, placements: Array, twists: Array, rates: Array
    ) -> None:
        super().__init__(kinematics, q, placements, twists)
        self.v, self.rates = v, rates

    @property
    def drift(self) -> Array:
        """Time derivative of the constraint Jacobian times v, shape (rows,), [m/s2] and [rad/s2]."""
        return self._k.closure.drift(self.frames, self.gather, self.twists, self.rates, self.v)

    @property
    def tool_drift(self) -> Array:
        """Classical acceleration of the tool point with zero joint accelerations, shape (3,) [m/s2]."""
        assert self._k.tool_support is not None
        masked = self._k.tool_support * self.v
        twist, rate = self.twists @ masked, self.rates @ masked
        velocity = twist[:3] + np.cross(twist[3:], self._tool_at)
        classical: Array = rate[:3] + np.cross(rate[3:], self._tool_at) + np.cross(twist[3:], velocity)
        return classical
