"""Descriptions whose joints and cuts have dampers, friction, springs, rotors, and bushings in place of some cuts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cutjoint.description import Bushing, JointPhysics, RobotDescription

Rng = np.random.Generator


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
    """A copy with random physics in every joint and cut, and bushings in place of a part of the cuts."""
    joints = tuple(replace(one, physics=physics_of(one.type, rng)) for one in robot.joints)
    cuts = []
    for cut in robot.cuts:
        if rng.uniform() < bushings:
            stiff = Bushing(
                rng.uniform(1e3, 1e4), rng.uniform(1.0, 10.0), rng.uniform(10.0, 100.0), rng.uniform(0.1, 1.0)
            )
            cuts.append(replace(cut, bushing=stiff))
        else:
            cuts.append(replace(cut, physics=physics_of(cut.type, rng, rotor=False)))
    return replace(robot, joints=joints, cuts=tuple(cuts))
