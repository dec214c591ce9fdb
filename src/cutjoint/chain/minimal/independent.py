"""Independent velocities of a robot: those of some of its joints, which may have several coordinates each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.closing.drivers import Driver
from cutjoint.chain.joints import JOINTS, type_of
from cutjoint.chain.kinematics import Kinematics, Placed


class Independent:
    """The joints whose velocities are independent; the counterpart of `cutjoint.chain.postures.Actuated`.

    Args:
        kinematics: of the robot.
        joints: their names, in the order of the coordinates.

    Attributes:
        joints: the same.
        names, units: of every velocity's coordinate, the unit `m` or `rad`.
        n: number of velocities.
        q_index, v_index: of them in a configuration and in a velocity; there are more of the first where bodies turn.
        passive: indices of all other velocities, shape (nv - n,).
        selection: rows of the unit matrix, shape (n, nv).
        lengths: whether each coordinate is a length, shape (n,).
        flat: whether the coordinates are numbers of the configuration.
    """

    told = "minimal coordinates"
    """What messages call them."""

    def __init__(self, kinematics: Kinematics, joints: Sequence[str]) -> None:
        model, self.k, self.joints = kinematics.model, kinematics, tuple(joints)
        q_index, v_index, lengths, names, flat = list[int](), list[int](), list[bool](), list[str](), True
        for name in joints:
            joint = model.getJointId(name)
            kind = type_of(model, joint)
            q_index += range(model.idx_qs[joint], model.idx_qs[joint] + model.nqs[joint])
            v_index += range(model.idx_vs[joint], model.idx_vs[joint] + model.nvs[joint])
            lengths += kind.lengths
            names += [name] if kind.single else [f"{name} {label}" for label in JOINTS[kind].rates]
            flat = flat and JOINTS[kind].to_q is None
        self.names, self.flat, self.n = tuple(names), flat, len(v_index)
        self.units = tuple("m" if one else "rad" for one in lengths)
        self.q_index, self.v_index = np.array(q_index, dtype=int), np.array(v_index, dtype=int)
        self.passive = np.setdiff1d(np.arange(model.nv), self.v_index)
        self.selection: Array = np.eye(model.nv)[self.v_index]
        self.lengths = np.array(lengths, dtype=bool)

    def of(self, q: Array) -> Array:
        """What a configuration (nq,) has of them."""
        return np.asarray(q[self.q_index])

    def show(self, values: Array) -> str:
        """The same in words."""
        return f"{', '.join(self.joints)} = {np.array2string(values, precision=6, separator=', ')}"

    def moved(self, q: Array, change: Array) -> Array:
        """The configuration (nq,) with these joints moved by `change` (n,), and no other."""
        return self.k.tree.integrate(q, np.asarray(change @ self.selection, dtype=np.float64))

    def lead(self, foot: Array, origin: Array, goal: Array) -> ChangeDriver:
        """Leads the joints from `foot` (nq,) moved by `origin` (n,) to `foot` moved by `goal` (n,)."""
        return ChangeDriver(self, foot, origin, goal)

    def hold(self, q: Array) -> ChangeDriver:
        """Keeps the joints as a configuration (nq,) has them."""
        still = np.zeros(self.n)
        return self.lead(q, still, still)


class ChangeDriver(Driver):
    """Prescribes the independent joints, on a way that is straight in their velocities."""

    def __init__(self, own: Independent, foot: Array, origin: Array, goal: Array) -> None:
        self._own, self._foot, self._origin, self._goal = own, foot, origin, goal
        self.is_length = own.lengths
        self._target = own.moved(foot, goal)

    def error(self, placed: Placed, fraction: float) -> Array:
        own = self._own
        return np.asarray(own.k.tree.difference(self._wanted(fraction), placed.q)[own.v_index])

    def jacobian(self, placed: Placed, fraction: float = 1.0) -> Array:
        return self._own.selection

    def put(self, q: Array, fraction: float) -> None:
        q[self._own.q_index] = self._wanted(fraction)[self._own.q_index]

    def _wanted(self, fraction: float) -> Array:
        if fraction == 1.0:
            return self._target
        return self._own.moved(self._foot, self._origin + fraction * (self._goal - self._origin))
