"""Whether hardware goes with a robot and a run."""

from __future__ import annotations

from collections.abc import Sequence

from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError
from cutjoint.mechanism import Mechanism
from cutjoint.simulation.hardware.values import Hardware


def check_span(hardware: Hardware, span: float) -> None:
    """Raises InputError where a delay is as long as the run of `span` [s] or longer."""
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
    robot = getattr(mechanism, "plain", mechanism)  # of a compiled robot, the chain it was made from
    if not isinstance(robot, ClosedChain):
        return
    physics = {one: robot.description.joint(one).physics for one in robot.description.actuators}
    if twice := [name for name, one in physics.items() if one.armature > 0.0]:
        raise InputError(
            f"joint '{twice[0]}' has a rotor already (armature {physics[twice[0]].armature:g}), and the backlash "
            "brings another one; take the rotor out of the robot's description"
        )
