"""What is true of a robot at nearly every posture, so that single postures can be called singular.

Rank, the motions that stay with all actuators locked, those of them that are idle and the directions of the tool are
properties of a robot, but a posture may show fewer or more: a flat parallelogram, equal plates.  So they are taken from
home and from a few closed postures around it (always the same ones): a rank is the largest found, a freedom the
smallest.

Idle are motions with all actuators locked that do not move the tool, such as a rod between two balls that spins about
itself.  A robot without a tool has idle motions where bodies that at least two connections hold turn together about one
axis while everything else stands still.

With part of a robot held, the rest falls into parts that move independently: its limbs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.drivers import Driver
from cutjoint.chain.closing.equations import System
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.rank import Split, null_space, rank_of

SHIFT = 0.1
"""How far around home is looked, in radians or characteristic lengths."""
AROUND = 3
"""How many postures around home are looked at."""
TIED = 1e-7
"""Velocities are tied together by entries larger than this of dimensionless matrices."""


@dataclass(frozen=True)
class Structure:
    """A robot at a regular posture of its branch.

    Attributes:
        rank: of the constraint rows.
        locked: number of independent motions with all actuators locked.
        idle: how many of them are idle.
        directions: in which the tool point can move with the idle motions left out, 0 to 3.
    """

    rank: int
    locked: int
    idle: int
    directions: int

    @staticmethod
    def of(kinematics: Kinematics, actuated: Array, postures: list[Placed]) -> Structure:
        """From closed postures."""
        rank, locked, idle, directions = [], [], [], []
        for placed in postures:
            free = locked_motions(kinematics, actuated, placed)
            rank.append(rank_of(placed.scaled))
            locked.append(free.shape[1])
            idle.append(idle_motions(kinematics, actuated, placed, free).shape[1])
            directions.append(_directions(kinematics, placed))
        return Structure(max(rank), min(locked), min(min(idle), min(locked)), max(directions))


def is_steady(kinematics: Kinematics, placed: Placed) -> bool:
    """Whether rows that depend on others do so in the next moment too: a shaky structure moves, but only just."""
    k, split = kinematics, Split.of(placed.scaled)
    motions = split.null
    for speed in np.random.default_rng(0).normal(size=(2, motions.shape[1])):
        gamma = k.row_scale * k.moving(placed.q, k.column_scale * (motions @ speed)).drift
        left = gamma - split.left @ (split.left.T @ gamma)
        if not np.abs(left).max(initial=0.0) <= tolerances.REACHED.value * float(speed @ speed):
            return False
    return True


def locked_motions(kinematics: Kinematics, actuated: Array, placed: Placed) -> Array:
    """Orthonormal basis of the dimensionless motions with all actuators locked, shape (nv, k)."""
    held = np.eye(kinematics.model.nv)[actuated]
    return null_space(np.concatenate([placed.scaled, held]))


def idle_motions(kinematics: Kinematics, actuated: Array, placed: Placed, locked: Array) -> Array:
    """Those of the motions with all actuators locked, shape (nv, k), that are idle, shape (nv, fewer)."""
    k = kinematics
    if not locked.shape[1]:
        return locked
    if k.tool_support is not None:
        return np.asarray(locked @ null_space(scaled_tool(k, placed) @ locked))
    spins = [part for part in _parts(k, locked) if _is_spin(k, placed, part)]
    return np.concatenate(spins, axis=1) if spins else locked[:, :0]


def scaled_tool(kinematics: Kinematics, placed: Placed) -> Array:
    """Jacobian of the tool's pose, dimensionless, shape (6, nv)."""
    rows = np.array([1.0 / kinematics.length] * 3 + [1.0] * 3)
    return np.asarray(rows[:, None] * placed.tool_jacobian * kinematics.column_scale)


def _directions(kinematics: Kinematics, placed: Placed) -> int:
    if kinematics.tool_support is None:
        return 0
    point = scaled_tool(kinematics, placed)[:3]
    return rank_of(np.concatenate([placed.scaled, point])) - rank_of(placed.scaled)


