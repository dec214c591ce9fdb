"""A joint as MuJoCo has compiled it, as a joint of the tree: type, place, axis, range, and what it does by itself.

Coordinates are the file's: a hinge or slide stands at `ref` where the bodies are as they are written, so `motion_back`
leads from there to where its coordinate is 0.  A spring is at rest at `springref`, which is such a coordinate too.  An
`armature` is what a rotor weighs at the joint.  A `frictionloss` is dry friction that holds what rests; here it acts
fully from a small speed on.
"""

from __future__ import annotations

import math

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.formats.mjcf.compiled import JointRow, Numbers
from cutjoint.description.model import IDENTITY, Joint, JointPhysics, JointType, Limits, Place
from cutjoint.description.numbers import LARGEST_PHYSICS
from cutjoint.description.transforms import from_rotation, rotation_from_quaternion
from cutjoint.findings import LARGEST_LENGTH, Findings, check_range

UNLIMITED = 1e10
"""A range that ends beyond this has no end there."""
TYPES = {
    "hinge": JointType.REVOLUTE,
    "slide": JointType.PRISMATIC,
    "ball": JointType.SPHERICAL,
    "free": JointType.FLOATING,
}


def joint_of(row: JointRow, name: str, body: str, place: Place, findings: Findings) -> Joint:
    """The joint at its point of the body; a free one has dampers alone."""
    what, kind = f"joint '{name}'", row.kind
    single = kind in ("hinge", "slide")
    check_range((*row.position, row.ref, row.spring), what, findings, place, LARGEST_LENGTH)
    damping = linear(row.damping, f"damping of {what}", findings, place)
    stiffness = linear(row.stiffness, f"stiffness of {what}", findings, place)
    check_range((damping, stiffness, row.friction, row.armature), what, findings, place, LARGEST_PHYSICS)
    _doubtful(row, what, findings, place)
    physics = JointPhysics(
        damping, row.friction, None, stiffness, row.spring if stiffness != 0.0 else None, row.armature
    )
    if kind == "free":
        given = {"stiffness": stiffness, "frictionloss": row.friction, "armature": row.armature}
        for key, value in given.items():
            if value != 0.0:
                found = f"{key} {value:g} of the free joint '{name}'"
                findings.error(found, "damping only", "a <freejoint/> does not take the defaults of joints", place)
        physics = JointPhysics(damping=damping)
    limits = Limits(
        *ends(row.range if single else None),
        None,
        even(row.force, f"actuatorfrcrange of {what}", findings, place) if single else None,
    )
    endless = kind == "hinge" and limits.lower is None and limits.upper is None
    return Joint(
        name, JointType.CONTINUOUS if endless else TYPES[kind], body, body, from_rotation(np.eye(3), row.position),
        np.array(row.axis) if single else np.eye(3)[0], limits=limits, physics=physics, place=place,
    )  # fmt: skip


def ends(bounds: Numbers | None) -> tuple[float | None, float | None]:
    """The lower and the upper end of a range, None where it has none there."""
    lower, upper = (None if abs(end) >= UNLIMITED else end for end in bounds or (-math.inf, math.inf))
    return lower, upper


def motion_back(row: JointRow) -> Array:
    """The motion (4, 4) of a joint from its `ref` to 0, at its own point."""
    if row.ref == 0.0:
        return IDENTITY
    axis = np.array(row.axis)
    if row.kind == "slide":
        return from_rotation(np.eye(3), -row.ref * axis)
    half = -0.5 * row.ref
    return from_rotation(rotation_from_quaternion([math.cos(half), *(math.sin(half) * axis)]), np.zeros(3))


def linear(powers: Numbers, what: str, findings: Findings, place: Place) -> float:
    """The first coefficient of a force; doubts higher powers."""
    if any(powers[1:]):
        shown = " ".join(f"{value:g}" for value in powers)
        findings.doubt(f"{what} is {shown}", "a linear force: one number", "leave the higher powers out", place)
    return powers[0]


def even(bounds: Numbers | None, what: str, findings: Findings, place: Place) -> float | None:
    """The size that a range of forces allows; None where there is none.  A range askew is told."""
    if bounds is None or not any(bounds):
        return None
    if bounds[0] > bounds[1]:
        findings.error(f"{what} is upside down: {bounds[0]:g} {bounds[1]:g}", "the lower end first", "", place)
        return None
    if bounds[0] != -bounds[1]:
        findings.warn(f"{what} is {bounds[0]:g} {bounds[1]:g}: not used", "as much force both ways", "", place)
        return None
    return bounds[1] if check_range(bounds, what, findings, place, LARGEST_PHYSICS) else None


def _doubtful(row: JointRow, what: str, findings: Findings, place: Place) -> None:
    """Note what of a joint has no counterpart here."""
    if row.soft:
        mend = f"soft stops are stop_stiffness and stop_damping under [joint.{what[7:-1]}] of a loops.toml"
        findings.warn(f"{', '.join(row.soft)} of {what} not used", "hard limits and dry friction", mend, place)
    if row.range is not None and row.kind == "ball":
        findings.warn(f"range of the ball {what} not used", "a ball that turns freely", "", place)
    if row.springyield != 0.0:
        findings.doubt(f"springyield of {what} is {row.springyield:g}", "a spring that does not yield", "", place)
