"""The motion of all joints over a run, as robot programs exchange it.

A joint with one coordinate is a number, whether it has a motor or not.  One with several (spherical, universal, planar,
floating) has no place among numbers: where its child is in its parent is told instead.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array, Frozen
from cutjoint.chain import ClosedChain
from cutjoint.description.model import Joint
from cutjoint.errors import ActuationError, InputError
from cutjoint.mechanism import Mechanism
from cutjoint.mechanism.rotations import quaternion_of
from cutjoint.reprs import line
from cutjoint.simulation import Result
from cutjoint.simulation.reactions import posture_of, velocity_of


@dataclass(frozen=True, eq=False)
class CarriedChild(Frozen):
    """Where the child of a joint with several coordinates is in its parent, over m samples.

    Attributes:
        joint, parent, child: names.
        position: shape (m, 3) [m].
        orientation: quaternions x, y, z, w, shape (m, 4).
    """

    joint: str
    parent: str
    child: str
    position: Array
    orientation: Array

    __repr__ = line("joint", "parent", "child", "position", position="m")


@dataclass(frozen=True, eq=False)
class JointStates(Frozen):
    """All joints that move, at m samples of a run.

    Attributes:
        time: shape (m,) [s].
        names: of the k joints with one coordinate, in the order of the tree.
        position: shape (m, k), [m] or [rad].
        velocity: shape (m, k), [m/s] or [rad/s]; (m, 0) where the actuators' do not tell those of all joints.
        effort: of the motors, shape (m, k), [N] or [N m]; 0 of passive joints.
        carried: the joints with several coordinates.
    """

    time: Array
    names: tuple[str, ...]
    position: Array
    velocity: Array
    effort: Array
    carried: tuple[CarriedChild, ...] = ()

    __repr__ = line("names", "time", "carried", time="s")


def joint_states(result: Result, robot: Mechanism) -> JointStates:
    """The motion of all joints of a run.

    Args:
        result: of a closed chain.
        robot: the chain that moved, or the compiled one.

    Raises:
        InputError: the run is not one of this robot, or the robot no closed chain.
        ClosureError: the loops of the result are open, as of a run that was not put back onto them.
    """
    chain = getattr(robot, "plain", robot)
    if not isinstance(chain, ClosedChain) or not isinstance(result, Result):
        raise InputError(f"joint states are those of a Result and its closed chain; found {result!r} and {robot!r}")
    moving = [joint for joint in chain.description.joints if joint.type.moves]
    order = {name: index for index, name in enumerate(chain.model.names)}
    moving.sort(key=lambda joint: order[joint.name])
    single = [order[joint.name] for joint in moving if joint.type.single]
    q_index = [int(chain.model.idx_qs[index]) for index in single]
    v_index = [int(chain.model.idx_vs[index]) for index in single]
    postures = [posture_of(result, chain, i) for i in range(len(result))]
    try:
        fast = [velocity_of(chain, at, v)[v_index] for at, v in zip(postures, result.v, strict=True)]
    except ActuationError:
        fast = [np.zeros(0)] * len(result)
    several = [joint for joint in moving if not joint.type.single]
    placed = [chain.link_placements(at) for at in postures] if several else []
    return JointStates(
        result.time,
        tuple(chain.model.names[index] for index in single),
        result.q_full[:, q_index],
        np.array(fast),
        np.array([chain.full_effort(effort)[v_index] for effort in result.effort]),
        tuple(_carried(joint, placed) for joint in several),
    )


def _carried(joint: Joint, placed: list[dict[str, Array]]) -> CarriedChild:
    held = np.array([np.linalg.solve(links[joint.parent], links[joint.child]) for links in placed])
    turned = np.array([quaternion_of(one[:3, :3]) for one in held])
    return CarriedChild(joint.name, joint.parent, joint.child, held[:, :3, 3], turned)
