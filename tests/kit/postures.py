"""Random closed postures and velocities of a chain, with motions that the oracle says are possible."""

from __future__ import annotations

from typing import Any

import numpy as np
from kit.by_joint import full, placed
from oracles.maximal import Maximal
from oracles.placed import Placed

from cutjoint.errors import CutjointError

Array = np.ndarray

REGULAR = 5e-3
"""Random postures keep away from singular ones: their smallest singular value that counts is at least this."""


def moving(chain: Any, p: Placed, amounts: Array) -> Array:
    """Velocity of the chain's joints, (nv,): the oracle's motions in these amounts (mobility,), [rad/s] and lengths."""
    flat = p.joint_motions() @ amounts
    return full(chain, {name: flat[own] for name, own in p.oracle.velocity.items()})


def random_posture(
    chain: Any, oracle: Maximal, rng: np.random.Generator, reach: float = 0.4, mobility: int | None = None
) -> Any:
    """A regular posture around home, of this mobility if one is given; home itself where nothing else is found."""
    home = placed(chain, oracle, chain.home.q_full)
    if not home.mobility:
        return chain.home
    for _ in range(12 if mobility is None else 60):  # a home where branches meet needs luck
        amounts = rng.normal(size=home.mobility)
        step = moving(chain, home, amounts)
        size = float(np.abs(step / scale_of(chain, oracle)).max())
        start = chain.integrate(chain.home.q_full, step * (reach * rng.uniform(0.3, 1.0) / size))
        reach *= 0.9 if mobility is None else 0.98
        try:
            at = chain.assemble(start, keep_actuators=False)
        except CutjointError:
            continue
        found = placed(chain, oracle, at.q_full)
        closed = found.gap < 1e-11
        if closed and found.margin[0] > REGULAR and mobility in (None, found.mobility):
            return at
    return chain.home


def scale_of(chain: Any, oracle: Maximal) -> Array:
    """The length for the chain's velocities that are lengths, 1 for angles, shape (nv,)."""
    flags = {name: np.full(own.stop - own.start, 1.0) for name, own in oracle.velocity.items()}
    for joint in oracle.robot.joints:
        lengths = {"prismatic": 1, "planar": 2, "floating": 3}.get(joint.kind, 0)
        flags[joint.name][:lengths] = oracle.length
    return full(chain, flags)
