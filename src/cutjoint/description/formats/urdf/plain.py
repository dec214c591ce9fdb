"""URDF, read strictly: every element and attribute is known or reported, every number is checked.

Format: https://wiki.ros.org/urdf/XML.  What URDF leaves out stays out here too: a joint without `<limit>` has no limits
(not limits of 0), a shape without colour has none.  `<mimic>` becomes a coupling.
"""

from __future__ import annotations

from pathlib import Path

from cutjoint.description.findings import Findings
from cutjoint.description.formats.common.extras import OpenTree, described
from cutjoint.description.formats.urdf.joint import read_joint
from cutjoint.description.formats.urdf.link import Colours, read_colours, read_link
from cutjoint.description.formats.urdf.transmission import driven, geared
from cutjoint.description.model import RobotDescription
from cutjoint.description.xml import Element, check_known, children, read_xml, refuse_xacro

ROBOT_ATTRIBUTES = frozenset({"name", "version"})
ROBOT_TAGS = frozenset({"link", "joint", "material"})
ROBOT_IGNORED = frozenset({"transmission", "gazebo", "sensor", "ros2_control", "mujoco"})
LOOP_TAGS = frozenset({"loop", "coupling", "constraint", "cutjoint"})
"""What dialects with loops add to a `<robot>`."""


def read(path: Path, findings: Findings) -> RobotDescription | None:
    """A plain URDF as a robot without cuts: every free joint with one coordinate is an actuator."""
    root = read_robot(path, findings)
    if root is None:
        return None
    tree = read_tree(root, path, findings)
    return described(tree, (), None, path, findings)


def read_robot(path: Path, findings: Findings) -> Element | None:
    """The `<robot>` element of a URDF, or None after noting why not."""
    root = read_xml(path, findings, "URDF")
    if root is None:
        return None
    if root.tag != "robot":
        expected = "<robot> (URDF), <mujoco> (MJCF) or <sdf>"
        findings.error(f"the root element is <{root.tag}>", expected, "is this another format?", root.sourceline)
        return None
    refuse_xacro(root, findings)
    return None if findings.failed else root


def read_tree_of(file: Path, findings: Findings) -> OpenTree | None:
    """The tree of the URDF that another file names; its problems are at places of its own."""
    own = Findings(str(file))
    root = read_robot(file, own)
    tree = None if root is None else read_tree(root, file, own)
    findings.problems.extend(own.problems)
    return tree


def read_tree(root: Element, path: Path, findings: Findings, loops: frozenset[str] = frozenset()) -> OpenTree:
    """Links, joints and mimic couplings of a `<robot>` element; what cannot be read is noted and left out.

    `loops` names the elements that the caller reads itself.
    """
    check_known(root, ROBOT_ATTRIBUTES, ROBOT_TAGS, ROBOT_IGNORED | LOOP_TAGS, findings)
    for element in children(root):
        if element.tag in LOOP_TAGS - loops:
            found = f"<{element.tag}> in a URDF that is read without it"
            findings.error(found, "one dialect", "move it to where the other loops are described", element.sourceline)
    name = str(root.get("name") or "").strip()
    if not name:
        findings.error("<robot> without a name", '<robot name="...">', "", root.sourceline)
        name = path.stem
    colours: Colours = read_colours(root, findings)
    tree = OpenTree(name, actuators=driven(root))
    for element in children(root, "link"):
        link = read_link(element, path, colours, findings)
        if link is not None:
            tree.links.append(link)
    for element in children(root, "joint"):
        joint, coupling = read_joint(element, findings)
        if joint is not None:
            tree.joints.append(joint)
        if coupling is not None:
            tree.couplings.append(coupling)
    tree.joints = geared(tree.joints, root, findings)
    links = {link.name for link in tree.links}
    for joint in tree.joints:
        if joint.name in links:
            found = f"joint '{joint.name}' is named like a link"
            remedy = f"call it {joint.name}_joint"
            findings.doubt(found, "different names: both become frames", remedy, joint.place)
    if not tree.links:
        findings.error("a robot without links", "at least one <link>", "", root.sourceline)
    return tree
