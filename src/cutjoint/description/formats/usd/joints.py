"""The joints of a USD stage: their types, the two frames that they join, limits, drives, and what acts in them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.description.formats.usd.bodies import BodyTable, unique_names
from cutjoint.description.formats.usd.facts import Facts, Prim
from cutjoint.description.model import Joint, JointPhysics, JointType, Limits, Place
from cutjoint.findings import Findings, listing, nearest

TYPES = {
    "PhysicsRevoluteJoint": JointType.REVOLUTE,
    "PhysicsPrismaticJoint": JointType.PRISMATIC,
    "PhysicsSphericalJoint": JointType.SPHERICAL,
    "PhysicsFixedJoint": JointType.FIXED,
}
DISTANCE = "PhysicsDistanceJoint"
FREE = "PhysicsJoint"
LIMIT, DRIVE, MIMIC = "PhysicsLimitAPI", "PhysicsDriveAPI", "PhysxMimicJointAPI"
DIRECTIONS = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ")
ACTUATOR = "Actuator"
"""What the types of actuators of others end with (NewtonActuator, MjcActuator); they name their joint."""
DEGREE = math.pi / 180.0
UNLIMITED = 1e30
"""Single precision has no larger number than 3.4e38, which is often written for none."""
UNLIMITED_SPEED = 1e6
"""PhysX's own default for the largest speed of a joint."""


@dataclass(frozen=True, eq=False)
class Edge:
    """A joint between two bodies.

    Attributes:
        joint: its type, axis in its own frames, limits and physics; parent and child are the links of body 0 and 1.
        a, b: its frames (4, 4) on the links of body 0 and body 1.
        prim: where it stands in the file.
        apart: whether it stays out of the articulation.
        driven: whether a drive acts on it.
        length: of a distance joint [m], whose type does not count; None for others.
        wanted: whether it is wanted in the tree: because it is driven, coupled or has a rotor.
    """

    joint: Joint
    a: Array
    b: Array
    prim: Prim
    apart: bool = False
    driven: bool = False
    length: float | None = None
    wanted: bool = False


def is_joint(prim: Prim) -> bool:
    """Whether a prim is a joint of UsdPhysics."""
    return prim.type in TYPES or prim.type in (DISTANCE, FREE)


def read_joints(facts: Facts, bodies: BodyTable, findings: Findings) -> list[Edge]:
    """All joints that hold something."""
    prims = [prim for prim in facts.prims if is_joint(prim)]
    names = unique_names([prim.path for prim in prims])
    leaders = {target for prim in prims for name in _references(prim) for target in prim.targets.get(name, ())}
    acted = {path for prim in facts.prims if prim.type.endswith(ACTUATOR) for path in targets_of(prim)}
    edges = []
    for prim in prims:
        edge = _edge(prim, names[prim.path], prim.path in leaders, facts, bodies, findings)
        if edge is not None and prim.path in acted and edge.joint.type.single:
            edge = replace(edge, driven=True, wanted=True)
        if edge is not None:
            edges.append(edge)
    return edges


def targets_of(prim: Prim) -> set[str]:
    """The paths that the relationships of a prim name."""
    return {path for paths in prim.targets.values() for path in paths}


def _references(prim: Prim) -> list[str]:
    return [f"physxMimicJoint:{one}:referenceJoint" for one in prim.instances(MIMIC)]


def _edge(prim: Prim, name: str, leads: bool, facts: Facts, bodies: BodyTable, findings: Findings) -> Edge | None:
    if not prim.flag("physics:jointEnabled", True):
        findings.warn(f"joint <{prim.path}> is switched off: it holds nothing", "physics:jointEnabled = true")
        return None
    for what in ("breakForce", "breakTorque"):
        if prim.number(f"physics:{what}", math.inf) < UNLIMITED:
            findings.warn(f"physics:{what} of joint <{prim.path}> is not used: it never breaks", "inf")
    ends = [_end(prim, number, facts, bodies, findings) for number in (0, 1)]
    if ends[0] is None or ends[1] is None:
        return None
    (parent, a), (child, b) = ends[0], ends[1]
    if parent == child:
        found = f"joint <{prim.path}> joins '{parent}' to itself"
        if parent == bodies.by_path[""].link.name:
            findings.error(found, "physics:body0 or physics:body1 that names a rigid body that moves")
        else:
            findings.error(found, "two bodies")
        return None
    kind, axis, length = _kind(prim, facts, findings)
    if kind is None:
        return None
    limits = _limits(prim, kind, facts, findings)
    if kind is JointType.REVOLUTE and limits.lower is None and limits.upper is None:
        kind = JointType.CONTINUOUS
    effort, driven = _drive(prim, kind, facts, findings)
    physics, speed = _physics(prim, kind, facts, findings)
    limits = Limits(limits.lower, limits.upper, speed, effort)
    joint = Joint(name, kind, parent, child, axis=readonly(axis), limits=limits, physics=physics,
                  place=Place(findings.file))  # fmt: skip
    apart = prim.flag("physics:excludeFromArticulation", False)
    wanted = driven or leads or prim.has(MIMIC) or physics.rotor != 0.0
    return Edge(joint, a, b, prim, apart, driven, length, wanted)


