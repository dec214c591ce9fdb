"""Closing frames of onshape-to-robot (https://onshape-to-robot.readthedocs.io, "Handling kinematic loops").

A mate called `closing_NAME` leaves two frames in the URDF, links `closing_NAME_1` and `closing_NAME_2` on fixed joints,
which have to be brought together.  Where the mate was a hinge, the program puts two more frames
0.1 m along its axis z, `closing_NAME_1_z` and `closing_NAME_2_z`: that is a revolute cut.  Else the URDF does not say
what the mate was, and the frames are held together as by the program's own `<connect>`: at a point.
"""

from __future__ import annotations

import re

from cutjoint.description.formats.common.extras import OpenTree, ToldCut
from cutjoint.description.model import CutJoint, CutType, Frame, Link
from cutjoint.findings import Findings

_FRAME = re.compile(r"(closing_.+)_([12])")
LIGHTEST = 1e-6
"""kg.  The program gives frames 0 or 1e-9; what weighs more is a body."""


def closings(tree: OpenTree, findings: Findings) -> list[ToldCut]:
    """The cuts between pairs of closing frames."""
    held = {joint.child for joint in tree.joints if not joint.type.moves}
    frames = {link.name: link for link in tree.links if link.name in held and _is_frame(link)}
    cuts = []
    for name, link in frames.items():
        match = _FRAME.fullmatch(name)
        if match is None:
            continue
        mate, end = match.groups()
        other = f"{mate}_{3 - int(end)}"
        if other not in frames:
            found = f"closing frame '{name}' without '{other}': which loop does it close?"
            findings.doubt(found, "a pair of frames, on fixed joints", "add the other, or rename this link", link.place)
        elif end == "1":
            cuts.append(_told(mate, frames))
    return cuts


def _is_frame(link: Link) -> bool:
    return link.name.startswith("closing_") and (link.inertial is None or link.inertial.mass <= LIGHTEST)


def _told(mate: str, frames: dict[str, Link]) -> ToldCut:
    hinge = f"{mate}_1_z" in frames and f"{mate}_2_z" in frames
    kind = CutType.REVOLUTE if hinge else CutType.SPHERICAL
    odd = (
        f"closing frames '{mate}_1' and '{mate}_2' are held together at a point",
        "the type of the mate, which the file does not say",
        "give another type between these two links in the cuts of a loops.toml",
    )
    cut = CutJoint(mate, kind, Frame(f"{mate}_1"), Frame(f"{mate}_2"), frames[f"{mate}_1"].place)
    return ToldCut(cut, None if hinge else odd)
