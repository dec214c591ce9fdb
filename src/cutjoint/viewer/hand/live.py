"""The live viewer: a page with the robot beside a control panel, kept in step with one `Puppet`.

Three threads: the caller's, the server's (`Bridge`), and one that alone touches the robot, so that a long search does
not keep the page from loading.  Commands of the page wait in a short queue; when the same tab moves the same slider
again, the older value is forgotten.
"""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, TypeGuard, get_args

import numpy as np

from cutjoint.chain import ClosedChain
from cutjoint.errors import CutjointError
from cutjoint.reprs import line
from cutjoint.viewer.hand.panel import ControlPanel
from cutjoint.viewer.hand.puppet import Puppet
from cutjoint.viewer.hand.quoting import as_python, as_toml
from cutjoint.viewer.picture.figure import Figure
from cutjoint.viewer.picture.places import Places, show_places
from cutjoint.viewer.server.addresses import LOOPBACK, PORT
from cutjoint.viewer.server.assets import live_files
from cutjoint.viewer.server.bridge import Bridge
from cutjoint.viewer.server.tabs import Message

Kind = Literal["actuated", "tool", "drag", "mode", "modes", "home", "toml", "python"]
KINDS: tuple[Kind, ...] = get_args(Kind)
LARGEST = 1e6
WORKSPACE = "Workspace box"
WAITING = 64
QUIET = 1.0
"""The workspace is sampled only when nothing was asked for this long [s]."""

FIRST_SAMPLES = 8


@dataclass(frozen=True)
class Command:
    """What the page asks for; `number` is the page's own count, given back with the answer.

    `index` and `value` are those of a slider or a mode, `point` [m] in the world is where the tool is dragged to.
    """

    tab: int
    number: int
    kind: Kind
    index: int = 0
    value: float = 0.0
    point: tuple[float, ...] = ()


def parse(tab: int, message: Message) -> Command | None:
    """A message of the page as a command, None where it makes no sense."""
    kind, number, index = message.get("move"), message.get("number"), message.get("index", 0)
    value, point = message.get("value", 0.0), message.get("point", [])
    if kind not in KINDS or not (_is_count(number) and _is_count(index)):
        return None
    if not _is_number(value) or set(message) - {"move", "number", "index", "value", "point"}:
        return None
    if not isinstance(point, list) or len(point) != (3 if kind == "drag" else 0) or not all(map(_is_number, point)):
        return None
    return Command(tab, number, kind, index, float(value), tuple(map(float, point)))


class LiveView:
    """Serves the robot, with `places` beside it, until `stop()`.

    Raises:
        ViewerError: no port is free.
    """

    __repr__ = line("url")

    def __init__(
        self, chain: ClosedChain, *, host: str = LOOPBACK, port: int = PORT, places: Places | None = None
    ) -> None:
        self.figure = Figure(chain, chain.home, beside=None if places is None else places.all_points)
        if places is not None:
            show_places(self.figure, places)
        self.puppet = Puppet(chain, self.figure.radius)
        self.panel = ControlPanel(self.puppet, self.figure)
        self._session = secrets.token_hex(8)
        self._queue: list[Command] = []
        self._wake = threading.Condition()
        self._stopped = False
        self._sampler = self.puppet.sample_workspace()
        self._controls, self._state = self.panel.controls(), self.panel.state()
        self.bridge = Bridge(
            live_files(), self.figure.scene, handler=self._take, greeting=self._greet, host=host, port=port
        )
        self._worker = threading.Thread(target=self._work, name="cutjoint-robot", daemon=True)
        self._worker.start()

    @property
    def url(self) -> str:
        """Address of the page."""
        return self.bridge.url

    def wait(self) -> None:
        """Block until interrupted or stopped."""
        self.bridge.wait()

    def stop(self) -> None:
        """Close the port and end both threads."""
        with self._wake:
            self._stopped = True
            self._wake.notify()
        self.bridge.stop()
        self._worker.join(5.0)

    def __enter__(self) -> LiveView:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def _greet(self, tab: int) -> list[Message]:
        return [{"type": "hello", "tab": tab, "session": self._session}, self._controls, self._state]

    def _take(self, tab: int, message: Message) -> bool:
        command = parse(tab, message)
        if command is None:
            return False
        with self._wake:
            same = [c for c in self._queue if (c.tab, c.kind, c.index) == (tab, command.kind, command.index)]
            for older in same:
                self._queue.remove(older)
            if len(self._queue) < WAITING:
                self._queue.append(command)
            self._wake.notify()
        return True

    def _work(self) -> None:
        """Obey commands; in quiet moments, sample the workspace."""
        samples, quiet_from = 0, 0.0
        sampler: Iterator[bool] | None = self._sampler
        while True:
            with self._wake:
                while not self._queue and not self._stopped and (sampler is None or time.monotonic() < quiet_from):
                    self._wake.wait(None if sampler is None else max(quiet_from - time.monotonic(), 0.0))
                if self._stopped:
                    return
                command = self._queue.pop(0) if self._queue else None
            if command is not None:
                self._obey(command)
                quiet_from = time.monotonic() + QUIET
            elif sampler is not None:
                samples += 1
                if next(sampler, None) is None:
                    sampler = None
                if sampler is None or samples == FIRST_SAMPLES:
                    self._publish_workspace()

    def _obey(self, command: Command) -> None:
        puppet, trouble, text = self.puppet, "", ""
        try:
            match command.kind:
                case "actuated":
                    puppet.actuate(command.index, command.value)
                case "tool":
                    puppet.pull(command.index, command.value)
                case "drag":
                    puppet.drag(np.array(command.point))
                case "mode":
                    puppet.choose(command.index)
                case "home":
                    puppet.go_home()
                case "modes":
                    puppet.find_modes()
                    self._publish_controls()
                case "toml":
                    text = as_toml(puppet.chain, puppet.at)
                case "python":
                    text = as_python(puppet.chain, puppet.at)
            self.figure.pose(puppet.at)
            self._state = self.panel.state()
        except CutjointError as error:
            trouble = str(error)
        answer = {"tab": command.tab, "number": command.number, "trouble": trouble, "text": text}
        self.bridge.broadcast({**self._state, "answer": answer})

    def _publish_workspace(self) -> None:
        box = self.puppet.workspace.box
        if box is not None and (box[0] < box[1]).any():
            self.figure.show_box(WORKSPACE, box[0], box[1])
            self._publish_controls()

    def _publish_controls(self) -> None:
        self._controls = self.panel.controls()
        self.bridge.broadcast(self._controls)


def _is_count(value: object) -> TypeGuard[int]:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**53


def _is_number(value: object) -> TypeGuard[int | float]:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST
