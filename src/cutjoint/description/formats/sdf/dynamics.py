"""What the `<axis>` of an SDF joint says of its limits and of what the joint does by itself.

`<dynamics>`: damping, friction, and a spring that is at rest at spring_reference (0 where it is missing).  `<limit>`:
besides the range, stiffness and dissipation of the stops.  A stiffness from SDF's default on, 1e8, is a stop that does
not yield, as is a missing one: converters write the default into every file.
"""

from __future__ import annotations

import numpy as np

from cutjoint.description.findings import Findings
from cutjoint.description.formats.common.physics import largest
from cutjoint.description.formats.sdf.link import text_of
from cutjoint.description.model import JointPhysics, JointType, Limits
from cutjoint.description.numbers import parse_number, read_numbers
from cutjoint.description.xml import Element, only_child
from cutjoint.mechanism.physics import NO_PHYSICS

UNLIMITED = 1e16
"""SDF's own number for no limit."""
RIGID = 1e8
"""N/m or N m/rad: SDF's default for the stiffness of a stop."""


def read_limits(axis: Element, name: str, kind: JointType, findings: Findings) -> Limits:
    """The range, velocity and effort of an `<axis>`."""
    limit = only_child(axis, "limit", findings)
    if limit is None:
        return Limits()
    values = {}
    for key in ("lower", "upper", "velocity", "effort"):
        element = only_child(limit, key, findings)
        value = None if element is None else parse_number(text_of(element))
        if element is not None and (value is None or np.isnan(value)):
            found = f"{key} limit of joint '{name}' is '{text_of(element)}'"
            findings.error(found, "a number", "", element.sourceline)
        free = value is None or np.isnan(value) or abs(value) >= UNLIMITED
        if key in ("velocity", "effort"):
            free = free or (value is not None and value < 0.0)
        values[key] = None if free else value
    if not kind.limited:
        values["lower"] = values["upper"] = None
    return Limits(values["lower"], values["upper"], values["velocity"], values["effort"])


def read_physics(element: Element, name: str, kind: JointType, findings: Findings) -> JointPhysics:
    """The physics of a `<joint>`: of its axis, or of both, which must be the same."""
    axes = [axis for tag in ("axis", "axis2") if (axis := only_child(element, tag, findings)) is not None]
    found = [_physics(axis, name, kind, findings) for axis in axes]
    if kind.axes == 2 and len(found) == 2 and found[0] != found[1]:
        text = f"the two axes of the {kind.value} joint '{name}' have different dampers, friction or springs"
        findings.error(text, "the same for both", "make it of two revolute joints", element.sourceline)
    if not kind.axes and any(one != NO_PHYSICS for one in found):
        text = f"damping, friction and springs in an <axis> of the {kind.value} joint '{name}' are not used"
        findings.warn(text, "no <axis>", "", element.sourceline)
    return found[0] if found and kind.axes else NO_PHYSICS


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
    element = None if parent is None else only_child(parent, tag, findings)
    if element is None:
        return None
    most = float("inf") if key.startswith("stop") else largest(key)
    value = read_numbers(text_of(element), 1, f"{tag} of joint '{name}'", findings, element.sourceline, most)
    return None if value is None else value[0]
