"""Tolerances: where the tool of the Omega-3 chain is if its rods, arms and joints are not where they should be."""

from __future__ import annotations

import numpy as np

from benchmarks.rounds import Contender, Timing, measure
from cutjoint.chain import ClosedChain
from cutjoint.compile import CompiledChain, compiled
from cutjoint.robots import load

RODS = tuple(f"cuts.ball{k}a.b.z = cuts.ball{k}b.b.z" for k in (1, 2, 3))
"""Lengths of the rods: the loops keep those of a limb equal."""
PLACES = tuple(f"joints.{joint}{k}.origin.xyz" for joint in ("arm", "bar") for k in (1, 2, 3))
TOLERANCE = 1e-4
"""Half the width of what every number is drawn from [m]."""


def timings(count: int, calls: int, rounds: int) -> tuple[dict[str, Timing], float]:
    """CPU time a sample of the tool's position, in a batch of `count` on one core and by chains built anew; and the
    largest difference between the two [m]."""
    robot = compiled(load("omega3"), parameters=(*RODS, *PLACES))
    assert isinstance(robot, CompiledChain)
    robot.batch.threads = 1
    rng = np.random.default_rng(0)
    given = {name: x + TOLERANCE * rng.uniform(-1, 1, count) for name, x in robot.parameters.items()}
    q = robot.home.q + np.array([0.1, -0.1, 0.05])

    def anew(k: int) -> np.ndarray:
        values = {name: float(x[k]) for name, x in given.items()}
        chain = ClosedChain(robot.source.arguments.rebuilt(values))
        return chain.tool(chain.close(q)).position

    def batch() -> np.ndarray:
        return robot.batch.tool(q, parameters=given).position

    contenders = {
        "batch": Contender(batch, count),
        "anew": Contender(lambda: [anew(k) for k in range(calls)], calls),
    }
    found = batch()
    away = max(float(np.abs(found[k] - anew(k)).max()) for k in range(calls))
    return measure(contenders, rounds), away
