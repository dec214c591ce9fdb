"""The `<joint>` of a URDF: type, placement, axis, limits, dynamics and mimic."""

from __future__ import annotations

import math
from collections.abc import Mapping

from cutjoint.arrays import Array, readonly
from cutjoint.description.formats.common.screw import SCREW, Screw
from cutjoint.description.formats.urdf.dynamics import read_dynamics
from cutjoint.description.formats.urdf.link import read_origin
from cutjoint.description.model import Coupling, Joint, JointType, Limits, Place
from cutjoint.description.numbers import number_problem, parse_number, read_numbers, unit_axis
from cutjoint.description.xml import Element, check_known, children, drake_name, name_of, only_child, short
from cutjoint.findings import Findings, Harmless

TYPES = {kind.urdf: kind for kind in JointType if kind.urdf}

_NONE: frozenset[str] = frozenset()
_TAGS = frozenset(
    {"parent", "child", "origin", "axis", "limit", "dynamics", "mimic", "calibration", "safety_controller"}
)
_IGNORED = frozenset({"hardwareInterface", "hardware_interface", "stiffness", "transmission", "drake:mimic"})
_MIMIC = frozenset({"joint", "multiplier", "offset"})
_ATTRIBUTES = {
    "parent": frozenset({"link"}),
    "child": frozenset({"link"}),
    "axis": frozenset({"xyz"}),
    "limit": frozenset({"lower", "upper", "velocity", "effort", "acceleration", "deceleration", "jerk"})
    | {"drake:acceleration"},
    "mimic": _MIMIC,
    "calibration": frozenset({"rising", "falling", "reference_position", "values"}),
    "safety_controller": frozenset({"soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"}),
}
_DRAKE_TYPES = {
    "ball": JointType.SPHERICAL,
    "universal": JointType.UNIVERSAL,
    "planar": JointType.PLANAR,
    SCREW: JointType.CONTINUOUS,
}
"""Types of Drake's `<drake:joint>`: a universal joint turns about x and y, a planar one moves in x and y, whatever axis
stands there; a screw is read as its hinge."""
_PITCH = "drake:screw_thread_pitch"
_X, _Z = readonly([1.0, 0.0, 0.0]), readonly([0.0, 0.0, 1.0])


def read_joint(element: Element, findings: Findings) -> tuple[Joint | None, Coupling | None]:
    """One `<joint>` and the coupling of its `<mimic>`; None for what is not there or not readable."""
    drake = drake_name(str(element.tag)) is not None
    screw = drake and str(element.get("type") or "").strip() == SCREW
    tags = _TAGS | {_PITCH} if screw else _TAGS
    check_known(element, frozenset({"name", "type", "independent"}), tags, _IGNORED, findings)
    for tag, attributes in _ATTRIBUTES.items():
        for child in children(element, tag):
            still = tag in ("calibration", "safety_controller")
            check_known(child, attributes, _NONE, _NONE, Harmless(findings) if still else findings)
    for tag in ("stiffness", "transmission"):
        for child in children(element, tag):
            found = f"<{tag}> in joint '{element.get('name') or '?'}' is not used"
            findings.warn(found, "stiffness and rest in <dynamics>, a <transmission> of its own", "", child.sourceline)
    name = name_of(element, findings)
    kind = _type(element, name or "?", _DRAKE_TYPES if drake else TYPES, findings)
    parent = _end(element, "parent", name or "?", findings)
    child_name = _end(element, "child", name or "?", findings)
    origin = read_origin(element, findings)
    if name is None or parent is None or child_name is None:
        return None, None
    place = Place(findings.file, element.sourceline)
    joint = Joint(
        name=name,
        type=kind,
        parent=parent,
        child=child_name,
        placement=origin,
        axis=(_Z if kind is JointType.PLANAR else _X) if drake and not screw else _axis(element, name, kind, findings),
        limits=_limits(element, name, kind, findings),
        physics=read_dynamics(element, f"joint '{name}'", findings, drake and kind is JointType.PLANAR),
        place=place,
    )
    return joint, _mimic(element, name, kind, findings)


def read_screw(element: Element, joint: Joint, findings: Findings) -> Screw | None:
    """The screw of Drake's of which `joint` is the hinge; None for other joints, and after noting what is wrong.

    Its pitch is in metres per turn, positive for a right-handed thread.
    """
    if drake_name(str(element.tag)) is None or str(element.get("type") or "").strip() != SCREW:
        return None
    pitch = next((one for one in children(element) if short(str(one.tag)) == _PITCH), None)
    line = element.sourceline if pitch is None else pitch.sourceline
    text = None if pitch is None else pitch.get("value")
    value = read_numbers(text, 1, f"{_PITCH} of joint '{joint.name}'", findings, line)
    return None if value is None else Screw.of(joint, value[0] / math.tau)


