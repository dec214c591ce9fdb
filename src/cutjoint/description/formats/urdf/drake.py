"""Drake's extensions of URDF that join, couple or act on links (https://drake.mit.edu, Parsing Models for Multibody
Dynamics).

    drake:ball_constraint       a point of one body stays on a point of the other: a spherical cut
    drake:tendon_constraint     sum of a_i q_i + offset between two limits; rigid and with equal limits: a coupling
    drake:linear_bushing_rpy    springs and dampers between two frames (`bushing`)
    drake:joint                 ball, universal, planar and screw joints of the tree; curves are refused
    drake:linear_spring_damper  refused: there are no springs between points

Everything else with Drake's prefix is about contact, looks and its own controllers.  Drake knows a link `world` that
need not stand in the file; what no joint ties to it floats.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, count

from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.formats.urdf.bushing import read_bushing
from cutjoint.description.formats.urdf.link import origin_of
from cutjoint.description.model import Coupling, CutJoint, CutType, Frame, Joint, JointType, Link, Place
from cutjoint.description.numbers import LARGEST_PHYSICS, parse_number, read_numbers
from cutjoint.description.transforms import from_rotation
from cutjoint.description.xml import Element, check_known, children, drake_name, name_of, short
from cutjoint.findings import LARGEST_LENGTH, Findings, Harmless, closest, nearest

WORLD = "world"
_NONE: frozenset[str] = frozenset()
ROBOT_TAGS = frozenset(
    {"drake:joint", "drake:ball_constraint", "drake:linear_bushing_rpy", "drake:linear_spring_damper"}
    | {"drake:tendon_constraint", "drake:collision_filter_group"}
)
"""What Drake adds to a `<robot>`, besides `frame` without a prefix."""
_GROUP = frozenset({"drake:member", "drake:member_group", "drake:ignored_collision_filter_group"})
_TENDON = tuple(
    f"tendon_constraint_{what}" for what in ("offset", "lower_limit", "upper_limit", "stiffness", "damping")
)


@dataclass(frozen=True)
class Parts:
    """The children of one of Drake's elements, which tell by an attribute: `what` for messages."""

    element: Element
    what: str
    by_name: Mapping[str, Element]

    @classmethod
    def of(cls, element: Element, names: Sequence[str], findings: Findings, repeated: str = "") -> Parts:
        """Of an element that has each of `names` at most once (but for `repeated`)."""
        known = frozenset(f"drake:{name}" for name in (*names, repeated) if name)
        check_known(element, frozenset({"name"}), known, _NONE, findings)
        found: dict[str, Element] = {}
        for child in children(element):
            name = drake_name(str(child.tag)) or ""
            if name in found and name != repeated:
                what = f"several <drake:{name}> in one <{short(str(element.tag))}>"
                findings.error(what, "one", "keep one", child.sourceline)
            attributes = {"name", "a"} if name == repeated else {"name", "value"}
            check_known(child, frozenset(attributes), _NONE, _NONE, findings)
            found[name] = child
        return cls(element, f"<{short(str(element.tag))}>", found)

    def text(self, name: str, attribute: str, findings: Findings) -> str | None:
        """What the child says, or None after noting that it says nothing."""
        child = self.by_name.get(name)
        said = None if child is None else str(child.get(attribute) or "").strip()
        if not said:
            line = self.element.sourceline if child is None else child.sourceline
            found = f"{self.what} without {attribute} of <drake:{name}>"
            findings.error(found, f'<drake:{name} {attribute}="..."/>', "", line)
        return said or None

    def numbers(self, name: str, count: int, findings: Findings, largest: float) -> tuple[float, ...] | None:
        """The numbers of the child, or None after noting what is wrong with them."""
        text = self.text(name, "value", findings)
        if text is None:
            return None
        return read_numbers(text, count, f"<drake:{name}>", findings, self.by_name[name].sourceline, largest)


