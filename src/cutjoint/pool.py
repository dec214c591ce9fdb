"""Independent runs on all cores."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import traceback
from collections.abc import Callable, Generator, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from multiprocessing import connection, get_context, parent_process, resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any, TypeAlias, TypeVar

from cutjoint import interrupts
from cutjoint.errors import Interrupted

Key = Hashable
K = TypeVar("K", bound=Hashable)
Task = tuple[Callable[..., object], tuple[object, ...]]
Outcome: TypeAlias = Any
"""What a task returned: whoever set the task knows its type."""

MOST = 4
OFTEN = 0.2
"""Seconds between two looks for an interrupt."""


def run_all(tasks: Mapping[K, Task], done: Callable[[int], None] | None = None) -> dict[K, Outcome]:
    """Call every function with its arguments; key -> what it returned, in the order of the tasks.

    Functions and arguments must be importable: worker processes are started afresh.  They end with this process,
    whatever ends it.  The first error is raised and the tasks that are not done are dropped.  `done` is told how many
    tasks are finished.

    Raises:
        Interrupted: a `KeyboardInterrupt` came; `result` holds what was done.
    """
    with workers(len(tasks)) as run:
        return run(tasks, done)


Run: TypeAlias = Callable[..., dict[Any, Outcome]]
"""`run_all` in processes that are there already."""


@contextmanager
def workers(most: int = MOST) -> Iterator[Run]:
    """What runs tasks as `run_all` does, as often as wanted in the block, in the same processes, at most `most`."""
    count = min(len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1, MOST, most)
    if count <= 1:
        yield lambda tasks, done=None: _gathered(tasks, _here(tasks), done)
        return
    with _workers(count) as pipes:
        yield lambda tasks, done=None: _gathered(tasks, _beside(tasks, pipes), done)


def _gathered(
    tasks: Mapping[K, Task], each: Generator[tuple[K, Outcome], None, None], done: Callable[[int], None] | None
) -> dict[K, Outcome]:
    """What the tasks returned, in their order."""
    found: dict[K, Outcome] = {}
    try:
        with interrupts.asking(), contextlib.closing(each):
            for key, outcome in each:
                found[key] = outcome
                if done is not None:
                    done(len(found))
    except KeyboardInterrupt as error:
        told = f"interrupted; {len(found)} of {len(tasks)} runs are done"
        raise Interrupted(told, done=len(found) / len(tasks), result=found) from error
    return {key: found[key] for key in tasks}


def _here(tasks: Mapping[K, Task]) -> Generator[tuple[K, Outcome], None, None]:
    """One after another, in this process."""
    for key, (function, arguments) in tasks.items():
        yield key, function(*arguments)
        interrupts.check()


def _beside(tasks: Mapping[K, Task], pipes: Sequence[Connection]) -> Generator[tuple[K, Outcome], None, None]:
    """In the processes behind the pipes, in the order in which they are done."""
    left = list(tasks.items())[::-1]
    busy: dict[Connection, K] = {}
    for pipe in pipes:
        if left:
            busy[pipe], task = left.pop()
            pipe.send(task)
    while busy:
        ready = connection.wait(list(busy), OFTEN)
        for pipe in [one for one in busy if one in ready]:
            key = busy.pop(pipe)
            yield key, _answer(pipe, key)
            if left and not interrupts.waiting():
                busy[pipe], task = left.pop()
                pipe.send(task)
        interrupts.check()


def _answer(pipe: Connection, key: Hashable) -> Outcome:
    """What came of a task, or its error."""
    try:
        well, outcome = pipe.recv()
    except EOFError as error:
        raise RuntimeError(f"the process that ran {key} was killed; is there memory enough?") from error
    if not well:
        raise outcome
    return outcome


@contextmanager
def _workers(count: int) -> Iterator[list[Connection]]:
    """The pipes to new processes, which are ended with the block.

    They do not see the terminal's Ctrl-C, nor a SIGTERM for the whole group: those are this process's to answer.
    """
    context = get_context("spawn")
    processes: list[SpawnProcess] = []
    pipes: list[Connection] = []
    try:
        with interrupts.held(), _blocked():
            for _ in range(count):
                ours, theirs = context.Pipe()
                pipes.append(ours)
                process = context.Process(target=_work, args=(theirs,), name="cutjoint-worker")
                process.start()
                processes.append(process)
                theirs.close()
        yield pipes
    finally:
        with interrupts.held():
            for process in processes:
                process.kill()
            for process in processes:
                process.join()
            for pipe in pipes:
                pipe.close()


@contextmanager
def _blocked() -> Iterator[None]:
    """Processes that are started in the block never get the signals that end programs from outside."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # it would let the signals through when it is started
    before = signal.pthread_sigmask(signal.SIG_BLOCK, interrupts.SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _work(pipe: Connection) -> None:
    """A worker: answers tasks until there are no more, and ends when its parent does."""
    if not hasattr(signal, "pthread_sigmask"):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_follow, name="cutjoint-parent", daemon=True).start()
    with contextlib.suppress(EOFError, OSError):
        while True:
            function, arguments = pipe.recv()
            pipe.send(_called(function, arguments))


def _called(function: Callable[..., object], arguments: tuple[object, ...]) -> tuple[bool, object]:
    """Whether a call went well, and what it returned or raised."""
    try:
        return True, function(*arguments)
    except Exception as error:
        error.add_note(f"in a worker process:\n{traceback.format_exc()}")
        return False, error


def _follow() -> None:
    """End this process when its parent has ended."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