def _type(element: Element, name: str, types: Mapping[str, JointType], findings: Findings) -> JointType:
    """The type; a wrong one is noted once and read as revolute, so that nothing else seems to be missing."""
    text = str(element.get("type") or "").strip()
    if text not in types:
        what = f"type '{text}' of joint '{name}'" if text else f"joint '{name}' without a type"
        findings.unknown(what, text, types, element.sourceline)
        return JointType.REVOLUTE
    return types[text]


def _end(element: Element, tag: str, name: str, findings: Findings) -> str | None:
    found = list(children(element, tag))
    if len(found) > 1:
        findings.error(
            f"joint '{name}' with {len(found)} <{tag}> elements",
            "one",
            "a joint joins two links; close loops with cut joints",
            found[1].sourceline,
        )
    link = str(found[0].get("link") or "").strip() if found else ""
    if not link:
        line = found[0].sourceline if found else element.sourceline
        findings.error(f"joint '{name}' without {tag} link", f'<{tag} link="..."/>', "", line)
        return None
    return link


def _axis(element: Element, name: str, kind: JointType, findings: Findings) -> Array:
    axis = only_child(element, "axis", findings)
    if axis is None or not kind.axes:
        return _X
    values = read_numbers(axis.get("xyz"), 3, f"axis of joint '{name}'", findings, axis.sourceline)
    if values is None:
        return _X
    return unit_axis(values, name, findings, axis.sourceline)


def _limits(element: Element, name: str, kind: JointType, findings: Findings) -> Limits:
    limit = only_child(element, "limit", findings)
    if limit is None:
        if kind.limited and only_child(element, "mimic", Findings()) is None:
            findings.warn(
                f"joint '{name}' without <limit>", f"<limit> on a {kind.value} joint", "read as no limit",
                element.sourceline,
            )  # fmt: skip
        return Limits()
    line = limit.sourceline
    values = {key: _limit(limit, key, name, findings) for key in ("lower", "upper", "velocity", "effort")}
    lower, upper = values["lower"], values["upper"]
    if not kind.limited:
        lower = upper = None
    elif limit.get("lower") is None and limit.get("upper") is None:
        findings.warn(f"<limit> of joint '{name}' without lower and upper", "both", "read as no limit", line)
    elif limit.get("lower") is None or limit.get("upper") is None:
        missing = "lower" if limit.get("lower") is None else "upper"
        findings.warn(f"<limit> of joint '{name}' without {missing}", "both", "read as 0, the default of URDF", line)
        lower, upper = (0.0, upper) if missing == "lower" else (lower, 0.0)
    return Limits(lower, upper, values["velocity"], values["effort"])


def _limit(limit: Element, key: str, name: str, findings: Findings) -> float | None:
    text = limit.get(key)
    if text is None:
        return None
    value = parse_number(text)
    if value is None:
        found, mend = number_problem(text)
        findings.error(f"{key} limit of joint '{name}': {found}", "a number", mend, limit.sourceline)
        return None
    if math.isnan(value):
        findings.error(f"{key} limit of joint '{name}' is nan", "a number", "", limit.sourceline)
        return None
    return value if math.isfinite(value) else None


def _mimic(element: Element, name: str, kind: JointType, findings: Findings) -> Coupling | None:
    found = [one for one in children(element) if one.tag == "mimic" or drake_name(str(one.tag)) == "mimic"]
    if not found:
        return None
    if not kind.moves:
        what = f"<mimic> of joint '{name}', which is fixed, is not used"
        findings.warn(what, "a joint that moves", "", found[0].sourceline)
        return None
    if len(found) > 1:
        what = f"{len(found)} <mimic> in joint '{name}'"
        findings.error(what, "at most one", "keep one", found[1].sourceline)
    mimic = found[0]
    check_known(mimic, _MIMIC, _NONE, _NONE, findings)
    line = mimic.sourceline
    driver = str(mimic.get("joint") or "").strip()
    if not driver:
        findings.error(f"<mimic> of joint '{name}' without joint", '<mimic joint="..."/>', "", line)
    ratio = read_numbers(mimic.get("multiplier", "1"), 1, f"multiplier of joint '{name}'", findings, line)
    offset = read_numbers(mimic.get("offset", "0"), 1, f"offset of joint '{name}'", findings, line)
    if not driver or ratio is None or offset is None:
        return None
    return Coupling.geared(f"{name}_mimic", name, driver, ratio[0], offset[0], Place(findings.file, line))
