"""Pictures without a screen: a Chromium found on this machine, run headless and steered over a pipe.

The pipe (`--remote-debugging-pipe`) opens no port, and the browser ends by itself when the pipe breaks, so none is
left behind even if this program is killed.  Only the standard library is used.
"""

from __future__ import annotations

import base64
import contextlib
import json
import os
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from cutjoint.errors import InputError, ViewerError

if TYPE_CHECKING:
    from cutjoint.viewer.document import Document

VARIABLE = "CUTJOINT_BROWSER"
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge", "msedge")
MAC = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
)
FLAGS = (
    "--headless=new",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-default-apps",
    "--disable-extensions",
    "--disable-quic",
    "--disable-sync",
    "--hide-scrollbars",
    "--mute-audio",
    "--no-default-browser-check",
    "--no-first-run",
)
SECONDS = 60.0
GRACE = 2.0
LARGEST = 8192


def find_browser() -> str | None:
    """Path of a Chromium: what CUTJOINT_BROWSER names, else the first one on the path; None where there is none."""
    named = os.environ.get(VARIABLE)
    if named:
        return shutil.which(named)
    for name in NAMES:
        if found := shutil.which(name):
            return found
    return next((path for path in MAC if os.access(path, os.X_OK)), None)


def flags() -> list[str]:
    """Command-line switches for a headless run; without the sandbox only for root, who cannot have it."""
    root = sys.platform.startswith("linux") and os.geteuid() == 0
    return [*FLAGS, *(["--no-sandbox"] if root else [])]


def photograph(document: Document, *, time: float = 0.0, width: int = 1280, height: int = 800) -> bytes:
    """A PNG of the document's scene at `time` [s].

    Raises:
        InputError: a size that is not between 16 and 8192 pixels, or a time that is not finite and >= 0.
        ViewerError: no browser, or it does not answer within a minute.
    """
    from cutjoint.viewer.bridge import Bridge

    if not (16 <= width <= LARGEST and 16 <= height <= LARGEST):
        raise InputError(f"a picture has 16 to {LARGEST} pixels a side, found {width} x {height}")
    if not 0.0 <= time < float("inf"):
        raise InputError(f"the time of a picture is a finite number >= 0 s, found {time}")
    path = find_browser()
    if path is None:
        raise ViewerError(
            f"no browser found for a picture; install Chromium or Chrome, or name one in {VARIABLE} "
            "(an HTML file needs none)"
        )
    with Bridge(document.files(), port=0) as bridge, _browser(path, width, height) as browser:
        target = browser.call("Target.createTarget", url="about:blank")["targetId"]
        session = browser.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        browser.call("Emulation.setDeviceMetricsOverride", session, **size)
        browser.call("Page.navigate", session, url=f"{bridge.url}#picture&time={time!r}")
        while not browser.call("Runtime.evaluate", session, expression=_READY)["result"].get("value"):
            browser.rest(0.05)
        shot = browser.call("Page.captureScreenshot", session, format="png")
        browser.call("Browser.close")
        return base64.b64decode(shot["data"])


PIPE = "--remote-debugging-pipe"
# The browser reads its commands from file 3 and answers on file 4.
_START = (
    "import fcntl, os, sys; ends = [fcntl.fcntl(int(end), fcntl.F_DUPFD, 10) for end in sys.argv[1:3]]; "
    "os.dup2(ends[0], 3); os.dup2(ends[1], 4); os.execv(sys.argv[3], sys.argv[3:])"
)
_READY = "document.documentElement.dataset.ready === 'yes'"


class _Browser:
    """DevTools protocol over a pair of pipes: JSON texts that end in a zero byte."""

    def __init__(self, process: subprocess.Popen[bytes], read: int, write: int) -> None:
        self._process, self._read, self._write = process, read, write
        self._until = time.monotonic() + SECONDS
        self._number = 0
        self._rest = b""

    def call(self, method: str, session: str | None = None, /, **parameters: Any) -> dict[str, Any]:
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if session is not None:
            message["sessionId"] = session
        try:
            os.write(self._write, json.dumps(message).encode() + b"\0")
        except OSError as error:
            raise ViewerError(f"the browser ended: {error}") from error
        while True:
            answer = self._receive()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise ViewerError(f"the browser refused {method}: {answer['error'].get('message')}")
                result: dict[str, Any] = answer["result"]
                return result

    def rest(self, seconds: float) -> None:
        time.sleep(seconds)
        if time.monotonic() > self._until:
            raise ViewerError(f"the page was not drawn within {SECONDS:g} s")

    def _receive(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            left = self._until - time.monotonic()
            if left <= 0 or not select.select([self._read], [], [], left)[0]:
                raise ViewerError(f"the browser did not answer within {SECONDS:g} s")
            piece = os.read(self._read, 1 << 20)
            if not piece:
                raise ViewerError(f"the browser ended with status {self._process.poll()} before the picture was taken")
            self._rest += piece
        text, _, self._rest = self._rest.partition(b"\0")
        answer: dict[str, Any] = json.loads(text)
        return answer


@contextmanager
def _browser(path: str, width: int, height: int) -> Iterator[_Browser]:
    """A headless browser with a profile of its own; it and the profile are gone afterwards."""
    if os.name != "posix":
        raise ViewerError("pictures need a POSIX system; write an HTML file instead")
    profile = tempfile.mkdtemp(prefix="cutjoint-browser-")
    to_child, write = os.pipe()
    read, from_child = os.pipe()
    command = [path, *flags(), f"--user-data-dir={profile}", f"--window-size={width},{height}", PIPE]
    process: subprocess.Popen[bytes] | None = None
    try:
        process = subprocess.Popen(
            [sys.executable, "-I", "-S", "-c", _START, str(to_child), str(from_child), *command],
            pass_fds=(to_child, from_child),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        os.close(to_child)
        os.close(from_child)
        yield _Browser(process, read, write)
    except OSError as error:
        raise ViewerError(f"the browser {path} does not start: {error}") from error
    finally:
        os.close(read)
        os.close(write)
        if process is not None:
            _end(process)
        shutil.rmtree(profile, ignore_errors=True)


def _end(process: subprocess.Popen[bytes]) -> None:
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(GRACE)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait(5.0)
