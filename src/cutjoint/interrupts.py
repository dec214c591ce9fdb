"""Ctrl-C (SIGINT) and SIGTERM of the command line: what is being written gets written, what was computed is kept.

The command line watches both signals from its first moment on (`watch`).  Until something is computed that can be kept,
they end the program.  From then on the first one raises `KeyboardInterrupt` where that does no harm: after a write
(`held`), after what was computed is kept (`keeping`), not amid an import, and of a computation that asks (`asking`) at
its next `check`.  The next one ends the program at once, but for a write.  Nothing here does anything in a program that
does not watch: the library leaves the signals of its users alone, and all of this may be called in any thread.
"""

from __future__ import annotations

import math
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from types import FrameType

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM") if hasattr(signal, name))
SOON, LATEST = 0.02, 0.8
"""Seconds until it is looked again whether an import has ended, and until a computation that did not ask is stopped."""
SAME = 0.3
"""A signal so many seconds after the first one is that one again: `timeout` and the like send it to the program and
to its group."""
SHOW_CURSOR = "\x1b[?25h"
NEVER = -1.0
_IMPORTING = "<frozen importlib."


class _Watch:
    """What is known of the signals of this process.

    Attributes:
        watching, starting, ending: whether signals are watched, nothing is computed yet, all is done.
        seen: the first signal, and `since` when it came [s].
        waiting: whether it has not been answered yet, and `hurry` whether another one came.
        blocks: those that the main thread is in, as the seconds that a signal may wait in them; `held` is NEVER.
        kept: whether a block of `keeping` has come to its end.
    """

    def __init__(self) -> None:
        self.watching, self.starting, self.ending = False, False, False
        self.seen: int | None = None
        self.since, self.waiting, self.hurry = 0.0, False, False
        self.blocks: list[float] = []
        self.kept = False

    @property
    def held(self) -> bool:
        """Whether a write must not be interrupted."""
        return NEVER in self.blocks

    @property
    def patience(self) -> float:
        """Seconds that a signal may wait here."""
        return self.blocks[-1] if self.blocks else 0.0

    def came(self, number: int, frame: FrameType | None) -> None:
        """A signal.

        Raises:
            KeyboardInterrupt: see `act`.
        """
        if self.seen is None:
            self.seen, self.since, self.waiting = number, time.monotonic(), True
        elif time.monotonic() - self.since > SAME:
            self.hurry = True
        elif not self.ending:
            return
        if self.ending or ((self.starting or self.hurry) and not self.held):
            self.leave()
        if self.patience:
            _later(self.patience)
        else:
            self.act(frame)

    def leave(self) -> None:
        """End the program at once."""
        if self.starting:
            _say(f"interrupted ({name()}): nothing was written\n")
        if sys.stderr.isatty():
            _say(SHOW_CURSOR)
        os._exit(status())

    def act(self, frame: FrameType | None, *, asked: bool = False) -> None:
        """Raise what a signal asks for, or look again soon where an exception would be lost or do harm.

        Raises:
            KeyboardInterrupt: now.
        """
        if not self.waiting or self.held or (not asked and math.isinf(self.patience)):
            return
        if not asked and _delicate(frame):
            _later(SOON)
            return
        _later(0.0)
        self.waiting = False
        raise KeyboardInterrupt(f"interrupted ({name()})")

    def released(self) -> None:
        """A block is left in which signals waited."""
        if (self.hurry or (self.starting and self.waiting)) and not self.held:
            self.leave()
        if self.waiting:
            _later(self.patience or SOON)


_WATCH = _Watch()


def watch() -> None:
    """Watch the signals from now on; until the first block of `keeping` or `asking` they end the program at once."""
    if _WATCH.watching:
        return
    _WATCH.watching = _WATCH.starting = True
    for number in SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:  # nohup, and what a script runs in the background
            signal.signal(number, _WATCH.came)
    if hasattr(signal, "SIGALRM"):
        signal.signal(signal.SIGALRM, lambda _, frame: _WATCH.act(frame))


def done() -> None:
    """All is done: a signal now only makes the program's end quicker."""
    answered()
    _WATCH.ending = _WATCH.watching


def answered() -> None:
    """The signal that waits has been seen to; no exception comes of it any more."""
    if _WATCH.watching:
        _WATCH.waiting = False
        _later(0.0)


def name() -> str:
    """Of the signal that came first."""
    return signal.Signals(_WATCH.seen or signal.SIGINT).name


def status() -> int:
    """Exit status of a program that a signal ended: 130 or 143."""
    return 128 + int(_WATCH.seen or signal.SIGINT)


def came() -> bool:
    """Whether a signal came."""
    return _WATCH.seen is not None


def kept() -> bool:
    """Whether what was computed is kept: a block of `keeping` has come to its end."""
    return _WATCH.kept


def waiting() -> bool:
    """Whether a signal came that has not been answered."""
    return _WATCH.waiting


def check() -> None:
    """Between two steps of a computation.

    Raises:
        KeyboardInterrupt: a signal came.
    """
    if _WATCH.waiting and _main():
        _WATCH.act(None, asked=True)


def held() -> AbstractContextManager[None]:
    """Signals wait until the block, which is short, is left."""
    return _block(NEVER)


def keeping() -> AbstractContextManager[None]:
    """The first signal waits until the block is left, where what was computed is kept; another one does not."""
    return _block(math.inf)


def asking() -> AbstractContextManager[None]:
    """In the block `check` is called every now and then, and signals wait for it, but not for long."""
    return _block(LATEST)


@contextmanager
def _block(patience: float) -> Iterator[None]:
    if not _main():
        yield
        return
    _WATCH.starting = _WATCH.starting and patience == NEVER
    _WATCH.blocks.append(patience)
    try:
        yield
        _WATCH.kept = _WATCH.kept or math.isinf(patience)
    finally:
        _WATCH.blocks.pop()
        _WATCH.released()


def _main() -> bool:
    return threading.current_thread() is threading.main_thread()


def _delicate(frame: FrameType | None) -> bool:
    """Whether an exception would come amid an import or the end of an object, where it becomes another or is lost."""
    while frame is not None:
        if frame.f_code.co_filename.startswith(_IMPORTING) or frame.f_code.co_name == "__del__":
            return True
        frame = frame.f_back
    return False


def _later(seconds: float) -> None:
    """Look again in so many seconds; 0 and without end: never."""
    if not 0.0 <= seconds < math.inf:
        return
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, seconds)
    elif seconds:
        _WATCH.act(None, asked=True)


def _say(text: str) -> None:
    os.write(2, text.encode())
