"""A robot in natural units: a length and a mass of its own, and the time in which it falls.

MuJoCo holds numbers against fixed ones (it lifts masses below 1e-12 kg and moments below 1e-12 kg m2, and pulls open
loops together within hundredths of a second), so a robot of a tenth of a millimetre or of a microgram would be another
robot to it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.cuts import Freedom
from cutjoint.description.model import (
    Bushing,
    Coupling,
    CutJoint,
    Frame,
    Inertial,
    Joint,
    JointPhysics,
    Limits,
    RobotDescription,
)


@dataclass(frozen=True)
class NaturalUnits:
    """Natural units: length [m], mass [kg], time [s]."""

    length: float
    mass: float
    time: float

    @property
    def energy(self) -> float:
        """And of torque [J]."""
        return self.mass * (self.length / self.time) ** 2

    def physics(self, of: JointPhysics, unit: float) -> JointPhysics:
        """In natural units, of a joint whose coordinate is in units of `unit` [m], or of 1 [rad]."""
        force, speed = self.energy / unit, unit / self.time
        return JointPhysics(
            damping=of.damping * speed / force,
            friction=of.friction / force,
            friction_speed=of.speed / speed,
            stiffness=of.stiffness * unit / force,
            rest=None if of.rest is None else of.rest / unit,
            rotor=of.rotor / (self.mass * self.length**2),
            gear=of.gear * unit if of.rotor else of.gear,
            stop_stiffness=of.stop_stiffness * unit / force,
            stop_damping=of.stop_damping * speed / force,
        )

    def bushing(self, of: Bushing) -> Bushing:
        """In natural units."""
        return Bushing(
            of.stiffness * self.length**2 / self.energy,
            of.damping * self.length**2 / (self.energy * self.time),
            of.turning_stiffness / self.energy,
            of.turning_damping / (self.energy * self.time),
        )


def units_of(robot: RobotDescription, length: float) -> NaturalUnits:
    """Those of a robot of characteristic `length` [m]: its heaviest link, and the time of a fall through `length`.

    A kilogram where no link has mass, a second where there is no gravity.
    """
    heaviest = max((one.inertial.mass for one in robot.links if one.inertial is not None), default=0.0)
    gravity = float(np.linalg.norm(robot.gravity))
    return NaturalUnits(length, heaviest or 1.0, float(np.sqrt(length / gravity)) if gravity > 0.0 else 1.0)


def natural(robot: RobotDescription, scale: NaturalUnits) -> RobotDescription:
    """The tree, cuts and couplings of `robot` in natural units: no shapes, limits or homes.

    A joint that slides and turns has one damping and one rotor for both; they are those of its turns.
    """
    length, mass = scale.length, scale.mass
    units = {joint.name: length if joint.type.slides else 1.0 for joint in robot.joints}

    def frame(one: Frame) -> Frame:
        return replace(one, placement=_moved(one.placement, length))

    def inertial(one: Inertial | None) -> Inertial | None:
        if one is None:
            return None
        return Inertial(one.mass / mass, one.com / length, one.inertia / (mass * length * length))

    def joint(one: Joint) -> Joint:
        return replace(
            one,
            placement=_moved(one.placement, length),
            limits=Limits(),
            physics=scale.physics(one.physics, units[one.name]),
        )

    def cut(one: CutJoint) -> CutJoint:
        physics = scale.physics(one.physics, length if Freedom.SLIDE in one.type.freedoms else 1.0)
        bushing = None if one.bushing is None else scale.bushing(one.bushing)
        return replace(
            one, a=frame(one.a), b=frame(one.b), physics=physics, bushing=bushing, length=one.length / length
        )

    def coupling(one: Coupling) -> Coupling:
        unit = units[one.joint]
        drives = tuple(replace(own, curve=own.curve.scaled(units[own.driver], unit)) for own in one.drives)
        return replace(one, drives=drives, offset=one.offset / unit)

    return replace(
        robot,
        links=tuple(replace(one, inertial=inertial(one.inertial), visuals=(), collisions=()) for one in robot.links),
        joints=tuple(map(joint, robot.joints)),
        cuts=tuple(map(cut, robot.cuts)),
        couplings=tuple(map(coupling, robot.couplings)),
        tool=None if robot.tool is None else frame(robot.tool),
        gravity=robot.gravity * scale.time**2 / length,
        homes=(),
        variants=(),
    )


def _moved(placement: Array, length: float) -> Array:
    moved = np.array(placement)
    moved[:3, 3] /= length
    return moved
