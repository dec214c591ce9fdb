"""HTTP and websocket server of the viewer, in a thread of this process.

It stands in for meshcat's own server, which listens on every interface, shows the scene to anyone and takes messages
from anyone.  This one listens on one address (the loopback one unless told otherwise), serves a fixed set of files
from memory, and answers only requests whose Host names this server and, for websockets, whose Origin is its own page.
Nothing that comes in is executed: a tab may send short JSON texts, which are counted, bounded and parsed by the owner.
There is no other process and no other port, so nothing survives the program, whatever ends it.
"""

from __future__ import annotations

import asyncio
import json
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from tornado.httpserver import HTTPServer
from tornado.web import Application, HTTPError, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from cutjoint.errors import ViewerError
from cutjoint.viewer.picture.scene import Scene
from cutjoint.viewer.server.addresses import LOOPBACK, PORT, bind, is_address, is_loopback, own_names, url_of

TABS = 16
MESSAGE_BYTES = 2048
MESSAGES_PER_SECOND = 200.0
GARBAGE_ALLOWED = 50
BATCHES_WAITING = 256
START_SECONDS = 10.0
STOP_SECONDS = 5.0

Handler = Callable[[int, dict[str, Any]], bool]
"""Called in the server's thread with a tab's number and the message; returns whether the message made sense.  It must
return at once: long work belongs to another thread."""


@dataclass(frozen=True)
class File:
    """What one path answers; `policy` is its content security policy, in which `{host}` becomes this server."""

    body: bytes
    kind: str
    policy: str = "default-src 'none'"


class Bridge:
    """Serves `files` and keeps the tabs that open the websocket in step with `scene`.

    `port` is the first one tried; 0 lets the system choose.  `greeting` makes the JSON that a new tab gets after the
    scene, from the tab's number.

    Raises:
        ViewerError: no port is free, or the address is not one of this machine.
    """

    def __init__(
        self,
        files: Mapping[str, File],
        scene: Scene | None = None,
        *,
        handler: Handler | None = None,
        greeting: Callable[[int], list[Mapping[str, Any]]] | None = None,
        host: str = LOOPBACK,
        port: int = PORT,
    ) -> None:
        self._files = dict(files)
        self._scene = scene
        self._handler = handler
        self._greeting = greeting
        self._tabs: set[_Tab] = set()
        self._tab_came = threading.Event()
        self._numbers = iter(range(1, 1 << 62))
        self._loop = asyncio.new_event_loop()
        self._ending = asyncio.Event()
        self._sockets, self.port = bind(host, port)
        self.host = host
        self._names = own_names(host)
        self.url = url_of(host, self.port)
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._run, name="cutjoint-viewer", daemon=True)
        self._thread.start()
        if not self._ready.wait(START_SECONDS):
            raise ViewerError(f"the viewer's server did not start within {START_SECONDS:g} s")
        if scene is not None:
            scene.listener = self._send_scene

    @property
    def open_to_others(self) -> bool:
        """Whether other machines can reach it."""
        return not is_loopback(self.host)

    @property
    def tabs(self) -> int:
        """Number of connected tabs."""
        return len(self._tabs)

    def wait_for_tab(self, seconds: float) -> None:
        """Block until a tab has connected.

        Raises:
            ViewerError: none did in time.
        """
        if not self._tab_came.wait(seconds):
            raise ViewerError(f"no browser opened {self.url} within {seconds:g} s; open that address in one")

    def wait(self) -> None:
        """Block until `stop()`, or an interrupt, in short waits so that signals get through."""
        while self._thread.is_alive():
            self._thread.join(0.2)

    def broadcast(self, message: Mapping[str, Any]) -> None:
        """Send a JSON message to every tab (from any thread)."""
        text = json.dumps(message, allow_nan=False)
        self._call(lambda: self._to_all(text))

    def stop(self) -> None:
        """Close tabs and port.  Harmless when already stopped."""
        if self._scene is not None:
            self._scene.listener = None
        self._call(self._ending.set)
        self._thread.join(STOP_SECONDS)

    def __enter__(self) -> Bridge:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def allows_host(self, host: str) -> bool:
        """Whether a Host header names this server (a foreign name means a page that rebound its DNS name to us)."""
        name, _, port = host.rpartition(":")
        if not name or not port.isascii() or not port.isdigit() or int(port) != self.port:
            return False
        return name.lower() in self._names or (self.open_to_others and is_address(name))

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        server = HTTPServer(
            self._application(),
            max_header_size=16 * 1024,
            max_body_size=1024,
            idle_connection_timeout=30,
            body_timeout=5,
        )

        async def serve() -> None:
            server.add_sockets(self._sockets)
            self._ready.set()
            await self._ending.wait()

        try:
            self._loop.run_until_complete(serve())
        finally:
            server.stop()
            for tab in tuple(self._tabs):
                tab.close(1001)
            self._loop.run_until_complete(asyncio.wait_for(server.close_all_connections(), STOP_SECONDS))
            for task in asyncio.all_tasks(self._loop):
                task.cancel()
            self._loop.run_until_complete(asyncio.sleep(0))
            self._loop.close()

    def _application(self) -> Application:
        routes: list[Any] = [(r"/.*", _Page, {"bridge": self})]
        if self._scene is not None:
            routes.insert(0, (r"/scene", _Tab, {"bridge": self}))
        return Application(
            routes,
            websocket_max_message_size=MESSAGE_BYTES,
            websocket_ping_interval=20,
            websocket_ping_timeout=15,
            log_function=lambda handler: None,
        )

    def _call(self, action: Callable[[], Any]) -> None:
        try:
            self._loop.call_soon_threadsafe(action)
        except RuntimeError:
            return  # the loop is closed: there is nobody to tell

    def _send_scene(self, messages: list[bytes]) -> None:
        frame = pack(messages)
        self._call(lambda: self._to_all(frame))

    def _to_all(self, message: str | bytes) -> None:
        for tab in tuple(self._tabs):
            tab.enqueue(message)

    def file(self, path: str) -> File | None:
        """What `path` answers."""
        return self._files.get(path)

    def enter(self, tab: _Tab) -> None:
        """A tab connected: give it the scene as it is now, then the greeting."""
        if len(self._tabs) >= TABS:
            tab.close(1013, f"more than {TABS} tabs")
            return
        tab.number = next(self._numbers)
        if self._scene is not None:
            tab.enqueue(pack(list(self._scene.messages())))
        for message in self._greeting(tab.number) if self._greeting else []:
            tab.enqueue(json.dumps(message, allow_nan=False))
        self._tabs.add(tab)
        self._tab_came.set()

    def leave(self, tab: _Tab) -> None:
        """A tab is gone."""
        self._tabs.discard(tab)

    def receive(self, tab: _Tab, text: str) -> bool:
        """A message of a tab; returns whether it made sense."""
        try:
            message = json.loads(text)
        except (ValueError, RecursionError):
            return False
        if not isinstance(message, dict) or self._handler is None:
            return False
        return self._handler(tab.number, message)


