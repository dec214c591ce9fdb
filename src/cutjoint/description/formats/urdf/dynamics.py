"""The `<dynamics>` of a URDF joint, of a `<loop>` and of a `<constraint>`.

Damping and friction, and attributes that URDF lacks but files have: armature (what a rotor weighs at the joint),
stiffness and rest of a spring, friction_speed.
"""

from __future__ import annotations

from lxml import etree

from cutjoint.description.formats.common.exact import number
from cutjoint.description.formats.common.physics import largest
from cutjoint.description.model import JointPhysics
from cutjoint.description.numbers import read_numbers
from cutjoint.description.xml import Element, check_known, only_child
from cutjoint.findings import Findings

KEYS = ("damping", "friction", "friction_speed", "stiffness", "rest")
"""What is written, by the names in `JointPhysics`."""
_RESTS = ("rest", "springref", "spring_reference")
ATTRIBUTES = frozenset({*KEYS, *_RESTS, "armature"})
_NONE: frozenset[str] = frozenset()


def read_dynamics(element: Element, what: str, findings: Findings, planar: bool = False) -> JointPhysics:
    """The physics that the `<dynamics>` in `element` gives; what cannot be read is noted.

    A `planar` joint of Drake's has three dampings, along x and y and about z, which must be the same.
    """
    dynamics = only_child(element, "dynamics", findings)
    if dynamics is None:
        return JointPhysics()
    check_known(dynamics, ATTRIBUTES, _NONE, _NONE, findings)
    line = dynamics.sourceline
    values: dict[str, float] = {}
    for key in (*KEYS[:-1], "armature"):
        if dynamics.get(key) is not None and key == "damping" and planar:
            values[key] = _same(dynamics.get(key), f"{key} of {what}", findings, line)
        elif dynamics.get(key) is not None:
            value = read_numbers(dynamics.get(key), 1, f"{key} of {what}", findings, line, largest(key))
            values[key] = value[0] if value else 0.0
    rests = [key for key in _RESTS if dynamics.get(key) is not None]
    if len(rests) > 1:
        findings.error(f"{' and '.join(rests)} of {what}", "one rest position", "keep one", line)
    if rests:
        value = read_numbers(dynamics.get(rests[0]), 1, f"{rests[0]} of {what}", findings, line)
        values["rest"] = value[0] if value else 0.0
    values["rotor"] = values.pop("armature", 0.0)
    return JointPhysics(**values)


def _same(text: str, what: str, findings: Findings, line: int | None) -> float:
    """Three numbers that are one."""
    values = read_numbers(text, 3, what, findings, line, largest("damping")) or (0.0, 0.0, 0.0)
    if len({*values}) > 1:
        findings.error(f"{what} is {text}", "three times the same", "make it of two slides and a hinge", line)
    return values[0]


def said(physics: JointPhysics) -> JointPhysics:
    """What of a joint's physics `<dynamics>` says."""
    return JointPhysics(**{key: getattr(physics, key) for key in KEYS})


def write_dynamics(parent: Element, physics: JointPhysics) -> None:
    """The `<dynamics>` of what `said` holds, where there is any."""
    values = {key: getattr(physics, key) for key in KEYS}
    given = {key: value for key, value in values.items() if value is not None and value != 0.0}
    given |= {key: value for key, value in values.items() if value is not None and key in ("friction_speed", "rest")}
    if given and ("damping" in given or "friction" in given):
        given = {"damping": physics.damping, "friction": physics.friction} | given
    if given:
        etree.SubElement(parent, "dynamics", {key: number(given[key]) for key in KEYS if key in given})
