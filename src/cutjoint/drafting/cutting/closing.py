"""A robot without a home of its own, closed somewhere: near zero, else from random starts; and motors that move it."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.chain.findings import usual_mobility
from cutjoint.chain.rank import null_space, rank_of
from cutjoint.description.model import CutJoint, Home, RobotDescription
from cutjoint.drafting.cutting.tree import Tree
from cutjoint.errors import ClosureError, RoundingWarning

STARTS = 40
"""Random configurations from which closing is tried where it fails from the robot's own home."""

BESIDE = 8
"""Random postures beside a singular one from which closing is tried."""
ASIDE = 0.5
"""How far they are from it at most, in radians or lengths of the robot."""
NOTHING = 1e-9
"""Size of a row of the loops beside the largest below which it holds nothing."""
DECIMALS = 12
"""Of the coordinates of a home posture that is found here, [m] or [rad]."""


def with_cuts(robot: RobotDescription, cuts: Sequence[CutJoint]) -> RobotDescription:
    """A copy with these cuts."""
    return replace(robot, cuts=tuple(cuts))


def closed(robot: RobotDescription, near: ClosedChain | None = None) -> ClosedChain | None:
    """The chain of a robot, closed at its home, or near that of another chain of its tree, or somewhere.

    None where no closed posture is found.
    """
    if near is not None:
        return _built(replace(robot, homes=(home_of(near), *robot.homes[1:])))
    chain = _built(robot)
    random, start = np.random.default_rng(0), 0
    while chain is None and not robot.homes and start < STARTS:
        chain, start = _built(replace(robot, homes=(_anywhere(robot, random),))), start + 1
    return chain


def beside(chain: ClosedChain) -> Home | None:
    """A home beside that of a chain where that is singular; None where it is not, or where none is found."""
    usual, robot, random = usual_mobility(chain), chain.description, np.random.default_rng(0)
    if not 0 < usual < chain.mobility().mobility:
        return None
    start = home_of(chain)
    for _ in range(BESIDE):
        other = _built(replace(robot, actuators=(), homes=(_aside(start, robot, chain.length, random),)))
        if other is not None and other.mobility().mobility == usual:
            found = home_of(other).passive
            actuated = {name: value for name, value in found.items() if name in robot.actuators}
            passive = {name: value for name, value in found.items() if name not in actuated}
            return Home(start.name, {name: float(np.asarray(value)) for name, value in actuated.items()}, passive)
    return None


def home_of(chain: ClosedChain, name: str | None = None) -> Home:
    """The closed home of a chain as that home posture of its description, default the first one."""
    at, robot = chain.home, chain.description
    said = next((one for one in robot.homes if name in (None, one.name)), Home("default"))
    moving = [one for one in robot.joints if one.type.moves]
    passive: dict[str, float | tuple[float, ...]] = {}
    for joint in moving:
        if joint.name not in robot.actuators:
            value = np.round(np.atleast_1d(at[joint.name]), DECIMALS) + 0.0
            passive[joint.name] = float(value[0]) if joint.type.single else tuple(value.tolist())
    actuated = {name: said.actuated.get(name, round(value, DECIMALS) + 0.0) for name, value in at.actuated.items()}
    return replace(said, actuated=actuated, passive=passive)


def motors_of(chain: ClosedChain, preferred: Sequence[str]) -> tuple[str, ...]:
    """As many joints with one coordinate as the robot can move in ways, which move it: the preferred ones first, then
    those near the base."""
    tree, model = Tree(chain.description), chain.model
    ways = _ways(chain)
    joints = [one for one in chain.description.joints if one.type.single]
    joints.sort(key=lambda one: (one.name not in preferred, tree.depth(one.child)))
    follow = {one.joint for one in chain.description.couplings}
    taken: list[str] = []
    rows = np.zeros((0, ways.shape[1]))
    for joint in joints:
        more = np.vstack([rows, ways[model.idx_vs[model.getJointId(joint.name)]]])
        if joint.name not in follow and rank_of(more) > len(rows):
            taken.append(joint.name)
            rows = more
    order = [one.name for one in chain.description.joints]
    return tuple(sorted(taken, key=order.index))


def _ways(chain: ClosedChain) -> Array:
    """Orthonormal basis of the motions that the loops allow at home, shape (nv, m), slides in lengths of the robot."""
    matrix, model = np.array(chain.constraint_jacobian(chain.home)), chain.model
    joints = [one for one in chain.description.joints if one.type.single and one.type.slides]
    matrix[:, [model.idx_vs[model.getJointId(one.name)] for one in joints]] *= chain.length
    sizes = np.linalg.norm(matrix, axis=1)
    rows = sizes > NOTHING * sizes.max(initial=0.0)
    return null_space(matrix[rows] / sizes[rows, None])


def _built(robot: RobotDescription) -> ClosedChain | None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RoundingWarning)
            return ClosedChain(robot)
    except ClosureError:
        return None


def _aside(home: Home, robot: RobotDescription, length: float, random: np.random.Generator) -> Home:
    """A home moved at random, within the limits of the joints."""
    values: dict[str, float | tuple[float, ...]] = {**home.actuated, **home.passive}
    for joint in robot.joints:
        value = values.get(joint.name)
        if joint.type.single and isinstance(value, float):
            moved = value + ASIDE * random.uniform(-1.0, 1.0) * (length if joint.type.slides else 1.0)
            low, high = joint.limits.lower, joint.limits.upper
            moved = moved if low is None else max(moved, low)
            values[joint.name] = float(moved if high is None else min(moved, high))
    return Home(home.name, {}, values)


def _anywhere(robot: RobotDescription, random: np.random.Generator) -> Home:
    """A random start within the limits of the joints."""
    passive: dict[str, float | tuple[float, ...]] = {}
    for joint in robot.joints:
        if joint.type.single:
            lower, upper = joint.limits.ends
            low = max(lower, -2.0)
            passive[joint.name] = float(random.uniform(low, max(low, min(upper, 2.0))))
    return Home("default", {}, passive)
