"""URDF, read strictly: every element and attribute is known or reported, every number is checked.

Format: https://wiki.ros.org/urdf/XML.  What URDF leaves out stays out here too: a joint without `<limit>` has no limits
(not limits of 0), a shape without colour has none.  `<mimic>` becomes a coupling.  What other programs put beside it to
close loops becomes cuts of the tree: joints in `<gazebo>`, Drake's constraints, `<loop_joint>`, closing frames, and
links with several joints above them.
"""

from __future__ import annotations

from pathlib import Path

from cutjoint.description.formats.common.extras import OpenTree, RobotFindings
from cutjoint.description.formats.urdf.closing import closings
from cutjoint.description.formats.urdf.drake import ROBOT_TAGS as DRAKE_TAGS
from cutjoint.description.formats.urdf.drake import hold_by_world, read_drake
from cutjoint.description.formats.urdf.expanded import read_expanded
from cutjoint.description.formats.urdf.gazebo import read_gazebo
from cutjoint.description.formats.urdf.joint import read_joint, read_screw
from cutjoint.description.formats.urdf.link import Colours, read_colours, read_link
from cutjoint.description.formats.urdf.loop_joint import loop_joints
from cutjoint.description.formats.urdf.others import check_others
from cutjoint.description.formats.urdf.several_parents import open_loops
from cutjoint.description.formats.urdf.transmission import driven, geared
from cutjoint.description.xml import Element, check_known, children, drake_name, short
from cutjoint.findings import Findings, Harmless, clip, listing

ROBOT_ATTRIBUTES = frozenset({"name", "version"})
ROBOT_TAGS = frozenset({"link", "joint", "material"})
ROBOT_IGNORED = frozenset({"transmission", "gazebo", "sensor", "ros2_control", "mujoco", "loop_joint", "frame"}) | {
    "fixed_frame",
    *DRAKE_TAGS,
}
LOOP_TAGS = frozenset({"loop", "coupling", "constraint", "cutjoint"})
"""What dialects with loops add to a `<robot>`."""


def read_robot(path: Path, findings: Findings) -> Element | None:
    """The `<robot>` element of a URDF, expanded where it is xacro, or None after noting why not."""
    root = read_expanded(path, findings)
    if root is None:
        return None
    if drake_name(str(root.tag)) == "robot":  # xmlns="http://drake.mit.edu" on a plain URDF
        for element in root.iter("{*}*"):
            element.tag = short(str(element.tag)) if element.prefix else short(str(element.tag)).removeprefix("drake:")
    if root.tag != "robot":
        expected = "<robot> (URDF), <mujoco> (MJCF) or <sdf>"
        findings.error(f"the root element is <{root.tag}>", expected, "is this another format?", root.sourceline)
        return None
    return root


def read_tree_of(file: Path, findings: Findings) -> OpenTree | None:
    """The tree of the URDF that another file names; its problems are at places of its own."""
    own = RobotFindings(str(file))
    root = read_robot(file, own)
    tree = None if root is None else read_tree(root, file, own)
    findings.problems.extend(own.problems)
    if isinstance(findings, RobotFindings):
        findings.closing.update(own.closing)
    return tree


def read_tree(root: Element, path: Path, findings: Findings, loops: frozenset[str] = frozenset()) -> OpenTree:
    """Links, joints, cuts and mimic couplings of a `<robot>`; what cannot be read is noted and left out.

    `loops` names the elements that the caller reads itself.
    """
    check_known(root, ROBOT_ATTRIBUTES, ROBOT_TAGS, ROBOT_IGNORED | LOOP_TAGS, findings)
    for element in children(root):
        if element.tag in LOOP_TAGS - loops:
            found = f"<{element.tag}> in a URDF that is read without it"
            findings.error(found, "one dialect", "move it to where the other loops are described", element.sourceline)
    name = str(root.get("name") or "").strip()
    if not name:
        findings.doubt("<robot> without a name", '<robot name="...">', "", root.sourceline)
        name = path.stem
    tree = OpenTree(name, actuators=driven(root))
    colours: Colours = read_colours(root, Harmless(findings))
    for element in children(root, "link"):
        link = read_link(element, path, colours, findings)
        if link is not None:
            tree.links.append(link)
    for element in children(root):
        if element.tag == "joint" or drake_name(str(element.tag)) == "joint":
            joint, coupling = read_joint(element, findings)
            screw = None if joint is None else read_screw(element, joint, findings)
            if screw is not None:
                tree.links.append(screw.nut)
                tree.couplings.append(screw.coupling)
            tree.joints += [screw.turn, screw.slide] if screw is not None else [] if joint is None else [joint]
            tree.couplings += [coupling] if coupling is not None else []
    tree.joints = geared(tree.joints, root, findings)
    hold_by_world(root, tree, findings)
    _close(root, tree, findings)
    _names(root, tree, findings)
    return tree


def _close(root: Element, tree: OpenTree, findings: Findings) -> None:
    """Add what closes loops beside the joints of the tree."""
    coupled = {name for one in tree.couplings for name in (one.joint, *one.drivers)}
    open_loops(tree, {*tree.actuators, *coupled}, findings)
    read_gazebo(root, tree, findings)
    read_drake(root, tree, findings)
    tree.cuts += loop_joints(root, findings)
    tree.closings += closings(tree, findings)
    check_others(root, tree, findings)


def _names(root: Element, tree: OpenTree, findings: Findings) -> None:
    """Note joints named like links, and unknown elements that speak of several parts."""
    links = {link.name for link in tree.links}
    for joint in tree.joints:
        if joint.name in links:
            found = f"joint '{joint.name}' is named like a link"
            remedy = f"call it {joint.name}_joint"
            findings.warn(found, "different names: to other programs both are frames", remedy, joint.place)
    parts = {*links, *(joint.name for joint in tree.joints)}
    for element in children(root):
        if short(str(element.tag)) in ROBOT_TAGS | ROBOT_IGNORED | LOOP_TAGS:
            continue
        said = [str(value).strip() for one in element.iter() for value in (*one.attrib.values(), one.text or "")]
        named = list(dict.fromkeys(one for one in said if one in parts))
        if len(named) > 1:
            tag = clip(short(str(element.tag)))
            found = f"unknown element <{tag}> names {listing(named, 4)}: does it join them?"
            findings.doubt(
                found, "a dialect that is known", "say it in a loops.toml, and remove it", element.sourceline
            )