def _parts(kinematics: Kinematics, motions: Array) -> list[Array]:
    """Bases of the motions that have no joint in common, shape (nv, parts) each."""
    model = kinematics.model
    joint_of = np.concatenate([np.full(model.nvs[j], j) for j in range(1, model.njoints)]) if model.nv else np.zeros(0)
    label = _components((np.abs(motions @ motions.T) > 1e-9) | (joint_of[:, None] == joint_of))
    parts = []
    for one in np.unique(label):
        inside = motions * (label == one)[:, None]
        left, values, _ = np.linalg.svd(inside, full_matrices=False)
        count = int(np.count_nonzero(values > 1e-9))
        if count:
            parts.append(left[:, :count])
    return parts


def _is_spin(kinematics: Kinematics, placed: Placed, motion: Array) -> bool:
    """Whether one motion turns bodies together about one axis, and at least two connections hold them."""
    k, model = kinematics, kinematics.model
    if motion.shape[1] != 1:
        return False
    rate = k.column_scale * motion[:, 0]
    twists = np.zeros((model.njoints, 6))
    for joint in range(1, model.njoints):
        own = slice(model.idx_vs[joint], model.idx_vs[joint] + model.nvs[joint])
        twists[joint] = twists[model.parents[joint]] + placed.twists[:, own] @ rate[own]
    twists[:, :3] /= k.length
    size = np.abs(twists).max(axis=1)
    moving = np.flatnonzero(size > 1e-9)
    if not len(moving) or np.abs(twists[moving] - twists[moving[0]]).max() > 1e-9:
        return False
    turn, shift = twists[moving[0], 3:], twists[moving[0], :3]
    if not np.linalg.norm(turn) > 1e-9 or abs(turn @ shift) > 1e-9:
        return False
    held = sum((joint in moving) != (model.parents[joint] in moving) for joint in range(1, model.njoints))
    held += sum((cut.joint_a in moving) != (cut.joint_b in moving) for cut in k.closure.cuts)
    return bool(held >= 2)


def independent_parts(
    kinematics: Kinematics, driver: Driver, hub: Array | None, geared: list[int], q: Array
) -> list[list[int]]:
    """Groups of joints that the loops or the tree tie together while `driver` holds the hub, so that where the links of
    a group are is up to its own joints.  The joints that carry the hub are one group.

    Read off the pattern of the equations, at `q` (nq,) and at a place near by, lest a zero be one of the posture alone.

    Args:
        geared: velocities of joints whose whole turns others must go along with; held or not, they stay with these.
    """
    model = kinematics.model
    tied = np.eye(model.nv, dtype=bool)
    if hub is not None:
        carrying = hub > 0.0
        tied |= np.outer(carrying, carrying)
    for joint in range(1, model.njoints):
        own = slice(model.idx_vs[joint], model.idx_vs[joint] + model.nvs[joint])
        tied[own, own] = True
        parent = model.parents[joint]
        if parent > 0 and (hub is None or parent != kinematics.tool_joint):
            tied[own, model.idx_vs[parent]] = tied[model.idx_vs[parent], own] = True
    random = np.random.default_rng(0)
    aside = kinematics.tree.integrate(q, kinematics.column_scale * random.uniform(-0.3, 0.3, model.nv))
    for place in (q, aside):
        placed = kinematics.at(place)
        free = null_space(System(kinematics, driver).at(placed).matrix[kinematics.closure.rows :])
        projector = free @ free.T
        tied |= np.abs(projector) > TIED
        rows = placed.scaled
        touched = np.abs(rows @ projector) > TIED
        touched |= (np.abs(rows) > TIED) & (np.abs(rows[:, geared]) > TIED).any(axis=1, keepdims=True)
        tied |= touched.T.astype(float) @ touched.astype(float) > 0.0
    parts: dict[int, list[int]] = {}
    label = _components(tied)
    for joint in range(1, model.njoints):
        parts.setdefault(int(label[model.idx_vs[joint]]), []).append(joint)
    return list(parts.values())


def _components(tied: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Label of the connected component of every node of a graph, shape (n,), smallest member first."""
    label = np.arange(len(tied))
    while True:
        lower = np.where(tied, label[None, :], len(tied)).min(axis=1, initial=len(tied))
        if (lower >= label).all():
            return label
        label = np.minimum(label, lower)
