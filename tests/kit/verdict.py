"""Right, refused, or wrong: what cutjoint makes of a robot that may be anything."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from kit import judge
from kit.blueprint import random_mounting
from kit.built import at_home
from kit.by_joint import by_joint, oracle_of, placed
from kit.postures import moving, random_posture
from kit.random_robots import random_robot
from oracles.maximal import Maximal
from oracles.placed import Placed
from oracles.solving import MASSLESS

from cutjoint.chain import ClosedChain
from cutjoint.description import load_description
from cutjoint.errors import CutjointError

CLEAR = (1e-4, 1e-11)
"""Singular values above the first count for anybody, those below the second for nobody; between them, who can tell?"""


def conditioning(p: Placed) -> float:
    """How much rounding grows: of the constraints twice (forces push through them and back), and of the masses."""
    energy = np.linalg.eigvalsh(p.motions.T @ p.mass @ p.motions) if p.mobility else np.ones(1)
    real = energy[energy > MASSLESS * p.heaviest]
    spread = float(real.max() / real.min()) if len(real) else 1.0
    return max(p.margin[0] ** -2, spread)


def limit(p: Placed) -> float:
    """1e-9 for robots as machines are, more where their conditioning takes the digits."""
    return max(1e-9, 1e-13 * conditioning(p))


class Verdicts:
    """Counts of what came out, by kind, and the reasons of refusals."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self.reasons: list[str] = []

    def attempt(self, what: str, work: Callable[[], Any], cause: str = "") -> Any:
        """Result of the work, or None where cutjoint refuses; `cause` is why it may."""
        try:
            result = work()
        except CutjointError as error:
            self.counts[f"refused with cause: {cause}" if cause else "refused"] += 1
            if not cause:
                self.reasons.append(f"{what}: {type(error).__name__}: {error}")
            return None
        self.counts["answers"] += 1
        return result

    def judge(self, rng: np.random.Generator, joints: int, closures: int, curved: bool = False) -> None:
        """One random robot at home and, if it moves, elsewhere.

        Raises:
            AssertionError: something is neither right nor refused.
        """
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            plan = random_robot(rng, joints, closures, folder, curved)
            path = plan.write(folder, random_mounting(rng))
            drawn = Maximal(path, length=0.3)
            home = drawn.at(at_home(plan, drawn))
            assert max(map(max, home.gaps.values()), default=0.0) < 1e-13, "the robot is not drawn closed"
            chain = self.attempt("building", lambda: ClosedChain(load_description(path)), _cause(home))
            if chain is None:
                return
            oracle = oracle_of(chain, path)
        self.counts["moves" if home.mobility else "structure"] += 1
        self._at(chain, oracle, chain.home, rng)
        if home.mobility and rng.integers(2):
            at = random_posture(chain, oracle, rng)
            if at is not chain.home:
                self._at(chain, oracle, at, rng)

    def _at(self, chain: ClosedChain, oracle: Maximal, at: Any, rng: np.random.Generator) -> None:
        p = placed(chain, oracle, at.q_full)
        judge.require({"gap": p.gap}, 1e-11)
        cause, allowed = _cause(p), limit(p)
        if cause:
            self.counts[f"not judged: {cause}"] += 1
            self.attempt("mobility", lambda: chain.mobility(at), cause)
            return
        self.attempt("mobility", lambda: judge.mobility(chain, oracle, at))
        judge.require({"potential energy": judge.potential_energy(chain, oracle, at)}, 1e-12)
        effort = rng.normal(size=chain.nv)
        massless = "motion without mass" if p.moving({}).massless.shape[1] else ""
        for amount in (0.0, 1.0):
            v = moving(chain, p, amount * rng.normal(size=p.mobility))
            state = p.moving(by_joint(chain, v))
            motion = state.driven(by_joint(chain, effort))
            if judge.opens(motion):
                self.counts["velocities without accelerations"] += 1
                answer = self.attempt(
                    "open",
                    lambda v=v: chain.full_forward_dynamics(at, v, effort),
                    "no acceleration keeps it closed",
                )
                assert answer is None, "accelerations where none keeps the loops closed"
                continue
            found = self.attempt("forward", partial(judge.forward, chain, state, at, v, effort), massless)
            judge.require(found or {}, allowed, "forward")
            if massless:
                continue
            own = np.zeros(chain.nv)
            own[chain._actuated.v_index] = effort[chain._actuated.v_index]
            apart = self.attempt("full inverse", partial(judge.full_inverse, chain, state, at, v, own))
            judge.require({} if apart is None else {"full inverse": float(apart)}, allowed)
        if chain.n and not massless:
            found = self.attempt("actuated", lambda: judge.actuated(chain, oracle, at, rng))
            judge.require(found or {}, 100.0 * allowed, "actuated")


def _cause(p: Placed) -> str:
    """Why nobody can say what this robot is."""
    return "" if p.margin[0] > CLEAR[0] and p.margin[1] < CLEAR[1] else "nearly singular"
