"""`<loop_joint>` in a URDF, of Drake's first parsers and of Isaac Sim's importer.

    <loop_joint name="pin" type="continuous">
      <link1 link="coupler" xyz="1.2 0 0" rpy="0 0 0"/> <link2 link="rocker" xyz="0.8 0 0"/>
      <axis xyz="0 1 0"/>
    </loop_joint>

The two frames meet where the loop is closed; the axis (x where it is missing, as in all of URDF) holds in both.  Drake
read continuous ones (https://github.com/RobotLocomotion/drake, RigidBodyLoop), Isaac Sim reads spherical ones
(https://docs.isaacsim.omniverse.nvidia.com, URDF Importer Extension).
"""

from __future__ import annotations

from cutjoint.description.formats.urdf.dynamics import read_dynamics
from cutjoint.description.formats.urdf.link import origin_of
from cutjoint.description.model import CutJoint, CutType, Frame, Place
from cutjoint.description.numbers import read_numbers, unit_axis
from cutjoint.description.transforms import frame_along, turned
from cutjoint.description.xml import Element, check_known, children, name_of, only_child
from cutjoint.findings import Findings

TYPES = {
    "revolute": CutType.REVOLUTE,
    "continuous": CutType.REVOLUTE,
    "prismatic": CutType.PRISMATIC,
    "fixed": CutType.FIXED,
    "spherical": CutType.SPHERICAL,
    "ball": CutType.SPHERICAL,
}
_NONE: frozenset[str] = frozenset()


def loop_joints(root: Element, findings: Findings) -> list[CutJoint]:
    """The cuts of all `<loop_joint>` elements."""
    cuts = [_cut(element, findings) for element in children(root, "loop_joint")]
    return [cut for cut in cuts if cut is not None]


def _cut(element: Element, findings: Findings) -> CutJoint | None:
    tags = frozenset({"link1", "link2", "axis", "dynamics", "limit"})
    check_known(element, frozenset({"name", "type"}), tags, _NONE, findings)
    name = name_of(element, findings)
    text = str(element.get("type") or "").strip()
    kind = TYPES.get(text)
    if kind is None:
        findings.unknown(f"type '{text}' of <loop_joint> '{name}'", text, TYPES, element.sourceline)
    frames = [_end(element, tag, name or "?", findings) for tag in ("link1", "link2")]
    axis = only_child(element, "axis", findings)
    values: tuple[float, ...] | None = (1.0, 0.0, 0.0)
    if axis is not None:
        check_known(axis, frozenset({"xyz"}), _NONE, _NONE, findings)
        values = read_numbers(axis.get("xyz"), 3, f"axis of <loop_joint> '{name}'", findings, axis.sourceline)
    for limit in children(element, "limit"):
        found = f"<limit> of <loop_joint> '{name}' is not used"
        findings.warn(found, "limits in the tree", "let another joint of the loop close it", limit.sourceline)
    a, b = frames
    if name is None or kind is None or a is None or b is None or values is None:
        return None
    if kind.axes == "z":
        align = frame_along(unit_axis(values, name, findings, element.sourceline))
        a, b = (Frame(frame.link, turned(frame.placement, align)) for frame in (a, b))
    physics = read_dynamics(element, f"<loop_joint> '{name}'", findings)
    return CutJoint(name, kind, a, b, Place(findings.file, element.sourceline), physics)


def _end(element: Element, tag: str, name: str, findings: Findings) -> Frame | None:
    end = only_child(element, tag, findings)
    link = str(end.get("link") or "").strip() if end is not None else ""
    if not link:
        findings.error(f"<loop_joint> '{name}' without {tag}", f'<{tag} link="..."/>', "", element.sourceline)
        return None
    check_known(end, frozenset({"link", "xyz", "rpy"}), _NONE, _NONE, findings)
    return Frame(link, origin_of(end, f"<{tag}> of <loop_joint> '{name}'", findings))
