"""Screw joints: a hinge and a slide on one axis with a massless link between them, the travel coupled to the angle.

The hinge keeps the joint's name, limits and physics: as in SDF and Drake the coordinate of a screw is its angle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from cutjoint.arrays import Array
from cutjoint.description.model import IDENTITY, Coupling, Joint, JointType, Link
from cutjoint.description.numbers import LARGEST_PHYSICS, read_numbers
from cutjoint.description.xml import Element, only_child
from cutjoint.findings import Findings

SCREW = "screw"
"""What SDF and Drake call it."""
_PITCHES = ("screw_thread_pitch", "thread_pitch")


@dataclass(frozen=True, eq=False)
class Screw:
    """The parts of a screw joint, from its parent to its child."""

    turn: Joint
    nut: Link
    slide: Joint
    coupling: Coupling

    @classmethod
    def of(cls, joint: Joint, lead: float, slide_at: Array = IDENTITY) -> Screw:
        """The hinge `joint` as a screw of `lead` [m/rad]; its slide stands at `slide_at` (4, 4) on the link between."""
        nut, travel = f"{joint.name}_nut", f"{joint.name}_travel"
        slide = Joint(
            travel, JointType.PRISMATIC, nut, joint.child, slide_at, joint.axis, joint.axis2, place=joint.place
        )
        coupling = Coupling.geared(f"{joint.name}_thread", travel, joint.name, lead, 0.0, joint.place)
        return cls(replace(joint, child=nut), Link(nut, place=joint.place), slide, coupling)


def read_lead(element: Element, name: str, findings: Findings) -> float | None:
    """The lead [m/rad] of a screw `<joint>` of SDF, or None after noting why not.

    `screw_thread_pitch` is in metres per turn, positive for a right-handed thread; the older `thread_pitch` in radians
    per metre, positive for a left-handed one (https://github.com/gazebosim/sdformat/pull/1168).
    """
    leads = {}
    for tag in _PITCHES:
        part = only_child(element, tag, findings)
        if part is None:
            continue
        what, line = f"{tag} of joint '{name}'", part.sourceline
        values = read_numbers(part.text, 1, what, findings, line, LARGEST_PHYSICS)
        if values is None:
            return None
        if tag == "thread_pitch" and values[0] == 0.0:
            findings.error(f"{what} is 0", "radians per metre", "a joint that only slides is prismatic", line)
            return None
        leads[tag] = values[0] / math.tau if tag == "screw_thread_pitch" else -1.0 / values[0]
    if not leads:
        found, mend = f"screw joint '{name}' without <screw_thread_pitch>", "read as 1 rad/m left-handed, SDF's default"
        findings.doubt(found, "metres per turn", mend, element.sourceline)
        return -1.0
    if len(leads) == 2 and not math.isclose(*leads.values(), rel_tol=1e-3):
        told = " and ".join(f"{lead * math.tau:g}" for lead in leads.values())
        found = f"the two pitches of joint '{name}' are {told} metres per turn"
        findings.error(found, "one pitch", "keep <screw_thread_pitch>", element.sourceline)
        return None
    return next(iter(leads.values()))
