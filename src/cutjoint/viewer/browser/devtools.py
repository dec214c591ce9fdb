"""Chromium's DevTools protocol over a pair of pipes: JSON texts that end in a zero byte, a question at a time."""

from __future__ import annotations

import contextlib
import json
import os
import select
from time import monotonic, sleep

ANSWER_BYTES = 1 << 29
"""The largest answer read; a picture of 8192 x 8192 pixels that nothing compresses is 0.7 of it."""


class LostError(Exception):
    """Nothing more is to be expected of this browser.

    `ended`: it closed its pipe, and the text says only while what.
    """

    def __init__(self, reason: str, *, ended: bool = False) -> None:
        self.ended = ended
        super().__init__(reason)


class Devtools:
    """The browser at the other end: reads from file `read`, writes to file `write`, waits no longer than `until`.

    `stage`, for the errors, is what the caller is doing: "while starting".  `until` is a time of the monotonic clock
    [s].  Each method raises `LostError`.
    """

    def __init__(self, read: int, write: int, *, stage: str, until: float) -> None:
        self.stage, self.until = stage, until
        self._began = monotonic()
        self._read, self._write = read, write
        self._answers = select.poll()
        self._answers.register(read, select.POLLIN)
        self._number = 0
        self._rest = bytearray()

    def call(self, method: str, session: str | None = None, /, **parameters: object) -> dict[str, object]:
        """The result of a command; events are passed over."""
        message: dict[str, object] = {"method": method, "params": parameters}
        if session is not None:
            message["sessionId"] = session
        try:
            self._send(message)
        except OSError:
            raise LostError(f"while {self.stage}", ended=True) from None
        while True:
            answer = self._receive()
            if answer.get("method") == "Inspector.targetCrashed":
                raise LostError(f"lost its page to a crash while {self.stage}")
            if answer.get("id") != self._number:
                continue
            if "error" in answer:
                raise LostError(f"refused {method} while {self.stage}: {answer['error']}")
            result = answer.get("result")
            if not isinstance(result, dict):
                raise self._nonsense(answer)
            return result

    def text(self, key: str, method: str, session: str | None = None, /, **parameters: object) -> str:
        """The entry `key` of a command's result, which has to be a text."""
        result = self.call(method, session, **parameters)
        found = result.get(key)
        if not isinstance(found, str):
            raise self._nonsense(result)
        return found

    def tell(self, method: str) -> None:
        """Send a command whose result nobody awaits; a browser that is gone already does not mind."""
        with contextlib.suppress(OSError):
            self._send({"method": method})

    def rest(self, seconds: float) -> None:
        """Wait between two questions."""
        if monotonic() + seconds > self.until:
            raise self._late()
        sleep(seconds)

    def _send(self, message: dict[str, object]) -> None:
        self._number += 1
        os.write(self._write, json.dumps({"id": self._number, **message}).encode() + b"\0")

    def _receive(self) -> dict[str, object]:
        seen = 0
        while (end := self._rest.find(0, seen)) < 0:
            seen = len(self._rest)
            left = self.until - monotonic()
            if left <= 0 or not self._answers.poll(1000 * left):
                raise self._late()
            piece = os.read(self._read, 1 << 20)
            if not piece:
                raise LostError(f"while {self.stage}", ended=True)
            self._rest += piece
            if len(self._rest) > ANSWER_BYTES:
                raise self._nonsense(bytes(self._rest[:80]))
        text = bytes(self._rest[:end])
        del self._rest[: end + 1]
        try:
            answer = json.loads(text)
        except (ValueError, RecursionError):
            raise self._nonsense(text) from None
        if not isinstance(answer, dict):
            raise self._nonsense(text)
        return answer

    def _late(self) -> LostError:
        return LostError(f"was still {self.stage} after {monotonic() - self._began:.3g} s")

    def _nonsense(self, found: object) -> LostError:
        return LostError(f"does not speak the DevTools protocol while {self.stage}: {str(found)[:80]}")
