"""A configuration of the open tree as MuJoCo's `qpos`, and back.

A robot that was read from MJCF has the coordinates of its file, so nothing is computed but the order of a quaternion
(MuJoCo has its scalar part first), the angle of what slides and turns in a plane, and the place of a free body, which
MuJoCo gives in the world.  Joints follow each other depth first in both.  Lengths of tendons, which are joints here,
are no coordinates in MuJoCo.  Coordinates of the bodies that an exported file has for universal and prismatic cuts are
none here.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from cutjoint.arrays import Array, as_vector
from cutjoint.chain.bound import BoundCoupling
from cutjoint.description.formats.mjcf.types import NUMBERS, OWN, TENDON, carrier_parts, has_carrier
from cutjoint.description.model import Joint, JointType, RobotDescription
from cutjoint.description.transforms import inverse
from cutjoint.errors import InputError

WORLD = "world"


class MujocoOrder:
    """Where the coordinates of each joint are on both sides.

    Attributes:
        size: of a qpos.
    """

    def __init__(self, model: pin.Model, description: RobotDescription) -> None:
        joints = {joint.name: joint for joint in description.joints}
        self._rows: list[tuple[Joint, slice, slice]] = []
        self._free = {name for name, one in joints.items() if _is_free(one, description)}
        self._nq, self.size = int(model.nq), 0
        for index in range(1, model.njoints):
            joint = joints[model.names[index]]
            if not joint.child.startswith(TENDON):
                start, count = int(model.idx_qs[index]), int(model.nqs[index])
                there = count - (joint.type is JointType.PLANAR)
                self._rows.append((joint, slice(start, start + count), slice(self.size, self.size + there)))
                self.size += there
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
        for joint, here, there in self._rows:
            part = values[there]
            if joint.name in self._free:
                q[here] = _seen_from(inverse(joint.placement), part[:3], _quaternion(part[3:], joint))
            elif joint.type in (JointType.SPHERICAL, JointType.FLOATING):
                q[here] = [*part[:-4], *_quaternion(part[-4:], joint).coeffs()]
            elif joint.type is JointType.PLANAR:
                q[here] = [part[0], part[1], np.cos(part[2]), np.sin(part[2])]
            else:
                q[here] = part
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
        for joint, here, there in self._rows:
            part = q[here]
            if joint.name in self._free:
                part = _seen_from(joint.placement, part[:3], pin.Quaternion(part[3:]))
            if joint.type in (JointType.SPHERICAL, JointType.FLOATING):
                values[there] = [*part[:-4], part[-1], *part[-4:-1]]
            elif joint.type is JointType.PLANAR:
                values[there] = [part[0], part[1], np.arctan2(part[3], part[2])]
            else:
                values[there] = part
        return values


def _is_free(joint: Joint, description: RobotDescription) -> bool:
    """Whether MJCF has it as a free joint, whose coordinates are in the world."""
    return joint.type is JointType.FLOATING and joint.parent == description.root == WORLD


def _seen_from(frame: Array, place: Array, turn: pin.Quaternion) -> Array:
    """Place and quaternion (x, y, z, w) after a placement (4, 4), with the sign that the quaternion has."""
    before = pin.Quaternion(np.array(frame[:3, :3]))
    return np.concatenate([frame[:3, :3] @ place + frame[:3, 3], (before * turn).coeffs()])


def _quaternion(values: Array, joint: Joint) -> pin.Quaternion:
    """MuJoCo's quaternion (w, x, y, z), made of length 1."""
    length = float(np.linalg.norm(values))
    if not length > 0.0:
        raise InputError(f"qpos has the quaternion 0 0 0 0 for joint '{joint.name}'; no rotation is 1 0 0 0")
    w, x, y, z = values / length
    return pin.Quaternion(w, x, y, z)
