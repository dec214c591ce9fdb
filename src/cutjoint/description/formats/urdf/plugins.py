"""Plugins in the `<gazebo>` of a URDF, as couplings and cuts of its tree."""

from __future__ import annotations

from cutjoint.arrays import readonly
from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.formats.common.plugins import Plugged, PluginNames, geared, read_plugin
from cutjoint.description.formats.urdf.zero import placements
from cutjoint.description.model import IDENTITY, Coupling, CutJoint, CutType, Frame
from cutjoint.description.transforms import inverse
from cutjoint.description.xml import Element
from cutjoint.findings import Findings


def plug_in(element: Element, tree: OpenTree, findings: Findings) -> None:
    """Add to `tree` the couplings and cuts of a `<plugin>`.  What joints it drives, transmissions say."""
    joints, links, done = {one.name for one in tree.joints}, {one.name for one in tree.links}, Plugged()
    names = PluginNames(
        lambda name: name if name in joints else None,
        lambda name: name if name in links else None,
        (tree.name, "__model__"),
        joints,
    )
    read_plugin(element, names, done, findings)
    for coupling in done.couplings:
        _add(coupling, "a mimic plugin", tree, findings)
    for parent, child, name, place in done.held:
        world = placements(tree)
        if parent in world and child in world:
            at = readonly(inverse(world[parent]) @ world[child])
            tree.cuts.append(CutJoint(name, CutType.FIXED, Frame(parent, at), Frame(child, IDENTITY), place))


def couple(said: tuple[str, str, str, str], what: str, tree: OpenTree, line: int | None, findings: Findings) -> None:
    """Add the coupling of a follower, its driver, multiplier and offset (texts) that something beside the tree says."""
    coupling = geared(said, what, line, findings)
    if coupling is not None:
        _add(coupling, what, tree, findings)


def _add(coupling: Coupling, what: str, tree: OpenTree, findings: Findings) -> None:
    """Add a coupling; one that repeats a `<mimic>` is passed, one that contradicts it a doubt: the `<mimic>` stands."""
    joint, place = coupling.joint, coupling.place
    if any(one.name == joint and not one.type.moves for one in tree.joints):
        findings.warn(f"{what} of joint '{joint}', which is fixed, is not used", "a joint that moves", "", place)
        return
    same = [one for one in tree.couplings if one.joint == joint]
    if not same:
        tree.couplings.append(coupling)
    elif any(one.drives != coupling.drives or one.offset != coupling.offset for one in same):
        found = f"{what} says {coupling.formula}, and <mimic> says {same[0].formula}"
        findings.doubt(found, "the same in both", "keep one; a lenient reader keeps the <mimic>", place)
