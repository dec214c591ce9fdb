"""Random physics of joints and cuts.

with_physics        moderate numbers, dampers, friction, springs and rotors everywhere: robots that are simulated
with_sized_physics  the same of the size that gravity gives to a robot of some length and weight, at any scale
with_any_physics    any number that a checked description may have, over two decades, some of them zero
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cutjoint.description import Bushing, CutJoint, CutType, Joint, JointPhysics, JointType, Limits, RobotDescription

Rng = np.random.Generator


def changed(
    robot: RobotDescription, joint: Callable[[Joint], JointPhysics], cut: Callable[[CutJoint], JointPhysics]
) -> RobotDescription:
    """The robot with the physics that the functions say."""
    joints = tuple(replace(one, physics=joint(one)) for one in robot.joints)
    return replace(robot, joints=joints, cuts=tuple(replace(one, physics=cut(one)) for one in robot.cuts))


def softened(robot: RobotDescription, bushing: Callable[[CutJoint], Bushing | None]) -> RobotDescription:
    """The robot with bushings in place of the cuts for which the function gives one, and of their physics."""
    soft = [(one, bushing(one)) for one in robot.cuts]
    cuts = (one if made is None else replace(one, bushing=made, physics=JointPhysics()) for one, made in soft)
    return replace(robot, cuts=tuple(cuts))


# ---- moderate ------------------------------------------------------------------------------------------------------


def physics_of(kind: str, rng: Rng, *, rotor: bool = True) -> JointPhysics:
    """Random physics that a joint or cut of a type may have."""
    if kind == "fixed":
        return JointPhysics()
    dampers = JointPhysics(damping=rng.uniform(0.1, 2.0), rotor=rng.uniform(0.001, 0.01), gear=rng.uniform(1.0, 20.0))
    if not rotor:
        dampers = replace(dampers, rotor=0.0, gear=1.0)
    if kind in ("planar", "floating"):
        return JointPhysics(damping=dampers.damping)
    rest = 0.0 if kind == "spherical" else rng.normal()
    spring = replace(dampers, stiffness=rng.uniform(1.0, 30.0), rest=rest)
    return replace(spring, friction=rng.uniform(0.1, 3.0), friction_speed=rng.uniform(0.05, 0.5))


def with_physics(robot: RobotDescription, rng: Rng, bushings: float = 0.0) -> RobotDescription:
    """The robot with physics in every joint and cut, and bushings in place of a part of the cuts."""
    robot = changed(robot, lambda one: physics_of(one.type, rng), lambda one: physics_of(one.type, rng, rotor=False))

    def bushing(_: CutJoint) -> Bushing | None:
        if rng.uniform() >= bushings:
            return None
        return Bushing(rng.uniform(1e3, 1e4), rng.uniform(1.0, 10.0), rng.uniform(10.0, 100.0), rng.uniform(0.1, 1.0))

    return softened(robot, bushing)


# ---- of a size -----------------------------------------------------------------------------------------------------

SPRUNG = ("revolute", "continuous", "prismatic", "universal", "spherical")


def sized_physics(rng: Rng, kind: str, length: float, weight: float, cut: bool = False) -> JointPhysics:
    """Everything that a joint of this type may have, of the size that gravity gives to a robot of this length [m] and
    weight [N]; the stops are left out."""
    if kind == "fixed":
        return JointPhysics()
    unit = weight if kind == "prismatic" else weight * length  # of a force or moment
    place = length if kind == "prismatic" else 1.0
    rate = place * np.sqrt(9.81 / length)
    damping = 0.3 * rng.uniform() * unit / rate
    rotor = 0.0 if cut else 0.3 * rng.uniform() * unit / (rate * rate / place)
    if kind not in SPRUNG:
        # lengths and angles have one number, which must not outweigh either
        small = min(1.0, length * length)
        return JointPhysics(damping=small * damping / length)
    speed = rate * float(rng.choice([0.01, 5.0]))
    rest = None if kind == "spherical" else place * float(rng.normal())
    friction, stiffness = 0.3 * unit * rng.uniform(), 0.3 * unit / place * rng.uniform()
    return JointPhysics(damping, friction, speed, stiffness, rest, rotor, 1.0 if cut else 0.5)


def with_sized_physics(
    robot: RobotDescription, rng: Rng, length: float, weight: float, soft: tuple[str, ...] = ()
) -> RobotDescription:
    """The robot with physics in all joints and cuts, and bushings in place of the cuts that are named in `soft`."""
    robot = changed(
        robot,
        lambda one: sized_physics(rng, one.type.value, length, weight),
        lambda one: sized_physics(rng, one.type.value, length, weight, cut=True),
    )
    k, c = 30.0 * weight / length, 0.3 * weight / np.sqrt(9.81 * length)
    sizes = k, c, k * length**2, c * length**2
    return softened(robot, lambda one: Bushing(*(rng.uniform(0.3, 1.0, 4) * sizes)) if one.name in soft else None)


# ---- anything ------------------------------------------------------------------------------------------------------


def number(rng: Rng, scale: float = 1.0) -> float:
    """A positive number around a scale, over two decades."""
    return float(scale * 10.0 ** rng.uniform(-1.0, 1.0))


def some(rng: Rng, scale: float = 1.0) -> float:
    """As `number`, and 0 every third time."""
    return 0.0 if rng.integers(3) == 0 else number(rng, scale)


def free_motion(rng: Rng, ball: bool, scale: float = 1.0, sticks: bool = False) -> JointPhysics:
    """Dampers, friction and perhaps a spring; and stiction where it may stick."""
    stiffness = some(rng, scale)
    rest = 0.0 if ball else float(rng.normal())
    speed = (None, 0.0 if sticks else 1.0, number(rng))[rng.integers(3)]
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
    ball = kind is JointType.SPHERICAL
    physics = free_motion(rng, ball, scale, sticks=not ball)
    gear = float(rng.choice([1.0, -1.0])) * number(rng, 10.0) if rng.integers(2) else 1.0
    physics = replace(physics, rotor=some(rng, scale), gear=gear)
    if joint.limits.lower is None and joint.limits.upper is None:
        return physics
    stop = some(rng, scale)
    return replace(physics, stop_stiffness=stop, stop_damping=some(rng, scale) if stop else 0.0)


def of_cut(rng: Rng, cut: CutJoint, scale: float = 1.0) -> JointPhysics:
    """Everything that the free motion of a cut may have."""
    return free_motion(rng, cut.type is CutType.SPHERICAL, scale) if cut.type.freedoms else JointPhysics()


def bushing_of(rng: Rng, cut: CutJoint, scale: float = 1.0) -> Bushing:
    """One that fits the type of a cut."""
    if any(not one.is_length for one in cut.type.equations):
        return Bushing(number(rng, scale), some(rng, scale), number(rng, scale), some(rng, scale))
    return Bushing(number(rng, scale), some(rng, scale))


def with_any_physics(robot: RobotDescription, rng: Rng, scale: float = 1.0, stops: bool = False) -> RobotDescription:
    """The robot with physics of all its joints, which get limits for their stops to be at if `stops`."""
    near = Limits(-0.2, 0.3)
    joints = [replace(one, limits=near) if stops and one.type.limited else one for one in robot.joints]
    limited = replace(robot, joints=tuple(joints))
    return changed(limited, lambda one: of_joint(rng, one, scale), lambda one: one.physics)


def with_any_cuts(robot: RobotDescription, rng: Rng, scale: float = 1.0) -> RobotDescription:
    """The robot with physics of all its cuts, and bushings of every other one."""
    robot = changed(robot, lambda one: one.physics, lambda one: of_cut(rng, one, scale))
    return softened(robot, lambda one: bushing_of(rng, one, scale) if rng.integers(2) else None)
