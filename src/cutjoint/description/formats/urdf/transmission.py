"""`<transmission>` and `<ros2_control>` of a URDF: which joints are driven, through which gears, by which rotors.

A reduction tells how many times as fast as its joint the motor turns, as `mechanicalReduction`, `mechanical_reduction`
(ros_control, ros2_control) or Drake's `drake:gear_ratio`; the rotor's inertia stands in `rotorInertia`,
`rotor_inertia` or Drake's `drake:rotor_inertia` (https://drake.mit.edu, multibody parsing).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from cutjoint.description.model import Joint
from cutjoint.description.numbers import LARGEST_PHYSICS, read_numbers
from cutjoint.description.xml import Element, children
from cutjoint.findings import Findings, listing, nearest

_GEARS = frozenset({"mechanicalReduction", "mechanical_reduction", "gear_ratio"})
_DRIVEN = ("joint", "flexJoint", "rollJoint")
"""What a transmission drives; the last two in the wrist of the PR2."""
_ROTORS = frozenset({"rotorInertia", "rotor_inertia"})


def driven(root: Element) -> tuple[str, ...]:
    """The joints that a `<transmission>` drives or a `<ros2_control>` commands, each once."""
    names = [
        one.get("name") for each in children(root, "transmission") for tag in _DRIVEN for one in children(each, tag)
    ]
    for control in children(root, "ros2_control"):
        names += [one.get("name") for one in children(control, "joint") if list(children(one, "command_interface"))]
    return tuple(dict.fromkeys(str(name) for name in names if name))


def geared(joints: Sequence[Joint], root: Element, findings: Findings) -> list[Joint]:
    """The joints with the gears and rotors of all transmissions."""
    known = {joint.name: joint for joint in joints}
    changed: dict[str, Joint] = {}
    transmissions = [*children(root, "transmission")]
    for control in children(root, "ros2_control"):
        transmissions += children(control, "transmission")
    for element in transmissions:
        name = str(element.get("name") or "").strip()
        what, line = f"<transmission> '{name}'", element.sourceline
        gear = _one(element, _GEARS, 1.0, f"reduction of {what}", findings)
        rotor = _one(element, _ROTORS, 0.0, f"rotor inertia of {what}", findings)
        driven_by = [str(one.get("name") or "").strip() for tag in _DRIVEN for one in children(element, tag)]
        plain = gear is None or rotor is None or (gear == 1.0 and rotor == 0.0)
        if len(driven_by) > 1 and plain:
            text = f"{what} drives {listing(driven_by)} together: each is read with a motor of its own"
            findings.warn(text, "one joint a transmission", "motor torques are those at the joints", line)
        if gear is None or rotor is None or plain:
            continue
        if len(driven_by) != 1:
            text = f"reduction and rotor of {what} are not used: it drives {listing(driven_by)}"
            findings.warn(text, "one joint a transmission", "give gear and rotor in a loops.toml", line)
        elif driven_by[0] not in known:
            text = f"{what} names the unknown joint '{driven_by[0]}'"
            findings.warn(text, "a joint", nearest(driven_by[0], known), line)
        else:
            joint = changed.get(driven_by[0], known[driven_by[0]])
            changed[joint.name] = _with(joint, gear, rotor, what, findings, line)
    return [changed.get(joint.name, joint) for joint in joints]


def _with(joint: Joint, gear: float, rotor: float, what: str, findings: Findings, line: int | None) -> Joint:
    """The joint with a gear and a rotor.  An armature that its `<dynamics>` gives stays what it is at the joint."""
    physics = joint.physics
    if physics.rotor != 0.0 and rotor != 0.0:
        text = f"joint '{joint.name}' with an armature and with the rotor inertia of {what}"
        findings.error(text, "one of them", "an armature is the rotor's inertia times the square of the gear", line)
    if physics.gear != 1.0:
        text = f"joint '{joint.name}' with a second reduction, of {what}"
        findings.error(text, "one motor a joint", "keep one", line)
    if rotor == 0.0 and gear != 0.0:
        rotor = physics.rotor / (gear * gear)
    return replace(joint, physics=replace(physics, gear=gear, rotor=rotor))


def _one(element: Element, names: frozenset[str], default: float, what: str, findings: Findings) -> float | None:
    """The number that elements of these names give inside `element`; None after noting what is wrong with it."""
    values = []
    for one in element.iter():
        tag = str(one.tag).rsplit("}", 1)[-1].rsplit(":", 1)[-1]
        if tag in names:
            text = str(one.get("value") or one.text or "")
            value = read_numbers(text, 1, what, findings, one.sourceline, LARGEST_PHYSICS)
            if value is None:
                return None
            values.append(value[0])
    different = {value for value in values if value != default}
    if len(different) > 1:
        shown = " and ".join(f"{value:g}" for value in values)
        findings.error(f"{what} is {shown}", "one number", "keep one", element.sourceline)
        return None
    return next(iter(different), default)
