"""Parts of a robot that move independently of one another while something is held."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.chain.closing.drivers import Driver
from cutjoint.chain.closing.equations import System
from cutjoint.chain.kinematics import Kinematics
from cutjoint.chain.rank import null_space

TIED = 1e-7
"""Velocities are tied together by entries larger than this of dimensionless matrices."""


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
