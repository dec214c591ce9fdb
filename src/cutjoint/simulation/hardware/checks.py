"""Whether hardware goes with a robot and a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError
from cutjoint.mechanism import Mechanism
from cutjoint.mechanism.physics import JointPhysics
from cutjoint.simulation.hardware.values import Hardware

MOST_SAMPLES = 1e9
"""Samples in a run: more are a slip in a unit, as they would take days."""


@runtime_checkable
class Motored(Protocol):
    """A robot that is no chain, and knows what its motors do by themselves: none or one an actuator."""

    motors: Sequence[JointPhysics]


def check_span(hardware: Hardware, span: float) -> None:
    """Raises InputError where a delay is as long as the run of `span` [s] or longer, or the clock's samples in it are
    without number."""
    if span * hardware.clock.rate > MOST_SAMPLES:
        raise InputError(
            f"a rate of {hardware.clock.rate:g} Hz is {span * hardware.clock.rate:.2g} samples in a run of {span:g} s; "
            f"up to {MOST_SAMPLES:g} can be run"
        )
    for name, delay in (("encoder", hardware.encoder.delay), ("drive", hardware.drive.delay)):
        if delay >= span:
            raise InputError(
                f"the delay of the {name} of {delay:g} s is not shorter than the run of {span:g} s; run longer"
            )


def check_robot(hardware: Hardware, mechanism: Mechanism, locked: Sequence[str]) -> None:
    """Raises InputError where play in a gear does not go with the robot: its rotor would be there twice, or a brake
    would hold the joint behind it."""
    if hardware.drive.backlash is None:
        return
    if locked:
        raise InputError(
            f"brakes on {', '.join(locked)} hold joints, and with backlash the motors are free of them; leave out one "
            "of the two"
        )
    robot = getattr(mechanism, "plain", mechanism)  # of a compiled robot, the model it was made from
    names = [one.name for one in robot.actuators]
    if isinstance(robot, ClosedChain):
        physics = {one: robot.description.joint(one).physics for one in names}
    elif isinstance(robot, Motored):
        physics = dict(zip(names, robot.motors, strict=False))
    else:
        return
    if twice := [name for name, one in physics.items() if one.armature > 0.0]:
        raise InputError(
            f"actuator '{twice[0]}' has a rotor already (armature {physics[twice[0]].armature:g}), and the backlash "
            "brings another one; take the rotor out of the robot"
        )
