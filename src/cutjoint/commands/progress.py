"""How far a long command is, on stderr: a bar on a terminal, elsewhere a line now and then."""

from __future__ import annotations

import contextlib
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from cutjoint.commands.output import is_terminal
from cutjoint.texts import cut

EVERY = 5.0
"""Seconds between two lines, and until the first one: what is done sooner says nothing."""
Told = Callable[[float], None]


@contextmanager
def progress(what: str, total: float | None = None, unit: str = "") -> Iterator[Told]:
    """In the block it is shown how far the work is: `what`, as far as the yielded function is told, of `total` in
    `unit`; without a total that it goes on."""
    if is_terminal(sys.stderr):
        from rich.console import Console
        from rich.markup import escape
        from rich.progress import Progress

        with Progress(transient=True, console=Console(stderr=True), redirect_stdout=False) as bar:
            task = bar.add_task(escape(cut(what)), total=total)
            yield lambda done: bar.update(task, completed=done)
        return
    log = _Log(what, total, unit)
    writer = threading.Thread(target=log.write, name="cutjoint-progress", daemon=True)
    writer.start()
    try:
        yield log.told
    finally:
        log.ended.set()
        writer.join()


class _Log:
    """Lines of a log.

    Attributes:
        ended: set where the work is done.
    """

    def __init__(self, what: str, total: float | None, unit: str) -> None:
        self.ended = threading.Event()
        self._what, self._total, self._unit = cut(what), total, unit
        self._done, self._began = 0.0, time.monotonic()
        self._first: tuple[float, float] | None = None

    def told(self, done: float) -> None:
        """So much is done."""
        self._done = done
        if self._first is None:
            self._first = done, time.monotonic()

    def write(self) -> None:
        """Write lines until the work has ended."""
        while not self.ended.wait(EVERY):
            with contextlib.suppress(OSError, ValueError, AttributeError):  # nobody reads any more
                print(self.line(), file=sys.stderr, flush=True)

    def line(self) -> str:
        """What is to be said now."""
        since = f"{time.monotonic() - self._began:.0f} s"
        if self._total is None:
            return f"{self._what}: {since} so far"
        return f"{self._what}: {_number(self._done)} of {_number(self._total)} {self._unit} after {since}{self._left()}"

    def _left(self) -> str:
        """How long it still takes, if it goes on as since it was first told how far it is."""
        if self._first is None or self._total is None or self._done <= self._first[0]:
            return ""
        took = time.monotonic() - self._first[1]
        return f", about {took * (self._total - self._done) / (self._done - self._first[0]):.0f} s left"


def _number(value: float) -> str:
    return str(int(value)) if value == int(value) else f"{value:.4g}"
