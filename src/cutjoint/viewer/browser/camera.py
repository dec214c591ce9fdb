"""Pictures without a screen: a Chromium found on this machine draws a page.

A run of the browser that comes to nothing (it ends, hangs or talks nonsense) is followed by another with a fresh
profile.  Only the standard library is used.
"""

from __future__ import annotations

import base64
import os
import shutil
import sys
from collections.abc import Mapping
from time import monotonic

from cutjoint.errors import BrowserError, InputError, ViewerError
from cutjoint.viewer.browser.devtools import Devtools, LostError
from cutjoint.viewer.server.assets import File
from cutjoint.viewer.server.bridge import Bridge

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
"""For a picture, all starts together."""
STARTS = 3
START_SECONDS = 15.0
"""For the first answer of a browser, which comes after half a second on a machine at leisure."""
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


def photograph(files: Mapping[str, File], *, time: float = 0.0, width: int = 1280, height: int = 800) -> bytes:
    """A PNG of the page that `files` hold, its scene at `time` [s].

    Raises:
        InputError: a size that is not between 16 and 8192 pixels, or a time that is not finite and >= 0.
        ViewerError: no browser is found, or this system cannot run one.
        BrowserError: three runs of the browser, or as many as a minute allows, gave no picture.
    """
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
    if os.name != "posix":
        raise ViewerError("pictures need a POSIX system; write an HTML file instead")
    try:
        return _with_fresh_starts(path, files, time, width, height)
    except OSError as error:
        raise ViewerError(f"the browser {path} cannot be started: {error}") from error


def _with_fresh_starts(path: str, files: Mapping[str, File], time: float, width: int, height: int) -> bytes:
    from cutjoint.viewer.browser.headless import LostRunError, run

    until = monotonic() + SECONDS
    arguments = [*flags(), f"--window-size={width},{height}"]
    with Bridge(files, port=0) as bridge:
        url = f"{bridge.url}#picture&time={time!r}"
        start = 0
        while True:
            start += 1
            try:
                with run(path, arguments, min(START_SECONDS, until - monotonic())) as browser:
                    browser.until = until
                    return _picture(browser, url, width, height)
            except LostRunError as lost:
                if start == STARTS or monotonic() >= until:
                    often = f" (start {start} of {STARTS})" if start > 1 else ""
                    words = f"; its last words:\n{lost.words}" if lost.words else ""
                    message = f"no picture: the browser {path} {lost}{often}{words}"
                    raise BrowserError(message, starts=start, status=lost.status, words=lost.words) from lost


PNG = b"\x89PNG\r\n\x1a\n"
READY = "document.documentElement.dataset.ready === 'yes'"


def _picture(browser: Devtools, url: str, width: int, height: int) -> bytes:
    browser.stage = "opening the page"
    target = browser.text("targetId", "Target.createTarget", url="about:blank")
    session = browser.text("sessionId", "Target.attachToTarget", targetId=target, flatten=True)
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    browser.call("Emulation.setDeviceMetricsOverride", session, **size)
    opened = browser.call("Page.navigate", session, url=url)
    if "errorText" in opened:
        raise LostError(f"could not open the page: {opened['errorText']}")
    browser.stage = "drawing the page"
    while not _true(browser.call("Runtime.evaluate", session, expression=READY)):
        browser.rest(0.05)
    browser.stage = "taking the picture"
    try:
        picture = base64.b64decode(browser.text("data", "Page.captureScreenshot", session, format="png"))
    except ValueError:
        picture = b""
    if not picture.startswith(PNG):
        raise LostError("gave something else than a PNG")
    return picture


def _true(answer: Mapping[str, object]) -> bool:
    result = answer.get("result")
    return isinstance(result, dict) and result.get("value") is True
