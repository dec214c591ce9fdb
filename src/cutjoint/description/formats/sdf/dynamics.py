"""What the `<axis>` of an SDF joint says of its limits and of what the joint does by itself.

`<dynamics>`: damping, friction, and a spring that is at rest at spring_reference (0 where it is missing).  `<limit>`:
besides the range, stiffness and dissipation of the stops.  A stiffness from SDF's default on, 1e8, is a stop that does
not yield, as is a missing one: converters write the default into every file.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cutjoint.description.formats.common.physics import largest
from cutjoint.description.formats.sdf.values import text_of
from cutjoint.description.model import JointPhysics, JointType, Limits
from cutjoint.description.numbers import parse_number, read_numbers
from cutjoint.description.xml import Element, children, drake_name, only_child
from cutjoint.findings import Findings
from cutjoint.mechanism.physics import NO_PHYSICS

UNLIMITED = 1e16
"""SDF's own number for no limit."""
ROTORS = {"rotor_inertia": "rotor", "gear_ratio": "gear"}
"""Elements of Drake's in a joint -> what they are."""
RIGID = 1e8
"""N/m or N m/rad: SDF's default for the stiffness of a stop."""


def read_limits(axis: Element, name: str, kind: JointType, findings: Findings) -> Limits:
    """The range, velocity and effort of an `<axis>`."""
    limit = only_child(axis, "limit", findings)
    if limit is None:
        return Limits()
    values = {}
    for key in ("lower", "upper", "velocity", "effort"):
        element = _filled(limit, key, f"{key} limit of joint '{name}'", findings)
        value = None if element is None else parse_number(text_of(element))
        if element is not None and (value is None or np.isnan(value)):
            found = f"{key} limit of joint '{name}' is '{text_of(element)}'"
            findings.error(found, "a number", "", element.sourceline)
        free = value is None or np.isnan(value) or abs(value) >= UNLIMITED
        if key in ("velocity", "effort"):
            free = free or (value is not None and value < 0.0)
        values[key] = None if free else value
    if not kind.limited:
        if values["lower"] is not None or values["upper"] is not None:
            found = f"lower and upper limits of the {kind.value} joint '{name}' are not used"
            findings.warn(found, "a type with a range", "call it revolute", limit.sourceline)
        values["lower"] = values["upper"] = None
    return Limits(values["lower"], values["upper"], values["velocity"], values["effort"])


def unused_axis(axis: Element | None, name: str, kind: JointType, findings: Findings) -> None:
    """Note limits and physics in an axis that the type of its joint does not have."""
    quiet = Findings()
    if axis is None:
        return
    physics, limits = _physics(axis, name, kind, quiet), read_limits(axis, name, JointType.REVOLUTE, quiet)
    if quiet.failed or physics != NO_PHYSICS or limits != Limits() or only_child(axis, "mimic", quiet) is not None:
        text = f"damping, friction, springs, limits and mimic in <{axis.tag}> of the {kind.value} joint '{name}'"
        findings.warn(f"{text} are not used", f"no <{axis.tag}>", "", axis.sourceline)


def read_physics(axis: Element, name: str, kind: JointType, findings: Findings) -> JointPhysics:
    """The physics along an `<axis>`."""
    if only_child(axis, "initial_position", findings) is not None:
        found = f"initial_position of joint '{name}' is not used"
        findings.warn(found, "a home posture", "give it as [home.NAME] of a loops.toml", axis.sourceline)
    return _physics(axis, name, kind, findings)


def _physics(axis: Element, name: str, kind: JointType, findings: Findings) -> JointPhysics:
    numbers = {
        key: _number(axis, "dynamics", tag, key, name, findings)
        for tag, key in (
            ("damping", "damping"),
            ("friction", "friction"),
            ("spring_stiffness", "stiffness"),
            ("spring_reference", "rest"),
        )
    }
    stop = _number(axis, "limit", "stiffness", "stop_stiffness", name, findings)
    dissipation = _number(axis, "limit", "dissipation", "stop_damping", name, findings)
    yields = kind.limited and stop is not None and stop < RIGID
    stiffness = numbers["stiffness"] or 0.0
    return JointPhysics(
        damping=numbers["damping"] or 0.0,
        friction=numbers["friction"] or 0.0,
        stiffness=stiffness,
        rest=(numbers["rest"] or 0.0) if stiffness != 0.0 else None,
        stop_stiffness=(stop or 0.0) if yields else 0.0,
        stop_damping=(1.0 if dissipation is None else dissipation) if yields and stop else 0.0,
    )


def _number(axis: Element, section: str, tag: str, key: str, name: str, findings: Findings) -> float | None:
    """The number in an element of a section of an axis; None where it is missing or wrong."""
    parent = only_child(axis, section, findings)
    element = None if parent is None else _filled(parent, tag, f"{tag} of joint '{name}'", findings)
    if element is None:
        return None
    most = float("inf") if key.startswith("stop") else largest(key)
    value = read_numbers(text_of(element), 1, f"{tag} of joint '{name}'", findings, element.sourceline, most)
    return None if value is None else value[0]


def _filled(parent: Element, tag: str, what: str, findings: Findings) -> Element | None:
    """The child with a number in it; one without anything in it counts as not there, as in libsdformat."""
    element = only_child(parent, tag, findings)
    if element is None or text_of(element):
        return element
    findings.warn(f"{what} is empty: read as not given", "a number", f"remove <{tag}>", element.sourceline)
    return None


def with_rotor(physics: JointPhysics, joint: Element, name: str, kind: JointType, findings: Findings) -> JointPhysics:
    """With the `<drake:rotor_inertia>` and `<drake:gear_ratio>` of a joint."""
    values = {}
    for element in children(joint):
        key = ROTORS.get(drake_name(str(element.tag)) or "")
        if key is not None:
            told = f"{key} of joint '{name}'"
            value = read_numbers(text_of(element), 1, told, findings, element.sourceline, largest(key))
            values.update({} if value is None else {key: value[0]})
    if values and not kind.single:
        findings.warn(
            f"rotor of the {kind.value} joint '{name}' is not used", "a joint of one axis", "", joint.sourceline
        )
        return physics
    return replace(physics, **values)
