"""Inertias that a rigid body can have.

Mass is positive (or zero with no inertia at all: a mere frame).  The tensor about the centre of mass is symmetric,
positive semidefinite and obeys the triangle inequality: no principal moment exceeds the sum of the other two.  Equality
is allowed, since a thin rod has moments (0, I, I) and a thin plate (a, b, a + b).
"""

from __future__ import annotations

import numpy as np

from cutjoint.description.model import Inertial, Joint, Place, RobotDescription
from cutjoint.findings import Findings

HEAVY = 2.0e4
"""kg.  The moving platform of a large flight simulator has about 15 t."""
MOST_HELD_UP = 1e3
"""Times a link's weight: a balloon rises with some ten times its own."""
LIGHTEST = 1e-9
"""kg.  Less than a microgram, but not zero, only spoils the arithmetic."""
ROUNDING = 2e-3
"""Relative to the trace: what rounding to three digits, as CAD exports have it, can break of either inequality."""

NOISE = 1e-12
"""m2.  Times the mass: moments below it are rounding noise around 0."""


def check_inertias(robot: RobotDescription, findings: Findings) -> None:
    """Note inertias that no body can have, in the tree and in the variants, and shares of weights that are none."""
    for link in robot.links:
        if link.inertial is not None:
            _check(link.inertial, f"link '{link.name}'", findings, link.place)
        if not 0.0 <= link.gravity_compensation <= MOST_HELD_UP:
            found = f"gravity compensation of link '{link.name}' is {link.gravity_compensation:g} of its weight"
            findings.error(found, f"a share from 0 (none) to {MOST_HELD_UP:g}; 1 is all", "", link.place)
    for variant in robot.variants:
        for name, inertial in variant.inertials.items():
            place = robot.places.get(f"variant.{variant.name}", Place())
            _check(inertial, f"link '{name}' in variant '{variant.name}'", findings, place)


def _check(inertial: Inertial, what: str, findings: Findings, place: Place) -> None:
    values = np.concatenate([[inertial.mass], inertial.com, inertial.inertia.ravel()])
    if not np.isfinite(values).all():
        findings.error(f"inertia of {what} is not finite", "finite numbers", "", place)
        return
    if inertial.mass < 0.0:
        findings.error(f"mass of {what} is {inertial.mass:g} kg", "a mass >= 0", "", place)
    elif 0.0 < inertial.mass < LIGHTEST:
        expected = f"0 or at least {LIGHTEST:g} kg"
        findings.error(f"mass of {what} is {inertial.mass:g} kg", expected, "check the units", place)
    elif inertial.mass > HEAVY:
        findings.warn(
            f"mass of {what} is {inertial.mass / 1000.0:.6g} t", f"less than {HEAVY / 1000.0:g} t",
            "grams for kilograms?", place,
        )  # fmt: skip
    tensor = inertial.inertia
    trace = float(np.abs(np.diag(tensor)).sum())
    if float(np.abs(tensor - tensor.T).max()) > 1e-9 * trace:
        findings.error(f"inertia of {what} is not symmetric", "a symmetric tensor", "", place)
        return
    moments = np.linalg.eigvalsh(tensor)
    shown = ", ".join(f"{moment:.6g}" for moment in moments)
    slack = ROUNDING * float(np.abs(moments).max()) + NOISE * inertial.mass
    if moments[0] < -slack:
        found = f"inertia of {what} is not positive: principal moments {shown} kg m2"
        findings.doubt(found, "none below 0", "check signs of the products of inertia", place)
    elif moments[2] > moments[0] + moments[1] + slack:
        findings.doubt(
            f"inertia of {what} breaks the triangle inequality: principal moments {shown} kg m2",
            "the largest at most the sum of the other two",
            "no body has these; was it taken about another point than the centre of mass?",
            place,
        )
    if inertial.mass == 0.0 and moments[2] > 0.0:
        found = f"{what} has no mass but moments of inertia {shown} kg m2: not used"
        findings.warn(found, "a mass > 0, or no inertia", "", place)


def check_moved_mass(robot: RobotDescription, findings: Findings) -> None:
    """Note joints that move nothing with mass: the mass matrix is singular there.  The tree must be sound.

    What others drive through a coupling needs no mass of its own.
    """
    driven = {coupling.joint for coupling in robot.couplings}
    carries = {link.name: link.inertial is not None and link.inertial.mass > 0.0 for link in robot.links}
    for joint in _leaves_first(robot):
        if carries[joint.child]:
            carries[joint.parent] = True
        elif joint.type.moves and joint.name not in driven:
            findings.warn(
                f"joint '{joint.name}' moves nothing that has mass",
                "mass somewhere below each moving joint",
                "forward dynamics needs it; give a link an <inertial>",
                joint.place,
            )


def _leaves_first(robot: RobotDescription) -> list[Joint]:
    below: dict[str, list[Joint]] = {}
    for joint in robot.joints:
        below.setdefault(joint.parent, []).append(joint)
    order: list[Joint] = []
    stack = [robot.root]
    while stack:
        for joint in below.get(stack.pop(), []):
            order.append(joint)
            stack.append(joint.child)
    return order[::-1]
