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
from collections.abc import Callable, Mapping

from tornado.httpserver import HTTPServer
from tornado.web import Application

from cutjoint import interrupts
from cutjoint.errors import ViewerError
from cutjoint.reprs import line
from cutjoint.viewer.picture.scene import Scene, pack
from cutjoint.viewer.server.addresses import LOOPBACK, PORT, Address, bind
from cutjoint.viewer.server.assets import File
from cutjoint.viewer.server.tabs import MESSAGE_BYTES, Greeting, Handler, Message, Page, Tab, Tabs

START_SECONDS = 10.0
STOP_SECONDS = 5.0


class Bridge:
    """Serves `files` and keeps the tabs that open the websocket in step with `scene`.

    `port` is the first one tried; 0 lets the system choose.

    Attributes:
        host, port, url: where it listens.
        open_to_others: whether other machines can reach it.

    Raises:
        ViewerError: no port is free, or the address is not one of this machine.
    """

    __repr__ = line("url")

    def __init__(
        self,
        files: Mapping[str, File],
        scene: Scene | None = None,
        *,
        handler: Handler | None = None,
        greeting: Greeting | None = None,
        host: str = LOOPBACK,
        port: int = PORT,
    ) -> None:
        self._files = dict(files)
        self._scene = scene
        self._tabs = Tabs(scene, handler, greeting)
        self._loop = asyncio.new_event_loop()
        self._ending = asyncio.Event()
        self._sockets, self.port = bind(host, port)
        self.host = host
        self._address = Address(host, self.port)
        self.url, self.open_to_others = self._address.url, self._address.open_to_others
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._run, name="cutjoint-viewer", daemon=True)
        self._thread.start()
        if not self._ready.wait(START_SECONDS):
            raise ViewerError(f"the viewer's server did not start within {START_SECONDS:g} s")
        if scene is not None:
            scene.listener = self._send_scene

    @property
    def tabs(self) -> int:
        """Number of connected tabs."""
        return len(self._tabs)

    def wait_for_tab(self, seconds: float) -> None:
        """Block until a tab has connected.

        Raises:
            ViewerError: none did in time.
        """
        if not self._tabs.came.wait(seconds):
            raise ViewerError(f"no browser opened {self.url} within {seconds:g} s; open that address in one")

    def wait(self) -> None:
        """Block until `stop()`, or an interrupt, in short waits so that signals get through."""
        while self._thread.is_alive():
            self._thread.join(0.2)
            interrupts.check()

    def broadcast(self, message: Message) -> None:
        """Send a JSON message to every tab (from any thread)."""
        text = json.dumps(message, allow_nan=False)
        self._call(lambda: self._tabs.send(text))

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
            self._tabs.close()
            self._loop.run_until_complete(asyncio.wait_for(server.close_all_connections(), STOP_SECONDS))
            for task in asyncio.all_tasks(self._loop):
                task.cancel()
            self._loop.run_until_complete(asyncio.sleep(0))
            self._loop.close()

    def _application(self) -> Application:
        tab = (r"/scene", Tab, {"address": self._address, "tabs": self._tabs})
        page = (r"/.*", Page, {"address": self._address, "files": self._files})
        return Application(
            [page] if self._scene is None else [tab, page],
            websocket_max_message_size=MESSAGE_BYTES,
            websocket_ping_interval=20,
            websocket_ping_timeout=15,
            log_function=lambda handler: None,
        )

    def _call(self, action: Callable[[], object]) -> None:
        try:
            self._loop.call_soon_threadsafe(action)
        except RuntimeError:
            return  # the loop is closed: there is nobody to tell

    def _send_scene(self, messages: list[bytes]) -> None:
        frame = pack(messages)
        self._call(lambda: self._tabs.send(frame))