class _Guarded(RequestHandler):  # type: ignore[misc]
    """Refuses a foreign Host, and sends the headers that keep the page to itself."""

    def initialize(self, bridge: Bridge) -> None:
        self.bridge = bridge

    def set_default_headers(self) -> None:
        self.clear_header("Server")
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("Cross-Origin-Resource-Policy", "same-origin")
        self.set_header("Cache-Control", "no-store")

    def prepare(self) -> None:
        if not self.bridge.allows_host(self.request.host):
            raise HTTPError(403)

    def write_error(self, status_code: int, **_: Any) -> None:
        self.set_header("Content-Type", "text/plain")
        self.finish(f"{status_code}\n")


class _Page(_Guarded):
    def get(self) -> None:
        file = self.bridge.file(self.request.path)
        if file is None:
            raise HTTPError(404)
        self.set_header("Content-Type", file.kind)
        self.set_header("Content-Security-Policy", file.policy.replace("{host}", self.request.host))
        self.write(file.body)

    head = get


class _Tab(_Guarded, WebSocketHandler):  # type: ignore[misc]
    """A browser tab's websocket."""

    number = 0

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
        self.bridge.enter(self)

    def enqueue(self, message: str | bytes) -> None:
        """Send when the tab can take it; a tab that falls far behind is closed, and starts afresh when it is back."""
        try:
            self._waiting.put_nowait(message)
        except asyncio.QueueFull:
            self.bridge.leave(self)
            self.close(1013, "too slow")

    async def _send(self) -> None:
        try:
            while True:
                message = await self._waiting.get()
                await self.write_message(message, binary=isinstance(message, bytes))
        except (WebSocketClosedError, asyncio.CancelledError):
            self.bridge.leave(self)

    def on_message(self, message: str | bytes) -> None:
        now = time.monotonic()
        self._credit = min(MESSAGES_PER_SECOND, self._credit + MESSAGES_PER_SECOND * (now - self._credited))
        self._credited = now
        self._credit -= 1.0
        sensible = self._credit >= 0 and isinstance(message, str) and self.bridge.receive(self, message)
        if not sensible:
            self._garbage += 1
            if self._garbage > GARBAGE_ALLOWED:
                self.close(1008, "not understood")

    def on_close(self) -> None:
        self.bridge.leave(self)
        if hasattr(self, "_sender"):
            self._sender.cancel()


def pack(messages: list[bytes]) -> bytes:
    """Several scene messages as one websocket frame: each with its length (4 bytes, little-endian) before it."""
    return b"".join(len(message).to_bytes(4, "little") + message for message in messages)
