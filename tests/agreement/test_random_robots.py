"""Random robots: right by the oracle, or a clear error; no third outcome.

Two thousand in the slow run, in blocks that can run side by side.  A robot that fails is shrunk to fewer joints and
cuts; what is printed makes it again.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st
from kit.verdict import Verdicts

BLOCKS, IN_BLOCK = 40, 50
REFUSED = 0.02
"""Part of all answers that may be refusals for which the oracle sees no cause."""


def judge_many(block: int, count: int) -> Verdicts:
    """Verdicts on `count` robots of a block; a failing one is shrunk."""
    verdicts = Verdicts()

    @seed(block)
    @settings(max_examples=count, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(st.integers(2, 8), st.integers(1, 3), st.integers(0, 2**32 - 1))
    def right_or_refused(joints: int, closures: int, number: int) -> None:
        verdicts.judge(np.random.default_rng([block, number]), joints, closures)

    right_or_refused()
    return verdicts


def check(verdicts: Verdicts) -> None:
    counts = verdicts.counts
    assert counts["refused"] <= REFUSED * counts["answers"], verdicts.reasons
    assert min(counts["moves"], counts["structure"]) > 0, "robots of both kinds"
    assert counts["answers"] > 3 * sum(number for what, number in counts.items() if what.startswith("not judged"))


def test_sixty_robots() -> None:
    check(judge_many(1000, 60))


@pytest.mark.slow
@pytest.mark.parametrize("block", range(BLOCKS))
def test_two_thousand_robots(block: int) -> None:
    check(judge_many(block, IN_BLOCK))
