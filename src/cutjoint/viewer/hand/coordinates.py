"""The joints of a posture in numbers: the coordinates of every joint, as a home posture of loops.toml gives them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cutjoint.chain import ClosedChain
from cutjoint.mechanism import Posture

AT_LIMIT = 2e-3
"""A joint this near to a limit is said to be at it: twice what a move stops short of one, [rad] or robot lengths."""


def coordinates_of(chain: ClosedChain, at: Posture) -> Mapping[str, tuple[float, ...]]:
    """Coordinates of every joint that moves, by its name in the order of the tree: [m] and [rad]."""
    moving = [joint.name for joint in chain.description.joints if joint.type.moves]
    return {name: tuple(np.atleast_1d(at[name]).tolist()) for name in moving}


def at_limits(chain: ClosedChain, coordinates: Mapping[str, tuple[float, ...]]) -> list[str]:
    """Names of the joints that are at one of their limits, or beyond."""
    found: list[str] = []
    for joint in chain.description.joints:
        if joint.type.limited and joint.name in coordinates:
            (value,) = coordinates[joint.name]
            near = AT_LIMIT * (chain.length if joint.type.slides else 1.0)
            lower, upper = joint.limits.ends
            if value < lower + near or value > upper - near:
                found.append(joint.name)
    return found
