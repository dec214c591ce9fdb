"""Random joint physics for any description, and both sides of a robot that has it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from kit.blueprint import Blueprint
from kit.writing import Mounting
from oracles.maximal import Maximal
from oracles.physics import laws_of

from cutjoint.chain import ClosedChain
from cutjoint.description import load_description
from cutjoint.description.model import Bushing, RobotDescription
from cutjoint.mechanism.physics import NO_PHYSICS, JointPhysics

Rng = np.random.Generator
SPRUNG = ("revolute", "continuous", "prismatic", "universal", "spherical")


def random_physics(rng: Rng, kind: str, length: float, weight: float, cut: bool = False) -> JointPhysics:
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


def with_physics(description: RobotDescription, rng: Rng, length: float, weight: float) -> RobotDescription:
    """The same robot with physics in all joints and cuts."""
    return replace(
        description,
        joints=tuple(
            replace(one, physics=random_physics(rng, one.type.value, length, weight)) for one in description.joints
        ),
        cuts=tuple(
            replace(one, physics=random_physics(rng, one.type.value, length, weight, cut=True))
            for one in description.cuts
        ),
    )


def soft(
    description: RobotDescription, rng: Rng, cuts: tuple[str, ...], length: float, weight: float
) -> RobotDescription:
    """The same with bushings in place of some cuts."""
    k, c = 30.0 * weight / length, 0.3 * weight / np.sqrt(9.81 * length)
    numbers = {
        name: Bushing(*(rng.uniform(0.3, 1.0, 4) * (k, c, k * length**2, c * length**2)))
        for name in cuts
    }  # fmt: skip
    changed = (
        replace(one, bushing=numbers[one.name], physics=NO_PHYSICS) if one.name in numbers else one
        for one in description.cuts
    )
    return replace(description, cuts=tuple(changed))


def built_with_physics(
    plan: Blueprint,
    folder: Path,
    rng: Rng,
    mounting: Mounting | None = None,
    scale: float = 1.0,
    density: float = 1.0,
    rubber: tuple[str, ...] = (),
) -> tuple[ClosedChain, Maximal]:
    """The chain of a plan with physics everywhere, and its oracle; cuts named in `rubber` are bushings."""
    path = plan.write(folder, mounting, scale, density)
    length, weight = 0.3 * scale, 9.81 * density
    description = with_physics(load_description(path), rng, length, weight)
    description = soft(description, rng, rubber, length, weight)
    chain = ClosedChain(description)
    laws, bushings = laws_of(description)
    origin = None if mounting is None else mounting.xyz
    return chain, Maximal(path, length=chain.length, origin=origin, laws=laws, bushings=bushings)
