"""The `<link>` of an SDF: its inertia, and what it says besides of its motion."""

from __future__ import annotations

import numpy as np

from cutjoint.description.formats.common.graph import PlacedLink
from cutjoint.description.formats.sdf.frames import Frames
from cutjoint.description.formats.sdf.scope import Item
from cutjoint.description.formats.sdf.shape import read_shapes
from cutjoint.description.formats.sdf.values import child_flag, flag, read_pose, text_of
from cutjoint.description.model import Inertial, Link, Place
from cutjoint.description.numbers import LARGEST_INERTIA, LARGEST_MASS, read_numbers
from cutjoint.description.xml import Element, children, only_child
from cutjoint.findings import Findings


def read_body(item: Item, frames: Frames) -> PlacedLink:
    """One `<link>`, placed in the world."""
    findings = item.scope.findings
    _note_motion(item.element, item.name, findings)
    inertial = _inertial(item.element, item.name, findings)
    visuals, collisions = (tuple(read_shapes(item, tag, frames)) for tag in ("visual", "collision"))
    gravity = only_child(item.element, "gravity", findings)
    floats = gravity is not None and not child_flag(item.element, "gravity", findings)
    link = Link(item.full, inertial, visuals, collisions, Place(findings.file, item.line), float(floats))
    return PlacedLink(link, frames.of(item))


def _note_motion(link: Element, name: str, findings: Findings) -> None:
    """Note what changes how a link moves and is not read."""
    if child_flag(link, "kinematic", findings):
        findings.doubt(f"link '{name}' is kinematic", "a link that obeys its forces", "", link.sourceline)
    if child_flag(link, "must_be_base_link", findings):
        found = f"must_be_base_link of link '{name}' is not used"
        findings.warn(found, "a joint to the world, or none", "", link.sourceline)
    decay = only_child(link, "velocity_decay", findings)
    for part in () if decay is None else children(decay):
        value = read_numbers(part.text, 1, f"velocity_decay of link '{name}'", findings, part.sourceline)
        if value is not None and value[0] != 0.0:
            found = f"velocity_decay of link '{name}'"
            findings.doubt(found, "damping of joints", "write <damping> in its joint", part.sourceline)


def _inertial(link: Element, name: str, findings: Findings) -> Inertial | None:
    element = only_child(link, "inertial", findings)
    if element is None:
        return Inertial(1.0, inertia=np.eye(3))  # the default of SDF
    _note_inertial(element, name, findings)
    pose = read_pose(element, f"the inertia of link '{name}'", findings)
    part = only_child(element, "mass", findings)
    text = "1" if part is None else part.text
    line = element.sourceline if part is None else part.sourceline
    mass = read_numbers(text, 1, f"mass of link '{name}'", findings, line, LARGEST_MASS)
    inertia = only_child(element, "inertia", findings)
    entries: list[float] = []
    for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"):
        entry = None if inertia is None else only_child(inertia, key, findings)
        text = ("1" if key[1] == key[2] else "0") if entry is None else entry.text
        line = element.sourceline if entry is None else entry.sourceline
        entries += read_numbers(text, 1, f"{key} of link '{name}'", findings, line, LARGEST_INERTIA) or ()
    if mass is None or len(entries) != 6:
        return None
    return Inertial.of(mass[0], pose[:3, 3], entries, pose[:3, :3])


def _note_inertial(element: Element, name: str, findings: Findings) -> None:
    """Note what an `<inertial>` says otherwise than by numbers."""
    if flag(str(element.get("auto") or ""), f"auto of the inertia of link '{name}'", findings, element.sourceline):
        found = f"<inertial auto=\"true\"> of link '{name}'"
        findings.error(found, "<mass> and <inertia>", "write the numbers out: gz sdf -p model.sdf", element.sourceline)
    added = only_child(element, "fluid_added_mass", findings)
    if added is not None and any(text_of(one).strip("0. ") for one in children(added)):
        found = f"<fluid_added_mass> of link '{name}'"
        findings.doubt(found, "a link in no fluid", "remove it", added.sourceline)
    pose = only_child(element, "pose", findings)
    other = "" if pose is None else str(pose.get("relative_to") or pose.get("frame") or "")
    if pose is not None and other:
        found = f"the inertia of link '{name}' is placed relative to '{other}'"
        findings.doubt(found, "in the frame of its link, as SDF has it", "remove relative_to", pose.sourceline)
