"""`<joint>`s and `<link>`s of SDF inside the `<gazebo>` of a URDF: Gazebo's way to close loops.

libsdformat copies what stands in a `<gazebo>` without reference into the model that it makes of the URDF
(https://github.com/gazebosim/sdformat, parser_urdf.cc, as SDF 1.5 or newer).  So both are read as in an SDF, among the
links of the URDF where they are at zero: a joint that carries such a link is one of the tree, any other a cut.  One
that needs a coordinate (a screw, coupled, driven) gets an end of its own, which a fixed cut holds.  The world is the
root link.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from lxml import etree

from cutjoint.arrays import Array
from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.formats.common.graph import attach, cut_at
from cutjoint.description.formats.sdf.coupling import read_mimics
from cutjoint.description.formats.sdf.frames import Carriers, Frames
from cutjoint.description.formats.sdf.joint import read_joints
from cutjoint.description.formats.sdf.link import read_body
from cutjoint.description.formats.sdf.names import check_names
from cutjoint.description.formats.sdf.scope import Item, Scope
from cutjoint.description.formats.sdf.values import WORLD
from cutjoint.description.formats.urdf.zero import placements
from cutjoint.description.model import Joint, JointType, Link
from cutjoint.description.xml import Element, name_of
from cutjoint.findings import Findings

_VERSION = (1, 6)
"""Of the names that are known: the last version that has `use_parent_model_frame`."""


def read_gazebo_model(root: Element, elements: Sequence[Element], tree: OpenTree, findings: Findings) -> None:
    """Add to `tree` the links and joints of SDF in `elements`."""
    world = dict(placements(tree))
    roots = [one for one in world if one not in {joint.child for joint in tree.joints}]
    above = {joint.name for joint in tree.joints}  # a cut may be called as one of them: Gazebo leaves out massless ends
    scope = Scope(root, tree.name, Path(findings.file), _VERSION, findings)
    frames = Frames()
    for item, at in _known(tree, world, scope):
        frames.put(item, at)
    items = []
    for element in elements:
        check_names(element, _VERSION, findings)
        name = name_of(element, findings)
        if name is not None:
            items.append(Item(str(element.tag), name, element, scope))
            if element.tag != "joint" or name not in above:
                scope.add(items[-1])
                scope.names[items[-1].kind, f"{tree.name}::{name}"] = items[-1]
    bodies = [read_body(item, frames) for item in items if item.kind == "link"]
    joints = [item for item in items if item.kind == "joint"]
    edges = read_joints(joints, (), frames, Carriers())
    for item in edges.gearboxes:
        found = f"type 'gearbox' of the joint '{item.name}' in <gazebo>"
        findings.error(found, "a coupling as <mimic>", "write it so, or in a loops.toml", item.line)
    couplings = [*(mimic.coupling for mimic in read_mimics(joints)), *edges.couplings]
    tree.couplings += couplings
    needed = {name for one in couplings for name in (one.joint, *one.drivers)} | ({*tree.actuators} - above)
    reached = set(world)
    for body in (*bodies, *edges.links):
        tree.links.append(body.link)
        world[body.link.name] = body.world
    ground = roots[0] if len(roots) == 1 else WORLD
    for joint in _attached(_grounded(edges.joints, ground, findings), reached, world, tree):
        _close(joint, needed, world, tree, findings)


def _known(tree: OpenTree, world: dict[str, Array], scope: Scope) -> Iterator[tuple[Item, Array]]:
    """What of the URDF has a name, and where it is at zero.  The frame of a joint is that of its child."""
    for link in tree.links:
        if link.name in world and link.name != WORLD:
            item = Item("link", link.name, etree.Element("link"), scope)
            scope.names["link", link.name] = scope.names["link", f"{tree.name}::{link.name}"] = item
            yield item, world[link.name]
    for joint in tree.joints:
        element = etree.Element("joint", type=joint.type.sdf or "")
        etree.SubElement(element, "child").text = joint.child
        item = Item("joint", joint.name, element, scope)
        scope.names["joint", joint.name] = item
        if joint.child in world:
            yield item, world[joint.child]


def _grounded(joints: Sequence[Joint], ground: str, findings: Findings) -> Iterator[Joint]:
    """The joints with the root link as the world."""
    for joint in joints:
        parent, child = (ground if end == WORLD else end for end in (joint.parent, joint.child))
        if parent != child:
            yield replace(joint, parent=parent, child=child)
        elif joint.type is JointType.FIXED:
            found = f"both ends of the joint '{joint.name}' in <gazebo> are on link '{child}', the root"
            findings.warn(found, "nothing: the root of a URDF is fixed", "", joint.place)
        else:
            found = f"both ends of the joint '{joint.name}' in <gazebo> are on link '{child}'"
            findings.error(found, "two links that move against each other", "", joint.place)


def _attached(joints: Iterator[Joint], reached: set[str], world: dict[str, Array], tree: OpenTree) -> list[Joint]:
    """Add the joints to the tree as they reach new links; those that are left."""
    left = list(joints)
    while joint := next((one for one in left if (one.parent in reached) != (one.child in reached)), None):
        attach(tree, joint, joint.child in reached, world)
        reached |= {joint.parent, joint.child}
        left.remove(joint)
    return left


def _close(joint: Joint, needed: set[str], world: dict[str, Array], tree: OpenTree, findings: Findings) -> None:
    """Add the cut of a joint that closes a loop."""
    if not {joint.parent, joint.child} <= world.keys():
        return
    if joint.name in needed:
        end = Link(f"{joint.name}_end", place=joint.place)
        world[end.name] = joint.placement
        tree.links.append(end)
        attach(tree, replace(joint, child=end.name), False, world)
        joint = Joint(end.name, JointType.FIXED, end.name, joint.child, joint.placement, place=joint.place)
    cut = cut_at(joint, world, findings)
    tree.cuts += [] if cut is None else [cut]
