"""`<actuator>` in MJCF: which joints are driven, how hard, and what their motors weigh and brake.

The force at a joint is `gear` times that of its actuator, which `forcerange` bounds, or where it is a constant times
the control, `ctrlrange`.  The gear is a lever of the force: it does not touch the joint's own armature.  An actuator's
own `armature` and `damping` are those of a rotor that turns `gear` times as fast as the joint.  An actuator of a fixed
tendon acts on the one joint that all of its joints move with, or else on a joint of the tendon's own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from cutjoint.description.formats.mjcf.body import Bodies
from cutjoint.description.formats.mjcf.compiled import ActuatorRow
from cutjoint.description.formats.mjcf.couplings import Followers
from cutjoint.description.formats.mjcf.joint import even, linear
from cutjoint.description.formats.mjcf.tendon import acting, as_joint, lengths_of, place_of, quoted
from cutjoint.description.model import Joint, Place
from cutjoint.description.numbers import LARGEST_PHYSICS
from cutjoint.findings import Findings, check_range


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


def actuated_joints(bodies: Bodies) -> set[str]:
    """Joints that have an actuator of their own."""
    return {bodies.joints[row.target] for row in bodies.model.actuators if row.on == "joint"}


def read_motors(bodies: Bodies, followers: Followers, findings: Findings) -> list[Motor]:
    """The actuators of joints and of fixed tendons."""
    motors: list[Motor] = []
    kinds = {joint.name: joint.type for joint in bodies.tree.joints}
    for row in bodies.model.actuators:
        element = bodies.source.element(row.line)
        tag = "general" if element is None else str(element.tag)
        place = bodies.source.place(row.line) or Place(findings.file)
        what = f"<{tag}> '{row.name}'" if row.name else f"<{tag}>"
        if row.on == "joint":
            joint = bodies.joints[row.target]
            kind = kinds[joint]
            if not kind.single:
                found = f"{what} on the {kind} joint '{joint}' is not read"
                findings.doubt(found, "actuators of joints with one coordinate", "", place)
                continue
            motors.append(_motor(row, joint, 1.0, f"<{tag}> of joint '{joint}'", findings, place))
            continue
        on_tendon = row.on == "tendon" and lengths_of(bodies.model.tendons[row.target], bodies) is not None
        if not on_tendon:
            target = (
                f"the spatial tendon {quoted(bodies.model.tendons[row.target])}"
                if row.on == "tendon"
                else f"a {row.on}"
            )
            note = findings.warn if row.on == "body" else findings.doubt  # it sticks to what it touches
            note(f"{what} on {target} is not read", "actuators of joints and fixed tendons", "", place)
            continue
        joint, rate, most = _pulled(row, bodies, followers, findings)
        motors.append(_motor(row, joint, rate, f"{what} of joint '{joint}'", findings, place, most))
    return motors


def _pulled(
    row: ActuatorRow, bodies: Bodies, followers: Followers, findings: Findings
) -> tuple[str, float, float | None]:
    """The joint that an actuator of a fixed tendon acts on, what a unit of its coordinate adds to the length, and the
    force that the tendon has at most."""
    tendon = bodies.model.tendons[row.target]
    terms, _ = followers.reduced(lengths_of(tendon, bodies) or {}, 0.0)
    kinds = {joint.name: joint.type for joint in bodies.tree.joints}
    if len(terms) == 1 and not acting(tendon) and not bodies.own:
        ((joint, rate),) = terms.items()
        if kinds[joint].single and joint not in followers.couplings:
            what = f"actuatorfrcrange of <fixed> '{tendon.name}'"
            return joint, rate, even(tendon.force, what, findings, place_of(tendon, bodies))
    return as_joint(tendon, bodies, followers, findings), 1.0, None


def _motor(
    row: ActuatorRow, joint: str, rate: float, what: str, findings: Findings, place: Place, most: float | None = None
) -> Motor:
    """A motor of a joint; `rate` is what a unit of the joint's coordinate moves what the actuator pulls, with at most
    the force `most`."""
    check_range((row.gear, row.gain, row.armature), what, findings, place, LARGEST_PHYSICS)
    force, control = even(row.force, f"forcerange of {what}", findings, place), None
    if row.control is not None:
        control = even(row.control, f"ctrlrange of {what}", findings, place)
    bounds = [force, None if control is None else abs(row.gain) * control]
    bounds += [None if most is None or row.gear == 0.0 else most / abs(row.gear)]
    known = [one for one in bounds if one is not None]
    damping = linear(row.damping, f"damping of {what}", findings, place)
    return Motor(joint, row.gear * rate, min(known, default=None), row.armature, damping)


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
