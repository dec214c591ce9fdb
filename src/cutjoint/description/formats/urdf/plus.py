"""URDF+ (Chignoli, Slotine, Wensing, Kim 2024, https://arxiv.org/abs/2411.19753): `<loop>` and `<coupling>` in a URDF.

A `<loop>` is a cut joint between a frame on its predecessor and one on its successor, with the axis in both frames.  A
`<coupling>` ties the joints between the links and their nearest common ancestor: ratio times the sum over the
predecessor's side is the sum over the successor's.  `independent="false"` marks joints that follow; the others are the
actuators.  The spelling of its first parser is read too: `<constraint type="position">` for a point that two links
share, and `<constraint type="rolling">` for a coupling.
"""

from __future__ import annotations

from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.formats.urdf.dynamics import read_dynamics
from cutjoint.description.formats.urdf.link import read_origin
from cutjoint.description.formats.urdf.sums import read_end, read_sum, solved
from cutjoint.description.model import CutJoint, CutType, Frame, Place
from cutjoint.description.numbers import read_numbers, unit_axis
from cutjoint.description.transforms import frame_along, turned
from cutjoint.description.xml import Element, check_known, children, name_of, only_child
from cutjoint.findings import Findings, listing

TYPES = {
    "revolute": CutType.REVOLUTE,
    "continuous": CutType.REVOLUTE,
    "prismatic": CutType.PRISMATIC,
    "fixed": CutType.FIXED,
    "spherical": CutType.SPHERICAL,
    "position": CutType.SPHERICAL,
}
_NONE: frozenset[str] = frozenset()


def is_rolling(element: Element) -> bool:
    """Whether a `<constraint>` is a coupling in the spelling of the first parser."""
    return str(element.get("type") or "").strip() == "rolling"


def of_plus(element: Element) -> bool:
    """Whether a `<constraint>` is of URDF+, and not of the proposal that has the same name."""
    return is_rolling(element) or any(one.tag in ("predecessor", "successor") for one in children(element))


def read_plus(root: Element, tree: OpenTree, findings: Findings) -> tuple[str, ...] | None:
    """Add to `tree` the cuts and couplings of URDF+; the independent joints, or None where nothing is of URDF+."""
    older = [one for one in children(root, "constraint") if of_plus(one)]
    loops = [*children(root, "loop"), *(one for one in older if not is_rolling(one))]
    couplings = [*children(root, "coupling"), *(one for one in older if is_rolling(one))]
    marked = any(one.get("independent") is not None for one in children(root, "joint"))
    if not (loops or couplings or marked):
        return None
    tree.cuts += [cut for cut in (_loop(element, findings) for element in loops) if cut is not None]
    dependent = _dependent(root, findings)
    sums = [one for one in (read_sum(element, tree, findings) for element in couplings) if one is not None]
    tree.couplings += solved(sums, dependent, tree, findings)
    driven = {coupling.joint for coupling in tree.couplings}
    loose = dependent - driven
    if loose and not (tree.cuts or tree.closings):
        at = next(one for one in children(root, "joint") if str(one.get("name") or "").strip() in loose)
        found = f"joints that are not independent, and that nothing makes follow: {listing(sorted(loose))}"
        findings.doubt(found, "a <loop> or <coupling> for each", "add what ties them", at.sourceline)
    driven |= dependent
    return tuple(joint.name for joint in tree.joints if joint.type.single and joint.name not in driven)


def _dependent(root: Element, findings: Findings) -> set[str]:
    names = set()
    for element in children(root, "joint"):
        flag = str(element.get("independent", "true")).strip()
        if flag.lower() not in ("true", "false"):
            findings.error(f"independent is '{flag}'", "true or false", "", element.sourceline)
        if flag.lower() == "false":
            names.add(str(element.get("name") or "").strip())
    return names


def _loop(element: Element, findings: Findings) -> CutJoint | None:
    tags = frozenset({"predecessor", "successor", "axis", "dynamics", "limit"})
    check_known(element, frozenset({"name", "type"}), tags, _NONE, findings)
    for limit in children(element, "limit"):
        found = f"<limit> of <{element.tag}> '{element.get('name')}' is not used"
        findings.warn(found, "limits in the tree", "let another joint of the loop close it", limit.sourceline)
    name = name_of(element, findings)
    kind = str(element.get("type") or "").strip()
    if kind not in TYPES:
        findings.unknown(f"type '{kind}' of <{element.tag}> '{name}'", kind, TYPES, element.sourceline)
    before, before_element = read_end(element, "predecessor", name or "?", findings)
    after, after_element = read_end(element, "successor", name or "?", findings)
    axis = only_child(element, "axis", findings)
    direction: tuple[float, ...] | None = (1.0, 0.0, 0.0)
    if axis is not None:
        check_known(axis, frozenset({"xyz"}), _NONE, _NONE, findings)
        direction = read_numbers(axis.get("xyz"), 3, f"axis of <{element.tag}> '{name}'", findings, axis.sourceline)
    if name is None or kind not in TYPES or before is None or after is None or direction is None:
        return None
    unit = unit_axis(direction, name, findings, element.sourceline)
    align = frame_along(unit if TYPES[kind].axes == "z" else (0.0, 0.0, 1.0))
    a, b = (turned(read_origin(end, findings), align) for end in (before_element, after_element))
    place = Place(findings.file, element.sourceline)
    physics = read_dynamics(element, f"<{element.tag}> '{name}'", findings)
    return CutJoint(name, TYPES[kind], Frame(before, a), Frame(after, b), place, physics)
