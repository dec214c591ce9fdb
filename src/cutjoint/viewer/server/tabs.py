"""What the server answers, and only to those who call it by one of its names: a fixed set of files, and the browser
tabs that hold the scene, each of which gets every change of it and may send short JSON texts.

A tab is closed where it falls far behind, floods or talks nonsense; it starts afresh when it is back.
"""

from __future__ import annotations

import asyncio
import json
import threading
import time
from collections.abc import Callable, Mapping, Sequence

from tornado.web import HTTPError, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from cutjoint.viewer.picture.scene import Scene, pack
from cutjoint.viewer.server.addresses import Address
from cutjoint.viewer.server.assets import File


class Guarded(RequestHandler):  # type: ignore[misc]
    """Refuses a foreign Host, and sends the headers that keep the page to itself."""

    address: Address

    def set_default_headers(self) -> None:
        self.clear_header("Server")
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("Cross-Origin-Resource-Policy", "same-origin")
        self.set_header("Cache-Control", "no-store")

    def prepare(self) -> None:
        if not self.address.allows(self.request.host):
            raise HTTPError(403)

    def write_error(self, status_code: int, **_: object) -> None:
        self.set_header("Content-Type", "text/plain")
        self.finish(f"{status_code}\n")


class Page(Guarded):
    """A fixed file from memory."""

    def initialize(self, address: Address, files: Mapping[str, File]) -> None:
        self.address, self.files = address, files

    def get(self) -> None:
        file = self.files.get(self.request.path)
        if file is None:
            raise HTTPError(404)
        self.set_header("Content-Type", file.kind)
        self.set_header("Content-Security-Policy", file.policy.replace("{host}", self.request.host))
        self.write(file.body)

    head = get


TABS = 16
MESSAGE_BYTES = 2048
MESSAGES_PER_SECOND = 200.0
GARBAGE_ALLOWED = 50
BATCHES_WAITING = 256

Message = Mapping[str, object]
"""A JSON object, from a tab or for it."""

Handler = Callable[[int, Message], bool]
"""Called in the server's thread with a tab's number and the message; returns whether the message made sense.  It must
return at once: long work belongs to another thread."""

Greeting = Callable[[int], Sequence[Message]]
"""What a new tab gets after the scene, from the tab's number."""


class Tabs:
    """The tabs that are connected.  All but `came` and the length belong to the server's thread.

    Attributes:
        came: set once a tab has connected.
    """

    def __init__(self, scene: Scene | None, handler: Handler | None, greeting: Greeting | None) -> None:
        self.came = threading.Event()
        self._scene, self._handler, self._greeting = scene, handler, greeting
        self._tabs: set[Tab] = set()
        self._numbers = iter(range(1, 1 << 62))

    def __len__(self) -> int:
        return len(self._tabs)

    def enter(self, tab: Tab) -> None:
        """A tab connected: give it the scene as it is now, then the greeting."""
        if len(self._tabs) >= TABS:
            tab.close(1013, f"more than {TABS} tabs")
            return
        tab.number = next(self._numbers)
        if self._scene is not None:
            tab.enqueue(pack(self._scene.messages()))
        for message in self._greeting(tab.number) if self._greeting else []:
            tab.enqueue(json.dumps(message, allow_nan=False))
        self._tabs.add(tab)
        self.came.set()

    def leave(self, tab: Tab) -> None:
        """A tab is gone."""
        self._tabs.discard(tab)

    def receive(self, tab: Tab, text: str) -> bool:
        """A message of a tab; returns whether it made sense."""
        try:
            message = json.loads(text)
        except (ValueError, RecursionError):
            return False
        if not isinstance(message, dict) or self._handler is None:
            return False
        return self._handler(tab.number, message)

    def send(self, message: str | bytes) -> None:
        """Send to every tab."""
        for tab in tuple(self._tabs):
            tab.enqueue(message)

    def close(self) -> None:
        """Send every tab away."""
        for tab in tuple(self._tabs):
            tab.close(1001)


class Tab(Guarded, WebSocketHandler):  # type: ignore[misc]
    """A browser tab's websocket."""

    number = 0

    def initialize(self, address: Address, tabs: Tabs) -> None:
        self.address, self.tabs = address, tabs

    def check_origin(self, origin: str) -> bool:
        return origin == f"http://{self.request.host}"

    def prepare(self) -> None:
        super().prepare()
        if not self.check_origin(self.request.headers.get("Origin", "")):
            raise HTTPError(403)

    def open(self, *_: str, **__: str) -> None:
        self._waiting: asyncio.Queue[str | bytes] = asyncio.Queue(BATCHES_WAITING)
        self._sender = asyncio.get_running_loop().create_task(self._send())
        self._credit, self._credited, self._garbage = MESSAGES_PER_SECOND, time.monotonic(), 0
        self.tabs.enter(self)

    def enqueue(self, message: str | bytes) -> None:
        """Send when the tab can take it; a tab that falls far behind is closed, and starts afresh when it is back."""
        try:
            self._waiting.put_nowait(message)
        except asyncio.QueueFull:
            self.tabs.leave(self)
            self.close(1013, "too slow")

    async def _send(self) -> None:
        try:
            while True:
                message = await self._waiting.get()
                await self.write_message(message, binary=isinstance(message, bytes))
        except (WebSocketClosedError, asyncio.CancelledError):
            self.tabs.leave(self)

    def on_message(self, message: str | bytes) -> None:
        now = time.monotonic()
        self._credit = min(MESSAGES_PER_SECOND, self._credit + MESSAGES_PER_SECOND * (now - self._credited))
        self._credited = now
        self._credit -= 1.0
        sensible = self._credit >= 0 and isinstance(message, str) and self.tabs.receive(self, message)
        if not sensible:
            self._garbage += 1
            if self._garbage > GARBAGE_ALLOWED:
                self.close(1008, "not understood")

    def on_close(self) -> None:
        self.tabs.leave(self)
        if hasattr(self, "_sender"):
            self._sender.cancel()
