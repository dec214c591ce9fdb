"""URDFs whose links have several joints above them: one of these carries the link, the others become cuts.

Plain URDF is a tree; files that close loops by a further joint above a link are read as graphs.  A joint of a URDF has
the frame of its child, so such a cut stands at the joint's origin on the parent and at the child's own frame.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.formats.common.graph import cut_of
from cutjoint.description.model import IDENTITY, Joint
from cutjoint.findings import Findings


def open_loops(tree: OpenTree, wanted: Collection[str], findings: Findings) -> None:
    """Turn all but one of the joints above each link into cuts of `tree`.

    Kept are joints that are `wanted` (driven or coupled), then the first of the file, as far as that gives a tree.  A
    robot without a root link is left as it is.
    """
    links = {link.name for link in tree.links}
    above: dict[str, list[Joint]] = {}
    for joint in tree.joints:
        if joint.parent in links and joint.child in links:
            above.setdefault(joint.child, []).append(joint)
    roots = links - set(above)
    if not roots or all(len(joints) == 1 for joints in above.values()):
        return
    for child, joints in above.items():
        above[child] = sorted(joints, key=lambda joint: joint.name not in wanted)
    kept = _carrying(above, roots)
    for child, joints in above.items():
        for joint in joints:
            if joint is kept[child]:
                continue
            tree.joints = [one for one in tree.joints if one is not joint]
            found = f"link '{child}' has {len(joints)} parents: joint '{joint.name}' is read as a cut joint"
            findings.warn(found, f"one joint above each link ('{kept[child].name}' carries it)", "", joint.place)
            cut = cut_of(joint, joint.placement, IDENTITY, findings)
            if cut is not None:
                tree.cuts.append(cut)


def _carrying(above: dict[str, list[Joint]], roots: Collection[str]) -> dict[str, Joint]:
    """The joint that carries each link: the first of each where that makes a tree, else as links are reached."""
    first = {child: joints[0] for child, joints in above.items()}
    if len(_reached(list(first.values()), roots)) == len(first):
        return first
    joints = [joint for each in above.values() for joint in each]
    return first | {joint.child: joint for joint in _reached(joints, roots)}


def _reached(joints: Sequence[Joint], roots: Collection[str]) -> list[Joint]:
    """Joints in the order in which they reach a new link from the roots."""
    below: dict[str, list[Joint]] = {}
    for joint in joints:
        below.setdefault(joint.parent, []).append(joint)
    reached, found, pending = set(roots), [], [joint for root in sorted(roots) for joint in below.get(root, ())]
    while pending:
        joint = pending.pop(0)
        if joint.child not in reached:
            reached.add(joint.child)
            found.append(joint)
            pending += below.get(joint.child, [])
    return found
