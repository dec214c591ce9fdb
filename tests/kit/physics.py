"""Random physics of joints and cuts, of any size, such as a checked description may have."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cutjoint.description import Bushing, CutJoint, CutType, Joint, JointPhysics, JointType, Limits, RobotDescription

Rng = np.random.Generator


def number(rng: Rng, scale: float = 1.0) -> float:
    """A positive number around a scale, over two decades."""
    return float(scale * 10.0 ** rng.uniform(-1.0, 1.0))


def some(rng: Rng, scale: float = 1.0) -> float:
    """As `number`, and 0 every third time."""
    return 0.0 if rng.integers(3) == 0 else number(rng, scale)


def free_motion(rng: Rng, ball: bool, scale: float = 1.0) -> JointPhysics:
    """Dampers, friction and perhaps a spring."""
    stiffness = some(rng, scale)
    rest = 0.0 if ball else float(rng.normal())
    speed = (None, 0.0, number(rng))[rng.integers(3)]
    friction = some(rng, scale)
    return JointPhysics(
        damping=some(rng, scale),
        friction=friction,
        friction_speed=speed if friction else None,
        stiffness=stiffness,
        rest=rest if stiffness else None,
    )


def of_joint(rng: Rng, joint: Joint, scale: float = 1.0) -> JointPhysics:
    """Everything that a joint of its type may have."""
    kind = joint.type
    if not kind.moves:
        return JointPhysics()
    if not kind.single and any(kind.lengths):
        return JointPhysics(damping=some(rng, scale))
    physics = free_motion(rng, kind is JointType.SPHERICAL, scale)
    gear = float(rng.choice([1.0, -1.0])) * number(rng, 10.0) if rng.integers(2) else 1.0
    physics = replace(physics, rotor=some(rng, scale), gear=gear)
    if joint.limits.lower is None and joint.limits.upper is None:
        return physics
    stop = some(rng, scale)
    return replace(physics, stop_stiffness=stop, stop_damping=some(rng, scale) if stop else 0.0)


def of_cut(rng: Rng, cut: CutJoint, scale: float = 1.0) -> JointPhysics:
    """Everything that the free motion of a cut may have."""
    return free_motion(rng, cut.type is CutType.SPHERICAL, scale) if cut.type.freedoms else JointPhysics()


def bushing(rng: Rng, cut: CutJoint, scale: float = 1.0) -> Bushing:
    """One that fits the type of a cut."""
    if any(not one.is_length for one in cut.type.equations):
        return Bushing(number(rng, scale), some(rng, scale), number(rng, scale), some(rng, scale))
    return Bushing(number(rng, scale), some(rng, scale))


def with_physics(rng: Rng, robot: RobotDescription, scale: float = 1.0, stops: bool = False) -> RobotDescription:
    """The robot with random physics of all its joints, which get limits for their stops to be at if `stops`."""
    near = Limits(-0.2, 0.3)
    joints = [replace(one, limits=near) if stops and one.type.limited else one for one in robot.joints]
    return replace(robot, joints=tuple(replace(one, physics=of_joint(rng, one, scale)) for one in joints))


def with_elastic_cuts(rng: Rng, robot: RobotDescription, scale: float = 1.0) -> RobotDescription:
    """The robot with random physics of all its cuts, and bushings of every other one."""
    cuts = [replace(one, physics=of_cut(rng, one, scale)) for one in robot.cuts]
    held = [
        replace(one, bushing=bushing(rng, one, scale), physics=JointPhysics()) if rng.integers(2) else one
        for one in cuts
    ]
    return replace(robot, cuts=tuple(held))