def _end(prim: Prim, number: int, facts: Facts, bodies: BodyTable, findings: Findings) -> tuple[str, Array] | None:
    """The link at one end of a joint, and the joint's frame on it."""
    name = f"physics:body{number}"
    targets = prim.targets.get(name, ())
    if len(targets) > 1:
        findings.error(f"{name} of joint <{prim.path}> names {listing(targets)}", "one body")
        return None
    target = targets[0] if targets else ""
    position = prim.vector(f"physics:localPos{number}", (0.0,) * 3)
    turn = prim.vector(f"physics:localRot{number}", (1.0, 0.0, 0.0, 0.0))
    if len(position) != 3 or len(turn) != 4 or not np.isfinite([*position, *turn]).all() or not any(turn):
        found = f"physics:localPos{number}, physics:localRot{number} of joint <{prim.path}> are {position}, {turn}"
        findings.error(found, "three numbers, and four of a turn")
        return None
    end = bodies.frame(target, position, turn)
    if end is None:
        paths = [one.path for one in facts.prims]
        what = "is not scaled along its own axes" if target in paths else "does not exist"
        findings.error(f"{name} of joint <{prim.path}> is <{target}>, which {what}", "a prim with a place",
                       nearest(target, paths))  # fmt: skip
        return None
    return end[0].link.name, end[1]


def _kind(prim: Prim, facts: Facts, findings: Findings) -> tuple[JointType | None, Array, float | None]:
    """Type, axis in the joint's frame, and the length of a distance joint."""
    letter = prim.word("physics:axis", "X")
    axis = np.eye(3)["XYZ".index(letter)] if letter in ("X", "Y", "Z") else np.eye(3)[0]
    if letter not in ("X", "Y", "Z"):
        findings.error(f"physics:axis of joint <{prim.path}> is '{letter}'", "X, Y or Z")
    limited = [one for one in prim.instances(LIMIT) if _range(prim, one) != (None, None)]
    if prim.type != FREE and limited:
        found = f"{listing(f'{LIMIT}:{one}' for one in limited)} of the {prim.type} <{prim.path}>"
        findings.error(found, "its own limits", "make it a PhysicsJoint, which has limits in every direction")
    if prim.type == DISTANCE:
        return JointType.FLOATING, axis, _distance(prim, facts, findings)
    if prim.type != FREE:
        return TYPES[prim.type], axis, None
    return *_free(prim, findings), None


def _distance(prim: Prim, facts: Facts, findings: Findings) -> float:
    least, most = prim.number("physics:minDistance", -1.0), prim.number("physics:maxDistance", -1.0)
    if least != most or most <= 0.0 or not math.isfinite(most):
        found = f"distance joint <{prim.path}> from {least:g} to {most:g}"
        mend = "remove it where it never is at an end of its range"
        findings.error(found, "physics:minDistance = physics:maxDistance > 0, which is a rod", mend)
        return 1.0
    return most * facts.length


def _free(prim: Prim, findings: Findings) -> tuple[JointType | None, Array]:
    """What a PhysicsJoint, free where no limit locks it, amounts to."""
    wrong = [one for one in prim.instances(LIMIT) if one not in DIRECTIONS]
    if [one for one in wrong if _range(prim, one) != (None, None)]:
        findings.error(f"{listing(wrong)} limited in joint <{prim.path}>", listing(DIRECTIONS))
        return None, np.eye(3)[0]
    spans = {one: _range(prim, one) for one in DIRECTIONS}
    locked = [one for one, (low, high) in spans.items() if low is not None and high is not None
              and (low > high or low == high == 0.0)]  # fmt: skip
    free = [one for one in DIRECTIONS if one not in locked]
    turns, slides = [one for one in free if one[0] == "r"], [one for one in free if one[0] == "t"]
    bounded = [one for one in free if spans[one] != (None, None)]
    if len(free) == len(DIRECTIONS) and not bounded:
        findings.warn(f"joint <{prim.path}> holds nothing", "limits that lock some of its directions")
        return None, np.eye(3)[0]
    axis = np.eye(3)["XYZ".index(free[0][-1])] if free else np.eye(3)[0]
    kind = None
    if not free:
        kind = JointType.FIXED
    elif len(free) == 1:
        kind = JointType.REVOLUTE if turns else JointType.PRISMATIC
    elif len(turns) == 3 and not slides:
        kind = JointType.SPHERICAL
    if kind is None or (bounded and len(free) > 1):
        found = f"joint <{prim.path}> that is free along or about {listing(free)}"
        found += f", within bounds of {listing(bounded)}" if bounded else ""
        expected = "one direction, all three turns, or none, and bounds where there is one direction only"
        findings.error(found, expected)
        return None, axis
    return kind, axis


