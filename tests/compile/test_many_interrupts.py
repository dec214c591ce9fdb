"""An interrupt ends many runs within a step of each, and those that were done are the runs that would have been."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

from cutjoint.compile import compiled
from cutjoint.compile.many.closed_loop import ClosedLoop
from cutjoint.compile.many.results import Many
from cutjoint.control import PD
from cutjoint.errors import Interrupted
from cutjoint.motion import Circle, Reference
from cutjoint.papers.cpm.published import CIRCLE


@contextmanager
def interrupted(after: float) -> Iterator[None]:
    """Ctrl-C after so many seconds."""
    timer = threading.Timer(after, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def loop_and_table(kit: Any) -> tuple[ClosedLoop, Any]:
    """A closed loop with gains of its own a run, and its reference over a second in steps of 1 ms."""
    paper = kit.model("paper cpm")
    reference = Reference(Circle(CIRCLE.centre, CIRCLE.radius, CIRCLE.omega), paper, 1.0)
    loop = ClosedLoop(compiled(paper), PD(7e3, 300.0), paper, gains=("kp",))
    return loop, loop.reference_table(reference, 1e-3, 1000)


@pytest.mark.parametrize("threads", [1, 2])
def test_one_long_run_ends_at_once(kit: Any, threads: int) -> None:
    loop, table = loop_and_table(kit)
    loop.run(table, step=1e-3, gains={"kp": [7e3]})  # compiled by now
    long = np.vstack([*[table[:-1]] * 2000, table[-1:]])  # some ten seconds
    began = time.perf_counter()
    with pytest.raises(Interrupted) as caught, interrupted(0.2):
        loop.run(long, step=1e-3, gains={"kp": [7e3]}, threads=threads)
    assert time.perf_counter() - began < 5.0
    assert isinstance(caught.value, KeyboardInterrupt)
    assert (caught.value.done, caught.value.result) == (0.0, None)


@pytest.mark.slow
@pytest.mark.parametrize("threads", [1, 2])
def test_runs_that_were_done_are_the_runs(kit: Any, threads: int) -> None:
    loop, table = loop_and_table(kit)
    gains = np.random.default_rng(1).uniform(6e3, 9e3, (400_000, 3))
    began = time.perf_counter()
    whole = loop.run(table, step=1e-3, gains={"kp": gains[:4000]}, every=0.5, threads=threads)
    taken = time.perf_counter() - began
    with pytest.raises(Interrupted) as caught, interrupted(4.0 * taken):  # of a hundred times as many
        loop.run(table, step=1e-3, gains={"kp": gains}, every=0.5, threads=threads)
    found = caught.value.result
    assert isinstance(found, Many)
    assert 0 < len(found.q) < len(gains)
    assert caught.value.done == len(found.q) / len(gains)
    both = min(len(found.q), len(whole.q))
    np.testing.assert_array_equal(found.q[:both], whole.q[:both])
    np.testing.assert_array_equal(found.error_rms[:both], whole.error_rms[:both])
