"""The joints of a posture in numbers: the coordinates of every joint, as a home posture of loops.toml gives them."""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.chain.joints import JOINTS
from cutjoint.description.model import Joint
from cutjoint.description.transforms import rpy_from_rotation
from cutjoint.mechanism import Posture
from cutjoint.mechanism.rotations import matrix_of

AT_LIMIT = 2e-3
"""A joint this near to a limit is said to be at it: twice what a move stops short of one, [rad] or robot lengths."""


def coordinates_of(chain: ClosedChain, at: Posture) -> Mapping[str, tuple[float, ...]]:
    """Coordinates of every joint that moves, by its name in the order of the tree: [m] and [rad]."""
    found: dict[str, tuple[float, ...]] = {}
    for joint in chain.description.joints:
        if joint.type.moves:
            index = chain.model.getJointId(joint.name)
            start = chain.model.idx_qs[index]
            found[joint.name] = _coordinates(joint, at.q_full[start : start + chain.model.nqs[index]])
    return found


def at_limits(chain: ClosedChain, coordinates: Mapping[str, tuple[float, ...]]) -> list[str]:
    """Names of the joints that are at one of their limits, or beyond."""
    found: list[str] = []
    for joint in chain.description.joints:
        if joint.type.limited and joint.name in coordinates:
            (value,) = coordinates[joint.name]
            near = AT_LIMIT * (chain.length if joint.type.slides else 1.0)
            lower, upper = joint.limits.lower, joint.limits.upper
            if (lower is not None and value < lower + near) or (upper is not None and value > upper - near):
                found.append(joint.name)
    return found


def _coordinates(joint: Joint, own: Array) -> tuple[float, ...]:
    """A part of Pinocchio's configuration as the coordinates of its joint: the reverse of `coordinates_to_q`."""
    if JOINTS[joint.type].to_q is None:
        return tuple(own.tolist())
    if "angle" in (names := [one.name for one in joint.type.coordinates]):
        x, y, cosine, sine = own.tolist()
        return x, y, atan2(sine, cosine)
    return (*own[: names.index("roll")].tolist(), *rpy_from_rotation(matrix_of(own[-4:])))
