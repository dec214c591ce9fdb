"""`cutjoint states`: a simulation as joint states of ROS 2."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cutjoint import interrupts
from cutjoint.commands import options
from cutjoint.commands.failing import complain
from cutjoint.commands.output import say
from cutjoint.commands.robot_of_run import robot_of_run


def command(
    run: Annotated[Path, typer.Argument(metavar="RESULT", help="A result that `cutjoint simulate --save` wrote.")],
    out: Annotated[
        Path,
        typer.Option("--out", "-o", metavar="PATH", help="FILE.jsonl for JSON lines, or a new folder for a rosbag2."),
    ],
    robot: Annotated[
        str | None, typer.Option(metavar="ROBOT", help="The robot, where the result does not tell.")
    ] = None,
    variant: options.Variant = None,
    lenient: options.Lenient = False,
) -> None:
    """Write the motion of all joints of a simulation, passive ones too, as messages of ROS 2.

    Joints with one coordinate are on /joint_states (sensor_msgs/msg/JointState), where those with several have their
    child is on /tf (tf2_msgs/msg/TFMessage).
    """
    from cutjoint.errors import InputError
    from cutjoint.handover import check_target, joint_states, write
    from cutjoint.simulation import load

    if run.suffix != ".npz":
        raise InputError(f"a result is a file .npz that `cutjoint simulate --save` wrote, found '{run}'")
    check_target(out)
    result = load(run)
    chain = robot_of_run(result, robot, variant, lenient)
    states = joint_states(result, chain)
    with interrupts.keeping():
        written = write(states, out)
    say(f"{written}: {len(states.time)} samples of {len(states.names)} joints")
    if states.carried:
        say(f"on /tf, having several coordinates: {', '.join(one.joint for one in states.carried)}")
    if not states.velocity.shape[1]:
        complain("warning: no velocities: those of the actuators do not tell those of all joints")
