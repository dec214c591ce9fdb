"""A configuration of the open tree as MuJoCo's `qpos`, and back.

A robot that was read from MJCF has the coordinates of its file, so nothing is computed but the order of a quaternion
(MuJoCo has its scalar part first), the angle of what slides and turns in a plane, and the place of a free body, which
MuJoCo gives in the world.  Joints follow each other depth first in both.  Lengths of tendons, which are joints here,
are no coordinates in MuJoCo.  Coordinates of the bodies that an exported file has for universal and prismatic cuts are
none here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from cutjoint.arrays import Array, as_vector
from cutjoint.chain.bound import BoundCoupling
from cutjoint.chain.joints import JOINTS, flies
from cutjoint.description.formats.mjcf.types import NUMBERS, OWN, TENDON, carrier_parts, has_carrier
from cutjoint.description.model import Joint, RobotDescription
from cutjoint.description.transforms import inverse
from cutjoint.errors import InputError

WORLD = "world"


class _Ordered(NamedTuple):
    """A joint, where its coordinates are in a configuration and in a qpos, how they are written and read, and whether
    MuJoCo counts them in the world."""

    joint: Joint
    here: slice
    there: slice
    write: Callable[[Array], Array] | None
    read: Callable[[Array], Array] | None
    free: bool


class MujocoOrder:
    """Where the coordinates of each joint are on both sides.

    Attributes:
        size: of a qpos.
    """

    def __init__(self, model: pin.Model, description: RobotDescription) -> None:
        joints = {joint.name: joint for joint in description.joints}
        self._rows: list[_Ordered] = []
        self._nq, self.size = int(model.nq), 0
        for index in range(1, model.njoints):
            joint = joints[model.names[index]]
            if not joint.child.startswith(TENDON):
                start, row = int(model.idx_qs[index]), JOINTS[joint.type]
                here = slice(start, start + int(model.nqs[index]))
                count = len((row.to_mujoco or np.array)(np.ones(here.stop - start)))
                # the coordinates of a free joint of MJCF are in the world
                free = flies(model, index) and joint.parent == description.root == WORLD
                there = slice(self.size, self.size + count)
                self._rows.append(_Ordered(joint, here, there, row.to_mujoco, row.from_mujoco, free))
                self.size = there.stop
        tendons = {joint.name for joint in description.joints if joint.child.startswith(TENDON)}
        self._cuts = description.cuts
        self._lengths = [BoundCoupling.of(model, one) for one in description.couplings if one.joint in tendons]

    def configuration(self, qpos: npt.ArrayLike) -> Array:
        """The configuration (nq,) of a qpos (size,); quaternions need not have length 1, as in MuJoCo.

        Raises:
            InputError: wrong shape, not finite, or a quaternion of zeros.
        """
        self._refuse_carriers(np.size(qpos))
        values, q = as_vector("qpos", qpos, self.size), np.zeros(self._nq)
        for one in self._rows:
            part = values[one.there] if one.read is None else one.read(values[one.there])
            if not np.isfinite(part).all():
                name = one.joint.name
                raise InputError(f"qpos has the quaternion 0 0 0 0 for joint '{name}'; no rotation is 1 0 0 0")
            q[one.here] = _seen_from(inverse(one.joint.placement), part) if one.free else part
        for length in self._lengths:
            q[length.q_index[0]] = -length.residual(q)
        return q

    def _refuse_carriers(self, count: int) -> None:
        """Raises InputError for the qpos of an exported file with bodies for cuts."""
        carried = [cut for cut in self._cuts if has_carrier(cut)]
        if count > self.size and carried:
            more = sum(NUMBERS[kind] for cut in carried for kind, _ in carrier_parts(cut))
            if count == self.size + more:
                names = ", ".join(f"{OWN}{cut.name}" for cut in carried)
                raise InputError(
                    f"qpos has {count} numbers, {self.size} of the robot and {more} of bodies that the exported file "
                    f"has for its cuts; leave out those of the joints {names} (and /2, /3 of each)"
                )

    def qpos(self, q: Array) -> Array:
        """The qpos (size,) of a configuration (nq,)."""
        values = np.zeros(self.size)
        for one in self._rows:
            part = _seen_from(one.joint.placement, q[one.here]) if one.free else q[one.here]
            values[one.there] = part if one.write is None else one.write(part)
        return values


def _seen_from(frame: Array, part: Array) -> Array:
    """Place and quaternion (x, y, z, w) after a placement (4, 4), with the sign that the quaternion has."""
    before = pin.Quaternion(np.array(frame[:3, :3]))
    return np.concatenate([frame[:3, :3] @ part[:3] + frame[:3, 3], (before * pin.Quaternion(part[3:])).coeffs()])
