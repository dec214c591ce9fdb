from __future__ import annotations

import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.robots import load
from cutjoint.viewer.browser.camera import find_browser, flags
from cutjoint.viewer.browser.keeper import make_folder

ROBOTS = ("cpm", "omega3")


@cache
def chain_of(name: str) -> ClosedChain:
    return load(name)


@pytest.fixture(params=ROBOTS)
def chain(request: pytest.FixtureRequest) -> ClosedChain:
    """Each of the two robots, by its own inertias."""
    return chain_of(request.param)


@pytest.fixture
def cpm() -> ClosedChain:
    return chain_of("cpm")


@pytest.fixture(scope="session")
def chromium() -> str:
    """Path of a Chromium; tests skip where there is none."""
    path = find_browser()
    if path is None:
        pytest.skip("no Chromium on this machine (Debian: apt-get install chromium)")
    return path


@pytest.fixture(scope="session")
def browser(chromium: str) -> Iterator[Any]:
    """A headless Chromium, one for all tests; they skip where there is none."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    folder = make_folder(tempfile.gettempdir())  # Chromium aborts where TMPDIR is long
    with api.sync_playwright() as play:
        running = play.chromium.launch(executable_path=chromium, args=flags(), env={**os.environ, "TMPDIR": folder})
        yield running
        running.close()
    shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture
def short_folder() -> Iterator[Path]:
    """A temporary folder with room for a socket's path, which those of pytest have not always."""
    with tempfile.TemporaryDirectory(prefix="cj-", dir="/tmp", ignore_cleanup_errors=True) as folder:
        yield Path(folder)


def differing(a: np.ndarray[Any, Any], b: np.ndarray[Any, Any]) -> int:
    """Number of pixels that differ visibly, of pictures (height, width, 3) from 0 to 255."""
    return int((np.abs(a - b).max(axis=2) > 24).sum())


@pytest.fixture(name="differing")
def give_differing() -> Callable[..., int]:
    return differing


class Tab:
    """A page, and everything that went wrong in it."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.errors: list[str] = []
        self.requests: list[str] = []
        page.on("console", lambda message: self.errors.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("request", lambda request: self.requests.append(request.url))

    def go(self, url: str) -> None:
        self.page.goto(url)
        self.wait("document.documentElement.dataset.ready === 'yes'")

    def wait(self, expression: str, seconds: float = 60.0) -> Any:
        """The value of `expression` once it is true.  (playwright's own waiting needs eval, which the pages forbid.)"""
        from playwright.sync_api import Error

        until, value = time.monotonic() + seconds, None
        while not value:
            assert time.monotonic() < until, f"still not true after {seconds:g} s: {expression}"
            try:
                value = self.page.evaluate(expression)
            except Error as error:
                if "context was destroyed" not in str(error):  # the page reloads itself
                    raise
            self.page.wait_for_timeout(20)
        return value

    def pixels(self) -> np.ndarray[Any, Any]:
        """The 3-D scene as drawn, shape (height, width, 3), 0 to 255."""
        from PIL import Image

        self.page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        shot = self.page.locator("#pane").screenshot()
        return np.asarray(Image.open(BytesIO(shot)).convert("RGB")).astype(int)

    def changed(self, before: np.ndarray[Any, Any]) -> int:
        """Number of pixels of the scene that differ visibly from `before`."""
        return differing(self.pixels(), before)


@pytest.fixture
def open_tab(browser: Any) -> Iterator[Callable[..., Tab]]:
    """Opens tabs in a fresh context each, 780 x 420 pixels."""
    contexts = []

    def make(offline: bool = False) -> Tab:
        context = browser.new_context(viewport={"width": 780, "height": 420}, offline=offline)
        contexts.append(context)
        return Tab(context.new_page())

    yield make
    for context in contexts:
        context.close()


@pytest.fixture(autouse=True)
def no_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    """No test opens a window."""
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        if name in os.environ:
            monkeypatch.delenv(name)
