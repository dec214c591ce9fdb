"""URDF+ (Chignoli, Slotine, Wensing, Kim 2024, https://arxiv.org/abs/2411.19753): `<loop>` and `<coupling>` in a URDF.

A `<loop>` is a cut joint between a frame on its predecessor and one on its successor, with the axis in both frames.  A
`<coupling>` ties the joints between the links and their nearest common ancestor: ratio times the sum over the
predecessor's side is the sum over the successor's.  `independent="false"` marks joints that follow; the others are the
actuators.  The spelling of its first parser is read too: `<constraint type="position">` for a point that two links
share, and `<constraint type="rolling">` for a coupling.
"""

from __future__ import annotations

from pathlib import Path

from cutjoint.description.findings import Findings, listing
from cutjoint.description.formats.common.extras import Extras, OpenTree, described
from cutjoint.description.formats.urdf import plain
from cutjoint.description.formats.urdf.dynamics import read_dynamics
from cutjoint.description.formats.urdf.link import read_origin
from cutjoint.description.model import Coupling, CutJoint, CutType, Frame, Joint, Place, RobotDescription
from cutjoint.description.numbers import read_numbers, unit_axis
from cutjoint.description.transforms import frame_along, turned
from cutjoint.description.xml import Element, check_known, children, name_of, only_child

TYPES = {
    "revolute": CutType.REVOLUTE,
    "continuous": CutType.REVOLUTE,
    "prismatic": CutType.PRISMATIC,
    "fixed": CutType.FIXED,
    "spherical": CutType.SPHERICAL,
    "position": CutType.SPHERICAL,
}
_NONE: frozenset[str] = frozenset()


def read(path: Path, findings: Findings) -> RobotDescription | None:
    """A URDF+ file."""
    root = plain.read_robot(path, findings)
    if root is None:
        return None
    tree = plain.read_tree(root, path, findings, frozenset({"loop", "coupling", "constraint"}))
    rolling = [one for one in children(root, "constraint") if one.get("type") == "rolling"]
    loops = [one for one in children(root) if one.tag in ("loop", "constraint") and one not in rolling]
    cuts = [_loop(element, findings) for element in loops]
    dependent = _dependent(root, findings)
    for element in [*children(root, "coupling"), *rolling]:
        coupling = read_coupling(element, tree, dependent, findings)
        if coupling is not None:
            tree.couplings.append(coupling)
    driven = {coupling.joint for coupling in tree.couplings} | dependent
    actuators = [joint.name for joint in tree.joints if joint.type.single and joint.name not in driven]
    sound = [cut for cut in cuts if cut is not None]
    extras = Extras(actuators=tuple(actuators))
    return described(tree, sound, extras, path, findings)


def _dependent(root: Element, findings: Findings) -> set[str]:
    names = set()
    for element in children(root, "joint"):
        flag = str(element.get("independent", "true")).strip()
        if flag.lower() not in ("true", "false"):
            findings.error(f"independent is '{flag}'", "true or false", "", element.sourceline)
        if flag.lower() == "false":
            names.add(str(element.get("name") or "").strip())
    return names


def read_end(element: Element, tag: str, name: str, findings: Findings) -> tuple[str | None, Element | None]:
    """The link that the `<predecessor>` or `<successor>` of `element` names, and the element itself."""
    end = only_child(element, tag, findings)
    link = str(end.get("link") or "").strip() if end is not None else ""
    if not link:
        line = element.sourceline if end is None else end.sourceline
        findings.error(f"<{element.tag}> '{name}' without {tag} link", f'<{tag} link="...">', "", line)
        return None, end
    check_known(end, frozenset({"link"}), frozenset({"origin"}), _NONE, findings)
    return link, end


def _loop(element: Element, findings: Findings) -> CutJoint | None:
    tags = frozenset({"predecessor", "successor", "axis", "origin", "dynamics"})
    check_known(element, frozenset({"name", "type"}), tags, frozenset({"limit"}), findings)
    name = name_of(element, findings)
    kind = str(element.get("type") or "").strip()
    if kind not in TYPES:
        findings.unknown(f"type '{kind}' of <{element.tag}> '{name}'", kind, TYPES, element.sourceline)
    before, before_element = read_end(element, "predecessor", name or "?", findings)
    after, after_element = read_end(element, "successor", name or "?", findings)
    axis = only_child(element, "axis", findings)
    direction: tuple[float, ...] | None = (1.0, 0.0, 0.0)
    if axis is not None:
        direction = read_numbers(axis.get("xyz"), 3, f"axis of <{element.tag}> '{name}'", findings, axis.sourceline)
    if name is None or kind not in TYPES or before is None or after is None or direction is None:
        return None
    unit = unit_axis(direction, name, findings, element.sourceline)
    align = frame_along(unit if TYPES[kind].axes == "z" else (0.0, 0.0, 1.0))
    a, b = (turned(read_origin(end, findings), align) for end in (before_element, after_element))
    place = Place(findings.file, element.sourceline)
    physics = read_dynamics(element, f"<{element.tag}> '{name}'", findings)
    return CutJoint(name, TYPES[kind], Frame(before, a), Frame(after, b), place, physics)


def read_coupling(element: Element, tree: OpenTree, dependent: set[str], findings: Findings) -> Coupling | None:
    """A `<coupling>` as a ratio between two joints; one over more joints is a problem."""
    check_known(element, frozenset({"name", "type"}), frozenset({"predecessor", "successor", "ratio"}), _NONE, findings)
    name = name_of(element, findings)
    before, _ = read_end(element, "predecessor", name or "?", findings)
    after, _ = read_end(element, "successor", name or "?", findings)
    ratio_element = only_child(element, "ratio", findings)
    ratio: tuple[float, ...] | None = (1.0,)
    if ratio_element is not None:
        what = f"ratio of <{element.tag}> '{name}'"
        ratio = read_numbers(ratio_element.get("value"), 1, what, findings, ratio_element.sourceline)
    if name is None or before is None or after is None or ratio is None:
        return None
    line = element.sourceline
    sides = _sides(tree, before, after)
    if any(len(side) != 1 for side in sides):
        first, second = (listing(joint.name for joint in side) for side in sides)
        findings.error(
            f"<{element.tag}> '{name}' ties {first} to {second}",
            "one joint on each side of the nearest common ancestor",
            "couple the joints pair by pair",
            line,
        )
        return None
    driver, joint = sides[0][0].name, sides[1][0].name
    value = ratio[0]
    if driver in dependent and joint not in dependent:
        if value == 0.0:
            findings.error(f"ratio of <{element.tag}> '{name}' is 0", "a number other than 0", "", line)
            return None
        driver, joint, value = joint, driver, 1.0 / value
    return Coupling.geared(name, joint, driver, value, 0.0, Place(findings.file, line))


def _sides(tree: OpenTree, before: str, after: str) -> tuple[list[Joint], list[Joint]]:
    """The moving joints from the nearest common ancestor down to each of two links."""
    above = {joint.child: joint for joint in tree.joints}

    def way(link: str) -> list[Joint]:
        joints: list[Joint] = []
        while link in above and len(joints) <= len(tree.joints):
            joints.append(above[link])
            link = above[link].parent
        return joints

    first, second = way(before), way(after)
    shared = {joint.name for joint in first} & {joint.name for joint in second}
    first = [joint for joint in first if joint.name not in shared and joint.type.moves]
    second = [joint for joint in second if joint.name not in shared and joint.type.moves]
    return first, second
