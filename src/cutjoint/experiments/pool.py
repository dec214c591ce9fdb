"""Independent runs on all cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import Any, TypeAlias, TypeVar

Key = Hashable
K = TypeVar("K", bound=Hashable)
Task = tuple[Callable[..., object], tuple[object, ...]]
Outcome: TypeAlias = Any
"""What a task returned: whoever set the task knows its type."""

MOST = 4


def run_all(tasks: Mapping[K, Task], done: Callable[[int], None] | None = None) -> dict[K, Outcome]:
    """Call every function with its arguments; key -> what it returned, in the order of the tasks.

    Functions and arguments must be importable: worker processes are started afresh.  The first error is raised and the
    tasks that have not begun are dropped.  `done` is told how many tasks are finished.
    """
    workers = min(len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1, MOST)
    found: dict[K, Outcome] = {}
    if workers == 1:
        for key, (function, arguments) in tasks.items():
            found[key] = function(*arguments)
            if done is not None:
                done(len(found))
        return found
    pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"))
    try:
        futures = {pool.submit(function, *arguments): key for key, (function, arguments) in tasks.items()}
        for future in as_completed(futures):
            found[futures[future]] = future.result()
            if done is not None:
                done(len(found))
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
    return {key: found[key] for key in tasks}
