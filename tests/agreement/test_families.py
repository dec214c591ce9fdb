"""Every cut type with and without gear, slide and universal joint, in the plane, about a point and in space.

Each loop stands at forty random mountings, with gravity turned along or not.  Against the oracle: both equations of
motion, accelerations, loop forces, forward(inverse(a)) - a, and that a loop whose gravity is turned along moves the
same at every mounting.  See `kit.loops` for what each combination is.
"""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from kit import judge
from kit.blueprint import random_mounting
from kit.built import built, choose_actuators
from kit.by_joint import full, placed
from kit.loops import CUTS, EXTRAS, SPACES, loop
from kit.postures import random_posture
from oracles.placed import Placed

from cutjoint.chain import ClosedChain

ACCURACY = 1e-9
"""Relative.  What is left of 1e-16 is the conditioning of random shapes."""

FAMILIES = list(product(SPACES, CUTS, EXTRAS))


def shaped(space: str, cut: str, extra: str, seed: int, folder: Path) -> tuple:
    """A loop that is regular at home, with its actuator."""
    for attempt in range(60):
        rng = np.random.default_rng([seed, attempt, *f"{space} {cut} {extra}".encode()])
        plan, freedoms = loop(space, cut, extra, rng)
        choose_actuators(plan, folder)
        chain, oracle = built(plan, folder)
        home = placed(chain, oracle, chain.home.q_full)
        assert home.mobility == freedoms, "the loop is not what it was drawn to be"
        if home.margin[0] > 1e-2 and plan.actuators and judge.leverage(home) > 0.03:
            return plan, rng
    raise AssertionError("no regular shape")


def check(family: tuple[str, str, str], shapes: int, mountings: int, folder: Path, compiled: bool = False) -> None:
    for shape in range(shapes):
        plan, rng = shaped(*family, shape, folder / "shape")
        speed, effort, turned = None, None, []
        for index in range(mountings):
            mounting = random_mounting(rng, turned=index % 2 == 0)
            chain, oracle = built(plan, folder / f"{shape}.{index}", mounting)
            effort = rng.normal(size=chain.nv) if effort is None else effort
            at = chain.home if index % 4 == 0 else random_posture(chain, oracle, rng)
            p = placed(chain, oracle, at.q_full)
            speed = rng.normal(size=chain.n) if speed is None else speed
            v = _led(chain, p, speed)
            robot = chain.compile() if compiled else None
            found = judge.everything(chain, oracle, at, v, effort, rng, robot)
            judge.require(found, ACCURACY, f"mounting {index}: {mounting}")
            if index % 4 == 0:
                turned.append(chain.full_forward_dynamics(at, v, effort).acceleration)
        size = np.abs(turned[0]).max() + 1.0
        np.testing.assert_allclose(turned, np.broadcast_to(turned[0], np.shape(turned)), rtol=0, atol=ACCURACY * size)


def _led(chain: ClosedChain, p: Placed, speed: np.ndarray) -> np.ndarray:
    """Velocity of all joints that has these of the actuators, so the same motion at every mounting."""
    return full(chain, p.with_actuators(dict(zip(p.oracle.robot.actuators, speed, strict=True))).speeds)


@pytest.mark.parametrize(("space", "cut", "extra"), FAMILIES)
def test_at_a_random_mounting(space: str, cut: str, extra: str, tmp_path: Path) -> None:
    check((space, cut, extra), 1, 1, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(("space", "cut", "extra"), FAMILIES)
def test_at_forty_mountings(space: str, cut: str, extra: str, tmp_path: Path) -> None:
    check((space, cut, extra), 1, 40, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(("space", "cut", "extra"), FAMILIES)
def test_in_other_shapes(space: str, cut: str, extra: str, tmp_path: Path) -> None:
    check((space, cut, extra), 6, 2, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(("space", "cut", "extra"), FAMILIES)
def test_compiled(space: str, cut: str, extra: str, tmp_path: Path) -> None:
    pytest.importorskip("llvmlite")
    check((space, cut, extra), 1, 2, tmp_path, compiled=True)
