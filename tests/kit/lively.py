"""Robots whose joints, cuts and links do something by themselves, in numbers of the robot's own size: with E = m g L
of the whole robot, springs of about E a radian or a length, friction of a part of E, dampers of a part of E a rate
sqrt(g/L), rotors of a part of m L^2, stops near the posture at home, half of them met, and bushings beside the
loops."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
from kit.blueprint import random_rotation
from kit.held_up import held_up

from cutjoint.chain import ClosedChain
from cutjoint.description.cuts import CutType
from cutjoint.description.model import CutJoint, Frame, Joint, JointType, Limits, RobotDescription
from cutjoint.description.transforms import placement
from cutjoint.errors import CutjointError
from cutjoint.mechanism import Posture
from cutjoint.mechanism.physics import Bushing, JointPhysics

Array = np.ndarray
BUSHINGS = tuple(CutType)


@dataclass(frozen=True)
class Strength:
    """Energy [J], length [m], mass [kg] and rate [1/s] of a robot."""

    energy: float
    length: float
    mass: float
    rate: float

    @staticmethod
    def of(chain: ClosedChain) -> Strength:
        mass = sum(link.inertial.mass for link in chain.description.links if link.inertial is not None)
        gravity = float(np.linalg.norm(chain.description.gravity)) or 1.0
        length = float(chain.length)
        return Strength(mass * gravity * length, length, mass, float(np.sqrt(gravity / length)))

    def physics(self, rng: np.random.Generator, unit: float, rotor: bool = True, ball: bool = False) -> JointPhysics:
        """Of a coordinate whose unit is `unit`: 1 rad or the robot's length."""
        gear, energy = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 6.0)), self.energy
        return JointPhysics(
            damping=0.3 * rng.uniform() * energy / self.rate / unit**2,
            friction=0.3 * rng.uniform() * energy / unit,
            friction_speed=rng.uniform(0.2, 1.5) * self.rate * unit,
            stiffness=rng.uniform() * energy / unit**2,
            rest=0.0 if ball else rng.uniform(-1.0, 1.0) * unit,
            rotor=0.1 * rng.uniform() * self.mass * (self.length / unit) ** 2 / gear**2 if rotor else 0.0,
            gear=gear if rotor else 1.0,
        )

    def bushing(self, rng: np.random.Generator) -> Bushing:
        energy, rate, length = self.energy, self.rate, self.length
        stiffness, damping, turning, slowing = rng.uniform(0.1, 1.0, 4)
        return Bushing(
            stiffness * energy / length**2,
            damping * energy / rate / length**2,
            turning * energy,
            slowing * energy / rate,
        )


def lively(description: RobotDescription, rng: np.random.Generator, bushings: int = 2) -> RobotDescription:
    """The same robot with physics in all joints and cuts, weights in part compensated, and some bushings between random
    links."""
    chain = ClosedChain(description)
    strength = Strength.of(chain)
    joints = tuple(_joint(one, strength, rng, chain) for one in description.joints)
    cuts = tuple(
        replace(one, physics=_of_cut(one.type, strength, rng)) if one.bushing is None else one
        for one in description.cuts
    )
    found = replace(description, joints=joints, cuts=cuts)
    for index in range(bushings if len(description.links) > 1 else 0):
        kind = BUSHINGS[int(rng.integers(len(BUSHINGS)))]
        extra = bushed(chain, f"soft{index}", kind, strength, rng)
        found = replace(found, cuts=(*found.cuts, extra))
    return held_up(found, rng.spawn(1)[0])


def _joint(one: Joint, strength: Strength, rng: np.random.Generator, chain: ClosedChain) -> Joint:
    if one.type is JointType.FIXED:
        return one
    unit = strength.length if one.type is JointType.PRISMATIC else 1.0
    if one.type in (JointType.PLANAR, JointType.FLOATING):
        rate = min(strength.length, 1.0) ** 2
        slow = 0.1 * rng.uniform() * strength.energy / strength.rate * rate / strength.length**2
        return replace(one, physics=JointPhysics(damping=slow))
    physics = strength.physics(rng, unit, ball=one.type is JointType.SPHERICAL)
    if not (one.type.single and one.type.limited):
        return replace(one, physics=physics)
    stiff = 3.0 * rng.uniform() * strength.energy / unit**2
    at = float(chain.home[one.name]) + unit * rng.choice([-0.3, 0.2])
    limits = Limits(at - 0.2 * unit, at + 0.2 * unit, one.limits.velocity, one.limits.effort)
    return replace(
        one,
        limits=limits,
        physics=replace(physics, stop_stiffness=stiff, stop_damping=0.3 * stiff / strength.rate),
    )


def _of_cut(kind: CutType, strength: Strength, rng: np.random.Generator) -> JointPhysics:
    unit = strength.length if kind is CutType.PRISMATIC else 1.0
    made = strength.physics(rng, unit, rotor=False, ball=kind is CutType.SPHERICAL)
    return made if kind.freedoms else JointPhysics()


def bushed(
    chain: ClosedChain, name: str, kind: CutType, strength: Strength, rng: np.random.Generator, apart: float = 0.2
) -> CutJoint:
    """A bushing between two links, whose frames stand nearly together at home."""
    links = [link.name for link in chain.description.links]
    model = chain.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, chain.home.q_full)
    first, second = rng.choice(links, 2, replace=False)
    one, two = (data.oMf[model.getFrameId(str(link), pin.FrameType.BODY)].homogeneous for link in (first, second))
    in_first, off = np.eye(4), placement(apart * strength.length * rng.normal(size=3), apart * rng.normal(size=3))
    in_first[:3, :3], in_first[:3, 3] = random_rotation(rng), 0.3 * strength.length * rng.normal(size=3)
    in_second = np.linalg.inv(two) @ one @ in_first @ off
    ends, length = (Frame(str(first), in_first), Frame(str(second), in_second)), 0.0
    if kind.has_length:
        length = float(np.linalg.norm(off[:3, 3]) * rng.uniform(0.5, 1.5))
    return CutJoint(name, kind, *ends, bushing=strength.bushing(rng), length=length)


State = tuple[Posture, Array, Array, Array]


def states(chain: ClosedChain, rng: np.random.Generator, count: int, reach: float = 0.05) -> list[State]:
    """Postures around home, with velocity, acceleration and effort."""
    size, found = Strength.of(chain), []
    unit = np.array([size.length if one.kind == "translation" else 1.0 for one in chain.actuators])
    while len(found) < count:
        try:
            at = chain.close(chain.home.q + reach * unit * rng.uniform(-1, 1, chain.n), limits="ignore")
        except CutjointError:
            reach *= 0.8
            assert reach > 1e-4
            continue
        v, a = size.rate * unit * rng.normal(size=chain.n), size.rate**2 * unit * rng.normal(size=chain.n)
        found.append((at, v, a, size.energy / unit * rng.normal(size=chain.n)))
    return found


def without_stops(robot: RobotDescription) -> RobotDescription:
    """The same robot without limits, for runs."""
    free = [
        replace(one, limits=Limits(), physics=replace(one.physics, stop_stiffness=0.0, stop_damping=0.0))
        for one in robot.joints
    ]
    return replace(robot, joints=tuple(free))