def hold_by_world(root: Element, tree: OpenTree, findings: Findings) -> None:
    """Add the link `world` where joints name it and the file has none, and let float what hangs on nothing beside it.

    The latter also where the world is in the file and Drake's elements tell that it is one for Drake.
    """
    names = {link.name for link in tree.links}
    at = next((joint for joint in tree.joints if joint.parent == WORLD), None)
    if at is None or (WORLD not in names and closest(WORLD, names)):
        return
    if WORLD not in names:
        found = f"joint '{at.name}' hangs on '{WORLD}', which is no link of the file: read as what does not move"
        findings.warn(found, f'<link name="{WORLD}"/>', "Drake takes it so; others refuse the file", at.place)
        tree.links.insert(0, Link(WORLD, place=at.place))
    elif not any(drake_name(str(one.tag)) for one in root.iter("{*}*")):
        return
    carried = {joint.child for joint in tree.joints} | {WORLD}
    for link in [link for link in tree.links if link.name not in carried]:
        findings.warn(f"link '{link.name}', which hangs on nothing, floats beside the world", "", "", link.place)
        name = f"{link.name}_root_joint"
        tree.joints.append(Joint(name, JointType.FLOATING, WORLD, link.name, place=link.place))


def read_drake(root: Element, tree: OpenTree, findings: Findings) -> None:
    """Add to `tree` the cuts and couplings of Drake's elements."""
    frames = _frames(root, tree, findings)
    for element in children(root):
        name = drake_name(str(element.tag))
        if name == "ball_constraint":
            tree.cuts += _ball(element, tree, findings)
        elif name == "tendon_constraint":
            _tendon(element, tree, findings)
        elif name == "linear_bushing_rpy":
            tree.cuts += _bushing(element, frames, tree, findings)
        elif name == "linear_spring_damper":
            points = "springs of joints and bushings of cuts"
            _unread(element, "a spring between two points", points, findings)
        elif name == "collision_filter_group":
            check_known(element, frozenset({"name", "ignore"}), _GROUP, _NONE, Harmless(findings))
            for member in children(element):
                check_known(member, frozenset({"name", "link"}), _NONE, _NONE, Harmless(findings))


def _unread(element: Element, what: str, expected: str, findings: Findings) -> None:
    """Quote an element that acts and cannot be read."""
    said = " ".join(
        f"{(drake_name(str(one.tag)) or one.tag)}={value}" for one in children(element) for value in one.attrib.values()
    )
    found = f"<{short(str(element.tag))}> ({said or 'empty'}), {what}, cannot be read"
    findings.doubt(found, expected, "write it otherwise, or remove it", element.sourceline)


def _named(base: str, tree: OpenTree) -> str:
    """A name for a cut or coupling that Drake's file leaves without."""
    taken = {cut.name for cut in tree.cuts} | {coupling.name for coupling in tree.couplings}
    return next(name for name in chain([base], (f"{base}_{number}" for number in count(2))) if name not in taken)


def _frames(root: Element, tree: OpenTree, findings: Findings) -> dict[str, Frame]:
    """The links as frames, and Drake's `<frame name link xyz rpy>`."""
    frames = {link.name: Frame(link.name) for link in tree.links}
    for element in children(root, "frame"):
        check_known(element, frozenset({"name", "link", "xyz", "rpy"}), _NONE, _NONE, findings)
        name, link = name_of(element, findings), str(element.get("link") or "").strip()
        if link not in frames:
            found = f"<frame> '{name}' on the unknown link '{link}'"
            findings.error(found, "a link", nearest(link, frames), element.sourceline)
        elif name is not None:
            frames[name] = Frame(link, origin_of(element, f"<frame> '{name}'", findings))
    return frames


