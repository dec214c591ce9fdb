"""One run of a headless browser: started by a keeper, spoken to over pipes, gone with its folder afterwards.

The pipes open no port, and the browser ends by itself when they break.  Should it not, or should this program be
killed, `cutjoint.viewer.browser.keeper` ends it and removes what it wrote.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from time import monotonic
from typing import IO

from cutjoint.viewer.browser import keeper
from cutjoint.viewer.browser.devtools import Devtools, LostError

PIPE = "--remote-debugging-pipe"
GRACE = 2.0
"""Seconds to end by itself, once it is asked to."""
ENDING = 5.0
"""Seconds from its closing the pipe to its end."""
TIDYING = 10.0
"""Seconds for the keeper to kill it and to remove its folder."""
WORDS_LINES = 12
WORDS_BYTES = 2000


class LostRunError(Exception):
    """This run of the browser came to nothing: why, its exit status if it ended by itself, and its last words."""

    def __init__(self, reason: str, status: int | None, words: str) -> None:
        self.status, self.words = status, words
        super().__init__(reason)


@contextmanager
def run(path: str, arguments: Sequence[str], seconds: float) -> Iterator[Devtools]:
    """A browser that has answered within `seconds`; it and its folder are gone afterwards.

    Raises:
        LostRunError: it does not start, or is lost inside the block.
        OSError: this machine has no file or process left for it.
    """
    with (
        tempfile.TemporaryFile() as words,
        _pipe() as (commands, write),
        _pipe() as (read, answers),
        _pipe() as (leash, hold),
    ):
        ends = (leash.fileno(), commands.fileno(), answers.fileno())
        process = subprocess.Popen(
            [
                *(sys.executable, "-I", "-S", keeper.__file__),
                *(*map(str, ends), str(GRACE), tempfile.gettempdir(), path, *arguments, PIPE),
            ],
            pass_fds=ends,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=words,
            start_new_session=True,
        )
        try:
            for end in (leash, commands, answers):
                end.close()
            devtools = Devtools(read.fileno(), write.fileno(), stage="starting", until=monotonic() + seconds)
            devtools.call("Browser.getVersion")
            yield devtools
            devtools.tell("Browser.close")
        except LostError as lost:
            status = _status(process) if lost.ended else None
            if status is not None:
                reason = f"ended {lost} with exit status {_readable(status)}"
            else:
                reason = f"closed its pipe {lost}" if lost.ended else str(lost)
            raise LostRunError(reason, status, _tail(words)) from lost
        finally:
            write.close()
            with contextlib.suppress(OSError):
                hold.write(b".")  # closing would do if no process were ever forked off with a copy of this end
            hold.close()
            try:
                process.wait(GRACE + TIDYING)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


@contextmanager
def _pipe() -> Iterator[tuple[IO[bytes], IO[bytes]]]:
    read, write = os.pipe()
    with open(read, "rb", buffering=0) as reader, open(write, "wb", buffering=0) as writer:
        yield reader, writer


def _status(process: subprocess.Popen[bytes]) -> int | None:
    """What the keeper says of a browser whose pipe is closed; None where the browser goes on without it."""
    try:
        return process.wait(ENDING)
    except subprocess.TimeoutExpired:
        return None


def _readable(status: int) -> str:
    """`134 (SIGABRT)`."""
    number = status - 128 if status > 128 else -status
    try:
        return f"{status} ({signal.Signals(number).name})"
    except ValueError:
        return str(status)


def _tail(words: IO[bytes]) -> str:
    """The last lines written, blank ones left out."""
    size = words.seek(0, os.SEEK_END)
    words.seek(max(0, size - WORDS_BYTES))
    lines = words.read().decode(errors="replace").splitlines()
    return "\n".join([line.rstrip() for line in lines if line.strip()][-WORDS_LINES:])
