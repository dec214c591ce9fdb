"""A `<joint>` of MJCF with the attributes of its class filled in: type, place, axis, range, and what it does by itself.

MuJoCo's spring is at rest at `springref`, which counts as `qpos` does: with `ref` in it.  An `armature` is what a rotor
weighs at the joint.  A `frictionloss` is dry friction that holds what rests; here it acts fully from a small speed on.
"""

from __future__ import annotations

import math

import numpy as np

from cutjoint.description.findings import Findings, closest, nearest
from cutjoint.description.formats.mjcf.pose import AngleUnits
from cutjoint.description.model import Joint, JointPhysics, JointType, Limits, Place
from cutjoint.description.numbers import LARGEST_LENGTH, LARGEST_PHYSICS, parse_number, read_numbers, unit_axis
from cutjoint.description.transforms import from_rotation
from cutjoint.description.xml import Element

UNLIMITED = 1e10
"""A range that ends beyond this has no end there."""
TYPES = {"hinge": JointType.REVOLUTE, "slide": JointType.PRISMATIC, "ball": JointType.SPHERICAL}

_SOFT = {
    "solreflimit": "0.02 1",
    "solimplimit": "0.9 0.95 0.001 0.5 2",
    "solreffriction": "0.02 1",
    "solimpfriction": "0.9 0.95 0.001 0.5 2",
    "margin": "0",
}
"""How soft MuJoCo's constraints are, with its defaults."""
_NUMBERS = ("damping", "frictionloss", "ref", "stiffness", "springref", "armature")
_KNOWN = frozenset(
    {"name", "class", "type", "group", "pos", "axis", "range", "limited", "actuatorfrcrange", "actuatorfrclimited"}
    | {"actuatorgravcomp", "springdamper", "user", *_NUMBERS, *_SOFT}
)


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
    numbers = _numbers(get, name, findings, line)
    if position is None or values is None:
        return None
    measure = units if kind == "hinge" else AngleUnits(degrees=False)
    reference, spring = measure.angle(numbers["ref"]), measure.angle(numbers["springref"])
    rest = 0.0 if kind == "ball" else spring - reference
    physics = _physics(numbers, rest)
    limits = Limits() if kind == "ball" else _limits(get, measure, reference, name, findings, line)
    if kind != "ball":
        limits = Limits(
            limits.lower, limits.upper, None, force_limit(get, "actuatorfrc", f"joint '{name}'", findings, line)
        )
    axis = unit_axis(values, name, findings, line, any_length=True) if kind != "ball" else np.eye(3)[0]
    endless = kind == "hinge" and limits.lower is None and limits.upper is None
    joint = Joint(
        name, JointType.CONTINUOUS if endless else TYPES[kind], body, body, from_rotation(np.eye(3), position), axis,
        limits=limits, physics=physics, place=Place(findings.file, line),
    )  # fmt: skip
    return joint, reference


def read_free_joint(element: Element, get: dict[str, str], body: str, findings: Findings) -> Joint:
    """A `<freejoint>`, which does nothing by itself, or a `<joint type="free">`, which has dampers."""
    name, place = str(element.get("name") or f"{body}_free"), Place(findings.file, element.sourceline)
    numbers = _numbers(get, name, findings, element.sourceline)
    for key in ("stiffness", "frictionloss", "armature"):
        if numbers[key] != 0.0:
            found = f"{key} {numbers[key]:g} of the free joint '{name}'"
            findings.error(found, "damping only", "a <freejoint/> does not take the defaults of joints", place)
    physics = JointPhysics(damping=numbers["damping"])
    return Joint(name, JointType.FLOATING, body, body, physics=physics, place=place)


def _numbers(get: dict[str, str], name: str, findings: Findings, line: int | None) -> dict[str, float]:
    """The numbers among a joint's attributes; notes those that are not read."""
    what = f"joint '{name}'"
    for key in get:
        if key not in _KNOWN:
            near = closest(key, _KNOWN, cutoff=0.8)
            note = findings.error if near else findings.warn
            note(f"unknown attribute '{key}' of {what}", "an attribute of MuJoCo's joints", nearest(key, _KNOWN), line)
    numbers = {}
    for key in _NUMBERS:
        largest = LARGEST_LENGTH if key in ("ref", "springref") else LARGEST_PHYSICS
        value = read_numbers(_linear(get.get(key, "0"), key), 1, f"{key} of {what}", findings, line, largest)
        numbers[key] = value[0] if value else 0.0
    changed = [key for key, default in _SOFT.items() if key in get and not _same(get[key], default)]
    if changed:
        mend = f"soft stops are stop_stiffness and stop_damping under [joint.{name}] of a loops.toml"
        findings.warn(f"{', '.join(changed)} of {what} not used", "hard limits and dry friction", mend, line)
    if any(parse_number(word) != 0.0 for word in get.get("springdamper", "0").split()):
        mend = "write the stiffness and damping that MuJoCo computes (jnt_stiffness, dof_damping of its MjModel)"
        findings.warn(f"springdamper of {what} is not used", "stiffness and damping", mend, line)
    return numbers


def _linear(text: str, key: str) -> str:
    """A stiffness or damping whose higher coefficients are 0 as one number."""
    words = text.split()
    if key in ("stiffness", "damping") and len(words) > 1 and all(parse_number(word) == 0.0 for word in words[1:]):
        return words[0]
    return text


def _same(text: str, default: str) -> bool:
    given, usual = ([parse_number(word) for word in words.split()] for words in (text, default))
    return given == usual[: len(given)]


def _physics(numbers: dict[str, float], rest: float) -> JointPhysics:
    stiffness = numbers["stiffness"]
    return JointPhysics(
        damping=numbers["damping"],
        friction=numbers["frictionloss"],
        stiffness=stiffness,
        rest=rest if stiffness != 0.0 else None,
        rotor=numbers["armature"],
    )


def force_limit(get: dict[str, str], key: str, what: str, findings: Findings, line: int | None) -> float | None:
    """The size that a range of forces allows; None where there is none.  A range askew is told."""
    if f"{key}range" not in get or get.get(f"{key}limited") == "false":
        return None
    values = read_numbers(get[f"{key}range"], 2, f"{key}range of {what}", findings, line, LARGEST_PHYSICS)
    if values is None or values == (0.0, 0.0):
        return None
    if values[0] != -values[1]:
        shown = f"{values[0]:g} {values[1]:g}"
        findings.warn(f"{key}range of {what} is {shown}: not used", "as much force both ways", "", line)
        return None
    return values[1]


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
