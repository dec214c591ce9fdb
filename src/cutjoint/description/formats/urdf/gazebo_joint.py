"""A `<joint>` of SDF inside the `<gazebo>` of a URDF: Gazebo's way to close loops that URDF itself cannot have.

libsdformat copies what stands in a `<gazebo>` without reference into the model that it makes of the URDF
(https://github.com/gazebosim/sdformat, parser_urdf.cc, as SDF 1.5 or newer).  So the joint stands at its `<pose>` in
the child link's frame, or in what `relative_to` names; its axes are in its own frame, in what `expressed_in` names, or
in the model's where there is `use_parent_model_frame`.  Both links have the joint where they are at zero.  A screw,
which no cut is, hangs its hinge and slide on the parent, and the end of them is held fast on the child.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from cutjoint.arrays import Array, readonly
from cutjoint.description.findings import Findings, nearest
from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.formats.common.graph import cut_of
from cutjoint.description.formats.common.screw import SCREW, Screw, read_lead
from cutjoint.description.formats.sdf.dynamics import read_limits, read_physics, unused_axis
from cutjoint.description.formats.sdf.joint import TYPES
from cutjoint.description.formats.sdf.names import check_names
from cutjoint.description.formats.sdf.values import WORLD, child_flag, read_pose, text_of
from cutjoint.description.formats.urdf.zero import placements
from cutjoint.description.model import (
    IDENTITY,
    CutJoint,
    CutType,
    Frame,
    Joint,
    JointPhysics,
    JointType,
    Limits,
    Link,
    Place,
)
from cutjoint.description.numbers import read_numbers, unit_axis
from cutjoint.description.transforms import inverse
from cutjoint.description.xml import Element, name_of, only_child
from cutjoint.mechanism.physics import NO_PHYSICS

_VERSION = (1, 6)
"""Of the names that are known: the last version that has `use_parent_model_frame`."""


def read_gazebo_joint(element: Element, tree: OpenTree, findings: Findings) -> CutJoint | None:
    """The cut of a `<joint>` in a `<gazebo>`; None after noting why not."""
    check_names(element, _VERSION, findings)
    name = name_of(element, findings)
    text = str(element.get("type") or "").strip()
    if text not in TYPES:
        findings.unknown(f"type '{text}' of the joint '{name}' in <gazebo>", text, TYPES, element.sourceline)
    world = placements(tree)
    ends = [_end(element, tag, name or "?", tree, world, findings) for tag in ("parent", "child")]
    if name is None or text not in TYPES or ends[0] is None or ends[1] is None:
        return None
    for mimic in element.iter("mimic"):
        found = f"<mimic> of the joint '{name}' in <gazebo>, which closes a loop"
        findings.error(found, "couplings of joints of the tree", "couple another joint", mimic.sourceline)
    if ends[0] == ends[1]:
        found = f"both ends of the joint '{name}' in <gazebo> are on link '{ends[0]}'"
        if WORLD in [text_of(only_child(element, tag, findings)) for tag in ("parent", "child")] and text == "fixed":
            findings.warn(f"{found}, the root", "nothing: the root of a URDF is fixed", "", element.sourceline)
        else:
            findings.error(found, "two links that move against each other", "", element.sourceline)
        return None
    return _cut(element, name, TYPES[text], (ends[0], ends[1]), tree, world, findings)


def _end(
    element: Element, tag: str, name: str, tree: OpenTree, world: Mapping[str, Array], findings: Findings
) -> str | None:
    """The link at one end.  The world is the root link."""
    end = only_child(element, tag, findings)
    link = text_of(end).removeprefix(f"{tree.name}::")
    line = element.sourceline if end is None else end.sourceline
    if link in world:
        return link
    roots = [one for one in world if one not in {joint.child for joint in tree.joints}]
    if link == WORLD and len(roots) == 1:
        return roots[0]
    found = (
        f"{tag} '{link}' of the joint '{name}' in <gazebo> is not a link" if link else f"joint '{name}' without {tag}"
    )
    findings.error(found, f"<{tag}>NAME OF A LINK</{tag}>", nearest(link, world), line)
    return None


def _cut(
    element: Element,
    name: str,
    kind: JointType,
    ends: tuple[str, str],
    tree: OpenTree,
    world: Mapping[str, Array],
    findings: Findings,
) -> CutJoint | None:
    pose = only_child(element, "pose", findings)
    base = "" if pose is None else str(pose.get("relative_to") or pose.get("frame") or "").strip()
    line = element.sourceline if pose is None else pose.sourceline
    above = world[ends[1]] if not base else _frame(base, tree, world, findings, line)
    at = readonly(above @ read_pose(element, f"joint '{name}' in <gazebo>", findings))
    elements = [only_child(element, tag, findings) for tag in ("axis", "axis2")]
    for tag, axis in zip(("axis", "axis2"), elements, strict=True):
        if axis is None and kind.axes > ("axis", "axis2").index(tag):
            found = f"{kind.value} joint '{name}' in <gazebo> without <{tag}>"
            findings.error(found, f"<{tag}><xyz>...</xyz></{tag}>", "", element.sourceline)
            return None
    for axis in elements[kind.axes :]:
        unused_axis(axis, name, kind, findings)
    given = [axis for axis in elements[: kind.axes] if axis is not None]
    axes = [_axis(axis, name, at, tree, world, findings) for axis in given]
    physics = _physics(given, axes, name, kind, findings)
    limits = read_limits(given[0], name, kind, findings) if kind.single else Limits()
    first, second = (*axes, readonly([1.0, 0.0, 0.0]), readonly([0.0, 1.0, 0.0]))[:2]
    place = Place(findings.file, element.sourceline)
    at_parent, at_child = (readonly(inverse(world[link]) @ at) for link in ends)
    edge = Joint(name, kind, ends[0], ends[1], at_parent, first, second, limits, physics, place)
    if element.get("type") == SCREW:
        return _screwed(element, edge, at_child, tree, findings)
    return cut_of(edge, at_parent, at_child, findings)


def _screwed(element: Element, edge: Joint, at_child: Array, tree: OpenTree, findings: Findings) -> CutJoint | None:
    """Add the hinge and the slide of a screw to the tree; the cut that closes the loop behind them."""
    lead = read_lead(element, edge.name, findings)
    if lead is None:
        return None
    end = Link(f"{edge.name}_end", place=edge.place)
    screw = Screw.of(replace(edge, child=end.name), lead)
    tree.links += [screw.nut, end]
    tree.joints += [screw.turn, screw.slide]
    tree.couplings.append(screw.coupling)
    return CutJoint(end.name, CutType.FIXED, Frame(end.name), Frame(edge.child, at_child), edge.place)


def _physics(
    given: Sequence[Element], axes: Sequence[Array], name: str, kind: JointType, findings: Findings
) -> JointPhysics:
    """What the joint does by itself; both axes of a universal one must do the same, and be perpendicular."""
    if not given:
        return NO_PHYSICS
    found = [read_physics(axis, name, kind, findings) for axis in given]
    line = given[0].sourceline
    if kind.axes == 2 and abs(float(axes[0] @ axes[1])) > 1e-6:
        text = f"the axes of the {kind.value} joint '{name}' in <gazebo> are not perpendicular"
        findings.error(text, "two perpendicular axes", "", line)
    if found[0] != found[-1]:
        text = f"the two axes of the joint '{name}' in <gazebo> have different dampers, friction or springs"
        findings.error(text, "the same for both", "", line)
    for axis in given if kind.axes == 2 else ():
        if read_limits(axis, name, JointType.REVOLUTE, Findings()) != Limits():
            text = f"limits of the joint '{name}' in <gazebo>, which closes a loop, are not used"
            findings.warn(text, "limits in the tree", "", axis.sourceline)
    return found[0]


def _frame(name: str, tree: OpenTree, world: Mapping[str, Array], findings: Findings, line: int | None) -> Array:
    """The placement (4, 4) at zero of a link or joint, or of the model."""
    moved = {joint.name: joint.child for joint in tree.joints}
    link = name if name in world else moved.get(name, "")
    if name in ("__model__", WORLD) and name not in world:
        return IDENTITY
    if link not in world:
        findings.error(f"unknown frame '{name}'", "a link, a joint or __model__", nearest(name, [*world, *moved]), line)
        return IDENTITY
    return world[link]


def _axis(axis: Element, name: str, at: Array, tree: OpenTree, world: Mapping[str, Array], findings: Findings) -> Array:
    """An axis in the frame of the joint, which stands at `at`."""
    xyz = only_child(axis, "xyz", findings)
    line = axis.sourceline if xyz is None else xyz.sourceline
    values = read_numbers("0 0 1" if xyz is None else xyz.text, 3, f"axis of joint '{name}'", findings, line)
    unit = unit_axis(values or (0.0, 0.0, 1.0), name, findings, line)
    base = "" if xyz is None else str(xyz.get("expressed_in") or "").strip()
    if not base and child_flag(axis, "use_parent_model_frame", findings):
        base = "__model__"
    if not base:
        return unit
    return readonly(at[:3, :3].T @ _frame(base, tree, world, findings, line)[:3, :3] @ unit)