def _ball(element: Element, tree: OpenTree, findings: Findings) -> list[CutJoint]:
    ends = [("ball_constraint_body_A", "ball_constraint_p_AP"), ("ball_constraint_body_B", "ball_constraint_p_BQ")]
    parts = Parts.of(element, [name for end in ends for name in end], findings)
    frames = []
    for body, point in ends:
        link, at = parts.text(body, "name", findings), parts.numbers(point, 3, findings, LARGEST_LENGTH)
        if link is not None and at is not None:
            frames.append(Frame(link, from_rotation(_UPRIGHT, at)))
    if len(frames) != 2:
        return []
    name = str(element.get("name") or "").strip() or _named(f"{frames[0].link}_{frames[1].link}_ball", tree)
    return [CutJoint(name, CutType.SPHERICAL, frames[0], frames[1], Place(findings.file, element.sourceline))]


_UPRIGHT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _tendon(element: Element, tree: OpenTree, findings: Findings) -> None:
    """A tendon that holds a sum of joints: the last of them follows."""
    parts = Parts.of(element, _TENDON, findings, repeated="tendon_constraint_joint")
    ratios: dict[str, float] = {}
    for joint in children(element):
        if drake_name(str(joint.tag)) == "tendon_constraint_joint":
            name, line = str(joint.get("name") or "").strip(), joint.sourceline
            factor = read_numbers(joint.get("a"), 1, f"a of joint '{name}' in {parts.what}", findings, line)
            ratios[name] = ratios.get(name, 0.0) + (factor[0] if factor else 0.0)
    values = {name: _optional(parts, name, findings) for name in _TENDON}
    lower, upper = values["tendon_constraint_lower_limit"], values["tendon_constraint_upper_limit"]
    soft = (values["tendon_constraint_stiffness"], values["tendon_constraint_damping"])
    ratios = {name: factor for name, factor in ratios.items() if factor != 0.0}
    if lower is None or lower != upper or not ratios or soft[0] not in (None, math.inf):
        _unread(element, "a tendon that is slack, soft or without joints", "equal limits and no stiffness", findings)
        return
    name, last = list(ratios.items())[-1]
    others = {one: -factor / last for one, factor in ratios.items() if one != name}
    offset = (lower - (values["tendon_constraint_offset"] or 0.0)) / last
    title = str(element.get("name") or "").strip() or _named(f"{name}_tendon", tree)
    place = Place(findings.file, element.sourceline)
    tree.couplings.append(Coupling.summed(title, name, others, offset, place))


def _optional(parts: Parts, name: str, findings: Findings) -> float | None:
    """The number of a child that may be missing; infinity is a number here."""
    if name not in parts.by_name:
        return None
    value = parse_number(str(parts.by_name[name].get("value") or ""))
    if value is not None and math.isinf(value):
        return value
    numbers = parts.numbers(name, 1, findings, LARGEST_PHYSICS)
    return numbers[0] if numbers else None


def _bushing(element: Element, frames: Mapping[str, Frame], tree: OpenTree, findings: Findings) -> list[CutJoint]:
    kinds = [f"bushing_{what}_{how}" for what in ("force", "torque") for how in ("stiffness", "damping")]
    parts = Parts.of(element, ["bushing_frameA", "bushing_frameC", *kinds], findings)
    ends = [parts.text(name, "name", findings) for name in ("bushing_frameA", "bushing_frameC")]
    values: list[tuple[float, ...]] = []
    for kind in kinds:
        values += [number] if (number := parts.numbers(kind, 3, findings, LARGEST_PHYSICS)) else []
    for name in ends:
        if name is not None and name not in frames:
            found = f"{parts.what} names the unknown frame '{name}'"
            findings.error(found, "a link or <frame>", nearest(name, frames), element.sourceline)
    a, b = (frames.get(name or "") for name in ends)
    if len(values) < len(kinds) or a is None or b is None:
        return []
    name = str(element.get("name") or "").strip() or _named(f"{ends[0]}_{ends[1]}_bushing", tree)
    cut = read_bushing(name, (a, b), values, Place(findings.file, element.sourceline), findings)
    if cut is None:
        along = "the same force in all directions, and the same torque about all axes, all but one, or none"
        _unread(element, "a bushing with other numbers in each direction", along, findings)
    return [] if cut is None else [cut]
