"""Random loads on a robot, the same for the oracle, and minimal coordinates of any robot."""

from __future__ import annotations

from typing import Any

import numpy as np
from oracles.placed import Placed

from cutjoint.chain import ClosedChain
from cutjoint.chain.minimal import MinimalCoordinates
from cutjoint.errors import ActuationError
from cutjoint.mechanism import Load

Array = np.ndarray


def random_loads(chain: Any, rng: np.random.Generator, weight: float, count: int = 4) -> list[Load]:
    """Loads of about `weight` [N] on random links, and one on the tool where there is one."""
    links: list[str | None] = [link.name for link in chain.description.links]
    chosen = list(rng.choice(np.array(links), size=count)) + ([] if chain.description.tool is None else [None])
    return [
        Load(
            weight * rng.normal(size=3),
            weight * chain.length * rng.normal(size=3),
            None if link is None else str(link),
            chain.length * rng.normal(size=3),
            "world" if rng.random() < 0.5 else "link",
        )
        for link in chosen
    ]


def outside(placed: Placed, loads: list[Load]) -> Array:
    """The oracle's wrenches of loads."""
    total = np.zeros(placed.oracle.size)
    for load in loads:
        tool = placed.oracle.robot.tool
        link, turn, start = load.link, np.eye(3), np.zeros(3)
        if link is None:
            assert tool is not None
            link, turn, start = tool.link, tool.rotation, tool.position
        axes = np.eye(3) if load.axes == "world" else placed.poses[link].rotation @ turn
        total += placed.wrench(link, axes @ load.force, axes @ load.moment, start + turn @ load.point)
    return total


def minimal_of(chain: ClosedChain, *named: str) -> MinimalCoordinates:
    """Minimal coordinates, with as many passive joints named as it takes: the first that serve, hinges and slides
    before others, whose velocities are less likely to be independent."""
    try:
        return chain.minimal(named)
    except ActuationError as error:
        for name in sorted(error.free, key=lambda one: not chain.description.joint(one).type.single):
            try:
                return minimal_of(chain, *named, name)
            except ActuationError:
                continue
        raise