def _range(prim: Prim, direction: str) -> tuple[float | None, float | None]:
    """The limits of a direction, None where there are none."""
    if direction not in prim.instances(LIMIT):
        return None, None
    low, high = (prim.number(f"limit:{direction}:physics:{end}", out) for end, out in (("low", -math.inf),
                                                                                       ("high", math.inf)))  # fmt: skip
    return (low if abs(low) < UNLIMITED else None), (high if abs(high) < UNLIMITED else None)


def _limits(prim: Prim, kind: JointType, facts: Facts, findings: Findings) -> Limits:
    """Lower and upper limit in SI units."""
    if kind is JointType.SPHERICAL and prim.type != FREE:
        cones = [prim.number(f"physics:coneAngle{number}Limit", -1.0) for number in (0, 1)]
        if any(0.0 <= cone < UNLIMITED for cone in cones):
            found = f"the cone of {cones[0]:g} and {cones[1]:g} degrees of joint <{prim.path}> is not used"
            findings.warn(found, "a ball without limits")
        return Limits()
    if not kind.single:
        return Limits()
    unit = DEGREE if kind.turns else facts.length
    if prim.type == FREE:
        low, high = _range(prim, next(one for one in DIRECTIONS if _is_free(prim, one)))
    else:
        low = _finite(prim.number("physics:lowerLimit", -math.inf))
        high = _finite(prim.number("physics:upperLimit", math.inf))
    return Limits(None if low is None else low * unit, None if high is None else high * unit)


def _is_free(prim: Prim, direction: str) -> bool:
    low, high = _range(prim, direction)
    return low is None or high is None or not (low > high or low == high == 0.0)


def _finite(value: float) -> float | None:
    return None if math.isinf(value) or abs(value) >= UNLIMITED else value


def _drive(prim: Prim, kind: JointType, facts: Facts, findings: Findings) -> tuple[float | None, bool]:
    """The largest effort of a joint's drive in SI units, and whether it acts at all."""
    fitting = {"angular", "rotX", "rotY", "rotZ"} if kind.turns else {"linear", "transX", "transY", "transZ"}
    efforts = []
    for instance in prim.instances(DRIVE):
        head = f"drive:{instance}:physics"
        most = prim.number(f"{head}:maxForce", math.inf)
        gains = prim.number(f"{head}:stiffness") != 0.0 or prim.number(f"{head}:damping") != 0.0
        if most == 0.0 or (prim.has(MIMIC) and not gains):
            continue
        if not kind.single or instance not in fitting:
            found = f"{DRIVE}:{instance} of the {kind.value} joint <{prim.path}> is not used"
            findings.error(
                found, f"a drive along the motion of a joint with one coordinate: {listing(sorted(fitting))}"
            )
            continue
        if gains:
            mend = "give them to a control law"
            found = f"stiffness and damping of the drive of joint <{prim.path}> are not used: they are a controller's"
            findings.warn(found, "an actuator", mend)
        efforts.append(_finite(most))
    unit = facts.mass * facts.length * (facts.length if kind.turns else 1.0)
    return (efforts[0] * unit if efforts and efforts[0] is not None else None), bool(efforts)


def _physics(prim: Prim, kind: JointType, facts: Facts, findings: Findings) -> tuple[JointPhysics, float | None]:
    """What acts in a joint by the schemas of PhysX, and its largest speed."""
    if not kind.single:
        return JointPhysics(), None
    turns, length = kind.turns, facts.length
    force = facts.mass * length * (length if turns else 1.0)
    values = {"armature": prim.number("physxJoint:armature"), "maxJointVelocity": prim.number(
        "physxJoint:maxJointVelocity", UNLIMITED_SPEED)}  # fmt: skip
    if prim.number("physxJoint:jointFriction") != 0.0:
        found = f"physxJoint:jointFriction of joint <{prim.path}> is not used: it is of the load that the joint bears"
        findings.warn(found, "physxJointAxis:...:dynamicFrictionEffort", "which is a force or torque")
    for instance in prim.instances("PhysxJointAxisAPI"):
        head = f"physxJointAxis:{instance}:"
        values |= {name.removeprefix(head): prim.number(name) for name in prim.values if name.startswith(head)}
    dynamic, static = values.get("dynamicFrictionEffort", 0.0), values.get("staticFrictionEffort", 0.0)
    if static != dynamic and static != 0.0:
        found = (
            f"staticFrictionEffort {static:g} of joint <{prim.path}> is not used beside {dynamic:g} that it slides with"
        )
        findings.warn(found, "the same as dynamicFrictionEffort")
    viscous = values.get("viscousFrictionCoefficient", 0.0) * force
    physics = JointPhysics(
        damping=viscous / DEGREE if turns else viscous / length,
        friction=dynamic * force,
        rotor=values["armature"] * facts.mass * (length * length if turns else 1.0),
    )
    most = values["maxJointVelocity"]
    return physics, None if most >= UNLIMITED_SPEED else most * (DEGREE if turns else length)
