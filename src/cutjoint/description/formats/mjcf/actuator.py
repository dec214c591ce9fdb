"""`<actuator>` in MJCF: which joints are driven, how hard, and what their motors weigh and brake.

The force at a joint is `gear` times that of its actuator, which `forcerange` bounds, or for a motor `ctrlrange`.  The
gear is a lever of the force: it does not touch the joint's own armature.  An actuator's own `armature` and `damping`
are those of a rotor that turns `gear` times as fast as the joint.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from cutjoint.description.findings import Findings, nearest
from cutjoint.description.formats.mjcf.body import Bodies
from cutjoint.description.formats.mjcf.joint import force_limit
from cutjoint.description.model import Joint
from cutjoint.description.numbers import LARGEST_PHYSICS, read_numbers
from cutjoint.description.xml import Element, children


@dataclass(frozen=True)
class Motor:
    """An actuator of a joint: its gear, the force that it has at most, rotor inertia and damping before the gear."""

    joint: str
    gear: float
    force: float | None
    rotor: float
    damping: float

    @property
    def effort(self) -> float | None:
        """The most at the joint, [N] or [N m]."""
        return None if self.force is None else abs(self.gear) * self.force


def read_motors(root: Element, bodies: Bodies, findings: Findings) -> list[Motor]:
    """The actuators of joints."""
    motors = []
    for section in children(root, "actuator"):
        for element in children(section):
            get = bodies.defaults.attributes(element, "")
            joint = get.get("joint") or get.get("jointinparent") or ""
            if not joint:
                found = f"<{element.tag}> without joint is not read"
                findings.warn(found, "actuators of joints", "", element.sourceline)
            elif joint not in bodies.joint_names:
                remedy = nearest(joint, bodies.joint_names)
                found = f"<{element.tag}> names the unknown joint '{joint}'"
                findings.error(found, "a joint", remedy, element.sourceline)
            else:
                motors.append(_motor(element, get, joint, findings))
    return motors


def _motor(element: Element, get: dict[str, str], joint: str, findings: Findings) -> Motor:
    what, line = f"<{element.tag}> of joint '{joint}'", element.sourceline
    words = get.get("gear", "1").split() or [""]
    numbers = {}
    for key, text in (("gear", words[0]), ("armature", get.get("armature", "0")), ("damping", get.get("damping", "0"))):
        value = read_numbers(text, 1, f"{key} of {what}", findings, line, LARGEST_PHYSICS)
        numbers[key] = value[0] if value else 0.0
    force = force_limit(get, "force", what, findings, line)
    if element.tag == "motor":
        control = force_limit(get, "ctrl", what, findings, line)
        known = [one for one in (force, control) if one is not None]
        force = min(known, default=None)
    return Motor(joint, numbers["gear"], force, numbers["armature"], numbers["damping"])


def driven(joints: Sequence[Joint], motors: Sequence[Motor]) -> list[Joint]:
    """The joints with what their actuators weigh and brake, and with the effort that these have at most."""
    return [_driven(joint, [motor for motor in motors if motor.joint == joint.name]) for joint in joints]


def _driven(joint: Joint, motors: Sequence[Motor]) -> Joint:
    if not motors or not joint.type.single:
        return joint
    physics, limits = joint.physics, joint.limits
    efforts = [motor.effort for motor in motors]
    bounds = [
        one for one in (limits.effort, None if None in efforts else sum(filter(None, efforts))) if one is not None
    ]
    damping = physics.damping + sum(motor.gear**2 * motor.damping for motor in motors)
    turning = [motor for motor in motors if motor.rotor != 0.0 and motor.gear != 0.0]
    rotor, gear = physics.rotor, physics.gear
    if turning:
        gear = turning[0].gear if len(turning) == 1 else 1.0
        inertia = physics.rotor + sum(motor.gear**2 * motor.rotor for motor in turning)
        rotor = turning[0].rotor if len(turning) == 1 and physics.rotor == 0.0 else inertia / gear**2
    return replace(
        joint,
        physics=replace(physics, damping=damping, rotor=rotor, gear=gear),
        limits=replace(limits, effort=min(bounds, default=None)),
    )
