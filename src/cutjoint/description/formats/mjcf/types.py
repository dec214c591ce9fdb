"""What the types of joints and cut joints are made of in MJCF: hinges, slides and balls, `<connect>` and `<weld>`."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.cuts import CutType, Kind
from cutjoint.description.formats.common.exact import unsaid
from cutjoint.description.joints import JointType
from cutjoint.description.model import CutJoint, Joint

MADE_OF: Mapping[JointType, tuple[str, ...]] = {
    JointType.FIXED: (),
    JointType.REVOLUTE: ("hinge",),
    JointType.CONTINUOUS: ("hinge",),
    JointType.PRISMATIC: ("slide",),
    JointType.UNIVERSAL: ("hinge", "hinge"),
    JointType.SPHERICAL: ("ball",),
    JointType.PLANAR: ("slide", "slide", "hinge"),
    JointType.FLOATING: ("slide", "slide", "slide", "ball"),
}
"""Joint type -> the joints of MuJoCo that make it, called X, X/2, X/3, ...; a free joint is more than it needs."""

NUMBERS: Mapping[str, int] = {"hinge": 1, "slide": 1, "ball": 4}
"""Joint of MuJoCo -> its numbers in a qpos."""

EQUALITIES: Mapping[str, CutType] = {"connect": CutType.SPHERICAL, "weld": CutType.FIXED}

NUMBERED = re.compile(r"#\d+$")
"""What the name of a coupling ends with among the equalities of cutjoint's own."""
OWN = "cutjoint:"
"""Names of what cutjoint's writer adds to close loops; the cuts themselves are among the extras."""
TENDON = "tendon:"
"""Names of the links without mass that stand for lengths of tendons begin so."""

Part = tuple[str, Array | None]
"""A joint of MuJoCo and its axis, None for a ball."""


def parts(joint: Joint) -> list[Part]:
    """The joints of MuJoCo that make one of the tree, in the order in which they act.

    Raises:
        InputError: MJCF cannot say its type.
    """
    if joint.type not in MADE_OF:
        raise unsaid("MJCF", joint)
    kinds = MADE_OF[joint.type]
    slides = {1: [joint.axis], 2: _plane(joint.axis), 3: list(np.eye(3))}.get(kinds.count("slide"), [])
    axes = {"slide": iter(slides), "hinge": iter((joint.axis, joint.axis2))}
    return [(kind, next(axes[kind]) if kind in axes else None) for kind in kinds]


def has_carrier(cut: CutJoint) -> bool:
    """Whether a cut needs a body of its own, since equalities cannot say its type."""
    plain = cut.type in EQUALITIES.values() or cut.type.has_length or cut.type.kinds == (Kind.POINT, Kind.HINGE)
    return cut.bushing is None and not plain


def carrier_parts(cut: CutJoint) -> list[Part]:
    """The joints of MuJoCo between frame A and a body that moves as frame B may: slides first, then turns.

    Raises:
        InputError: MJCF cannot say its type.
    """
    equations = cut.type.equations
    turning = [one for one in equations if not one.is_length]
    held = {axis for one in equations if one.kind is Kind.SLIDE for axis in one.axes}
    if any(one.kind is Kind.POINT for one in equations):
        held = {0, 1, 2}
    slides: list[Part] = [("slide", axis) for number, axis in enumerate(np.eye(3)) if number not in held]
    match [one.kind for one in turning]:
        case []:
            return [*slides, ("ball", None)]
        case [Kind.LOCK]:
            return slides
        case [Kind.HINGE]:
            return [*slides, ("hinge", np.eye(3)[2])]
        case [Kind.DOT] if turning[0].axes[0] != turning[0].axes[1]:  # else two hinges would be one
            return [*slides, *(("hinge", np.eye(3)[axis]) for axis in turning[0].axes)]
    raise unsaid("MJCF", cut)


def _plane(normal: Array) -> list[Array]:
    """Two directions that span the plane, the x and y of the smallest turn that brings z to its normal."""
    x, y, z = (float(value) for value in normal)
    if z < -1.0 + 1e-12:
        return [np.array([1.0, 0.0, 0.0]), np.array([0.0, -1.0, 0.0])]
    scale = 1.0 / (1.0 + z)
    return [np.array([1.0 - x * x * scale, -x * y * scale, -x]), np.array([-x * y * scale, 1.0 - y * y * scale, -y])]
