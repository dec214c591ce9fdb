"""URDF with `<constraint>`, the cut joints proposed in urdfdom_headers pull request 108 (and urdfdom 264).

    <constraint name="tip" type="revolute">
      <parent link="a"/> <parent_origin xyz="..." rpy="..."/> <parent_axis xyz="0 0 1"/>
      <child link="b"/>  <child_origin xyz="..." rpy="..."/>  <child_axis xyz="..."/>
    </constraint>

Types are revolute, prismatic, universal, spherical (each also with `_joint` behind it) and link, which joins rigidly.
Axes are in the frames that the origins give; a universal joint turns about both, the others need the parent's only.
A `<dynamics>`, as of a joint, is of the motion left free.  What the proposal cannot say (bushings, actuators, tool,
homes, ...) may stand in a `<cutjoint>` element, as in a loops.toml.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.formats.common.extras import Extras, OpenTree
from cutjoint.description.formats.common.toml.keys import read_extras
from cutjoint.description.formats.urdf.dynamics import read_dynamics
from cutjoint.description.formats.urdf.link import read_origin
from cutjoint.description.formats.urdf.plus import of_plus
from cutjoint.description.model import CutJoint, CutType, Frame, Place
from cutjoint.description.numbers import read_numbers, unit_axis
from cutjoint.description.transforms import frame_along, turned
from cutjoint.description.xml import Element, check_known, children, name_of, only_child
from cutjoint.findings import Findings

TYPES = {
    "revolute": CutType.REVOLUTE,
    "prismatic": CutType.PRISMATIC,
    "universal": CutType.UNIVERSAL,
    "spherical": CutType.SPHERICAL,
    "link": CutType.FIXED,
}
_NONE: frozenset[str] = frozenset()
_TAGS = frozenset({"parent", "parent_origin", "parent_axis", "child", "child_origin", "child_axis", "dynamics"})


def read_constraints(root: Element, tree: OpenTree, findings: Findings) -> Extras | None:
    """Add to `tree` the cuts of all constraints; what the `<cutjoint>` element says, None where there is none."""
    cuts = [_constraint(element, findings) for element in children(root, "constraint") if not of_plus(element)]
    tree.cuts += [cut for cut in cuts if cut is not None]
    element = only_child(root, "cutjoint", findings)
    if element is None:
        return None
    check_known(element, _NONE, _NONE, _NONE, findings)
    return read_extras(str(element.text or ""), findings, element.sourceline)


def _constraint(element: Element, findings: Findings) -> CutJoint | None:
    check_known(element, frozenset({"name", "type"}), _TAGS, _NONE, findings)
    name = name_of(element, findings)
    text = str(element.get("type") or "").strip()
    kind = TYPES.get(text.removesuffix("_joint"))
    if kind is None:
        findings.unknown(f"type '{text}' of <constraint> '{name}'", text, TYPES, element.sourceline)
    frames = [_end(element, side, name or "?", findings) for side in ("parent", "child")]
    axes = [_axis(element, side, name or "?", kind, findings) for side in ("parent", "child")]
    if name is None or kind is None or None in frames or axes[0] is None or axes[1] is None:
        return None
    if kind.axes == "z" and element.find("child_axis") is not None and np.linalg.norm(axes[0] - axes[1]) > 1e-6:
        found = f"<constraint> '{name}' whose child_axis differs from its parent_axis, which alone is used"
        findings.warn(found, "the same axis: the frames coincide", "turn child_origin instead", element.sourceline)
    align = _alignment(kind, axes[0], axes[1], name, findings, element.sourceline)
    a, b = (Frame(frame.link, turned(frame.placement, align)) for frame in frames if frame is not None)
    physics = read_dynamics(element, f"<constraint> '{name}'", findings)
    return CutJoint(name, kind, a, b, Place(findings.file, element.sourceline), physics)


def _end(element: Element, side: str, name: str, findings: Findings) -> Frame | None:
    end = only_child(element, side, findings)
    link = str(end.get("link") or "").strip() if end is not None else ""
    if not link:
        findings.error(f"<constraint> '{name}' without {side} link", f'<{side} link="..."/>', "", element.sourceline)
        return None
    check_known(end, frozenset({"link"}), _NONE, _NONE, findings)
    return Frame(link, read_origin(element, findings, f"{side}_origin"))


def _axis(element: Element, side: str, name: str, kind: CutType | None, findings: Findings) -> Array | None:
    axis = only_child(element, f"{side}_axis", findings)
    if axis is not None:
        check_known(axis, frozenset({"xyz"}), _NONE, _NONE, findings)
    text = "1 0 0" if axis is None else axis.get("xyz")
    line = element.sourceline if axis is None else axis.sourceline
    values = read_numbers(text, 3, f"{side}_axis of <constraint> '{name}'", findings, line)
    if values is None:
        return None
    if axis is None and kind is not None and kind.axes == "xy":
        found = f"{kind.value} <constraint> '{name}' without {side}_axis"
        findings.error(found, "two perpendicular axes", f'add <{side}_axis xyz="..."/>', line)
        return None
    return unit_axis(values, name, findings, line)


def _alignment(kind: CutType, first: Array, second: Array, name: str, findings: Findings, line: int) -> Array:
    """The rotation (3, 3) that turns the constraint's frames into those of a cut joint."""
    if kind.axes == "z":
        return frame_along(first)
    if kind.axes == "xy":
        if abs(float(first @ second)) > 1e-6:
            found = f"the axes of {kind.value} <constraint> '{name}' are not perpendicular"
            findings.error(found, "two perpendicular axes", "", line)
            return np.eye(3)
        return np.column_stack([first, second, np.cross(first, second)])
    return np.eye(3)
