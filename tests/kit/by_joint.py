"""A chain's vectors by joint, as `oracles.maximal` takes them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from oracles.maximal import Maximal
from oracles.motion import State
from oracles.placed import Placed

Array = np.ndarray


def coordinates(chain: Any, q_full: Array) -> dict[str, Any]:
    """Pinocchio's configuration as values of joints: rotations for balls, placements for floating joints."""
    model, found = chain.model, {}
    for index in range(1, model.njoints):
        own = q_full[model.idx_qs[index] :][: model.nqs[index]]
        kind = model.joints[index].shortname()
        if kind == "JointModelSpherical":
            found[model.names[index]] = rotation(own)
        elif kind == "JointModelFreeFlyer":
            placement = np.eye(4)
            placement[:3, :3], placement[:3, 3] = rotation(own[3:]), own[:3]
            found[model.names[index]] = placement
        elif kind == "JointModelPlanar":
            found[model.names[index]] = np.array([own[0], own[1], np.arctan2(own[3], own[2])])
        else:
            found[model.names[index]] = own if len(own) > 1 else float(own[0])
    return found


def rotation(quaternion: Array) -> Array:
    """Rotation (3, 3) of a quaternion (x, y, z, w)."""
    x, y, z, w = quaternion / np.linalg.norm(quaternion)
    s = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2.0 * w * s + 2.0 * s @ s


def by_joint(chain: Any, vector: Array) -> dict[str, Array]:
    """A vector over the chain's velocities (velocity, acceleration, effort) by joint."""
    model = chain.model
    return {
        model.names[index]: np.asarray(vector)[model.idx_vs[index] :][: model.nvs[index]]
        for index in range(1, model.njoints)
    }


def full(chain: Any, values: dict[str, Array]) -> Array:
    """The reverse of `by_joint`, shape (nv,)."""
    model, vector = chain.model, np.zeros(chain.nv)
    for index in range(1, model.njoints):
        vector[model.idx_vs[index] :][: model.nvs[index]] = values[model.names[index]]
    return vector


def oracle_of(chain: Any, path: Path | str | None = None, origin: Array | None = None) -> Maximal:
    """The oracle of the files that a chain was read from, with the chain's length."""
    description = chain.description
    return Maximal(path or description.path, description.variant_name or None, chain.length, origin)


def placed(chain: Any, oracle: Maximal, q_full: Array) -> Placed:
    """The oracle's robot at a configuration of the chain."""
    return oracle.at(coordinates(chain, q_full))


def state(chain: Any, oracle: Maximal, q_full: Array, v_full: Array) -> State:
    """The same with velocities."""
    return placed(chain, oracle, q_full).moving(by_joint(chain, v_full))
