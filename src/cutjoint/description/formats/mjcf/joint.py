"""Joints of an MJCF body."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cutjoint.description.findings import Findings, nearest
from cutjoint.description.formats.mjcf.pose import AngleUnits
from cutjoint.description.formats.mjcf.types import MADE_OF
from cutjoint.description.model import Joint, JointType, Limits, Place
from cutjoint.description.numbers import parse_number, read_numbers, unit_axis
from cutjoint.description.transforms import from_rotation
from cutjoint.description.xml import Element

UNLIMITED = 1e10
"""A range that ends beyond this has no end there."""
TYPES = {"hinge": JointType.REVOLUTE, "slide": JointType.PRISMATIC, "ball": JointType.SPHERICAL}


def read_joint(
    element: Element, get: dict[str, str], units: AngleUnits, body: str, number: int, findings: Findings
) -> tuple[Joint, float] | None:
    """A `<joint>` at its point of the body, with the attributes of its class filled in, and its coordinate `ref`."""
    name = get.get("name") or (f"{body}_joint" if number == 0 else f"{body}_joint_{number + 1}")
    kind = get.get("type", "hinge")
    line = element.sourceline
    if kind not in TYPES:
        expected = f"one of free, {', '.join(TYPES)}"
        findings.error(f"type '{kind}' of joint '{name}'", expected, nearest(kind, [*TYPES, "free"]), line)
        return None
    position = read_numbers(get.get("pos", "0 0 0"), 3, f"pos of joint '{name}'", findings, line)
    values = read_numbers(get.get("axis", "0 0 1"), 3, f"axis of joint '{name}'", findings, line)
    numbers = {}
    for key in ("damping", "frictionloss", "ref", "stiffness", "armature"):
        value = read_numbers(get.get(key, "0"), 1, f"{key} of joint '{name}'", findings, line)
        numbers[key] = value[0] if value else 0.0
    for key in ("stiffness", "armature"):
        if numbers[key] != 0.0:
            findings.warn(f"{key} of joint '{name}' is ignored", f"{key} 0", "", line)
    if position is None or values is None:
        return None
    hinge = kind == "hinge"
    reference = units.angle(numbers["ref"]) if hinge else numbers["ref"]
    measure = units if hinge else AngleUnits(degrees=False)
    limits = Limits() if kind == "ball" else _limits(get, measure, reference, name, findings, line)
    axis = unit_axis(values, name, findings, line, any_length=True) if kind != "ball" else np.eye(3)[0]
    kind_of = JointType.CONTINUOUS if hinge and limits.lower is None and limits.upper is None else TYPES[kind]
    joint = Joint(
        name, kind_of, body, body, from_rotation(np.eye(3), position), axis, limits=limits,
        damping=numbers["damping"], friction=numbers["frictionloss"], place=Place(findings.file, line),
    )  # fmt: skip
    return joint, reference


def _limits(
    get: dict[str, str], units: AngleUnits, reference: float, name: str, findings: Findings, line: int | None
) -> Limits:
    if "range" not in get or get.get("limited") == "false":
        return Limits()
    words = [parse_number(word) for word in get["range"].split()]
    if len(words) != 2 or any(word is None or math.isnan(word) for word in words):
        findings.error(f"range of joint '{name}' is '{get['range']}'", "two numbers", "", line)
        return Limits()
    lower, upper = (units.angle(float(word)) - reference for word in words if word is not None)
    return Limits(lower if abs(lower) < UNLIMITED else None, upper if abs(upper) < UNLIMITED else None)


def merged(joints: list[Joint]) -> list[Joint]:
    """X and X/2 as one universal joint, up to X/3 a planar one, up to X/4 a floating one; else as they are."""
    if not joints or joints[0].placement[:3, 3].any():
        return joints
    first, others = joints[0], joints[1:]
    named = [one.name for one in others] == [f"{first.name}/{number}" for number in range(2, len(joints) + 1)]
    if not named or any(not np.array_equal(one.placement, first.placement) for one in others):
        return joints
    kinds = tuple(kind for one in joints for kind in MADE_OF[one.type])
    together = next((kind for kind, made in MADE_OF.items() if made == kinds and len(made) == len(joints) > 1), None)
    slides, hinges = ([one.axis for one in joints if MADE_OF[one.type] == (kind,)] for kind in ("slide", "hinge"))
    askew = len(hinges) == 2 and abs(hinges[0] @ hinges[1]) >= 1e-9
    if together is None or askew or (len(slides) == 3 and not np.array_equal(slides, np.eye(3))):
        return joints
    axis, axis2 = (*hinges, *(first.axis, first.axis2)[len(hinges) :])
    return [replace(first, type=together, axis=axis, axis2=axis2, limits=Limits())]
