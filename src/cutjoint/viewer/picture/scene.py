"""The scene as meshcat's own commands, kept by path so that a tab that connects late, or a file, gets all of it.

The messages are those of meshcat (`meshcat.commands`), packed with msgpack; meshcat's server is not used.  Only the
five commands below exist here: meshcat's `set_control`, which evaluates text in the page, cannot be expressed.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import umsgpack
from meshcat.animation import Animation
from meshcat.commands import Delete, SetAnimation, SetObject, SetProperty, SetTransform
from meshcat.geometry import Object, PerspectiveCamera
from meshcat.path import Path

from cutjoint.errors import InputError

Listener = Callable[[list[bytes]], None]


@dataclass
class _Node:
    object: bytes | None = None
    transform: bytes | None = None
    properties: dict[str, bytes] = field(default_factory=dict)


class Scene:
    """Objects, transforms and properties by path.  Safe to use from several threads.

    `listener`, if set, gets the messages of every change, or of every `batch()`, as one list.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._nodes: dict[str, _Node] = {}
        self._animation: bytes | None = None
        self._pending: list[bytes] | None = None
        self.listener: Listener | None = None

    def set_object(self, path: str, thing: Object | PerspectiveCamera) -> None:
        """Put a meshcat `Object` or camera at `path`; properties set there before are dropped, as meshcat does."""
        message = umsgpack.packb(SetObject(thing, path=_path(path)).lower())
        with self._lock:
            node = self._nodes.setdefault(path, _Node())
            node.object = message
            node.properties.clear()
            self._send(message)

    def set_transform(self, path: str, matrix: npt.ArrayLike) -> None:
        """Place `path` in its parent: (4, 4), with scale allowed.

        Raises:
            InputError: not (4, 4) or not finite (meshcat would draw nothing, silently).
        """
        placement = np.asarray(matrix, dtype=np.float64)
        if placement.shape != (4, 4) or not np.isfinite(placement).all():
            raise InputError(f"the placement of '{path}' must be a finite (4, 4) matrix, found {placement!r}")
        command = SetTransform(placement, _path(path)).lower()
        command["matrix"] = [float(value) for value in command["matrix"]]
        message = umsgpack.packb(command)
        with self._lock:
            self._nodes.setdefault(path, _Node()).transform = message
            self._send(message)

    def set_property(self, path: str, key: str, value: object) -> None:
        """Set a property of three.js at `path`.

        Raises:
            InputError: the name has capitals: meshcat sends names in lower case, so it would have no effect.
        """
        if key != key.lower():
            raise InputError(f"meshcat lower-cases property names, so '{key}' would not be found")
        message = umsgpack.packb(SetProperty(key, value, _path(path)).lower())
        with self._lock:
            self._nodes.setdefault(path, _Node()).properties[key] = message
            self._send(message)

    def set_animation(self, animation: Animation) -> None:
        """Load a meshcat `Animation` (its targets must exist already)."""
        command = SetAnimation(animation, play=True, repetitions=1).lower()
        message = umsgpack.packb(command, force_float_precision="single")
        with self._lock:
            self._animation = message
            self._send(message)

    def delete(self, path: str) -> None:
        """Remove `path` and everything below it."""
        with self._lock:
            for known in [one for one in self._nodes if one == path or one.startswith(path + "/")]:
                del self._nodes[known]
            self._send(umsgpack.packb(Delete(_path(path)).lower()))

    def paths(self) -> tuple[str, ...]:
        """All paths that hold something."""
        with self._lock:
            return tuple(self._nodes)

    def messages(self) -> Iterator[bytes]:
        """The whole scene, in an order that rebuilds it."""
        with self._lock:
            nodes = [(node.object, tuple(node.properties.values()), node.transform) for node in self._nodes.values()]
            animation = self._animation
        for thing, properties, transform in nodes:
            if thing is not None:
                yield thing
            yield from properties
            if transform is not None:
                yield transform
        if animation is not None:
            yield animation

    @contextmanager
    def batch(self) -> Iterator[None]:
        """Collect the messages of several changes, so that a picture never shows half of them."""
        with self._lock:
            if self._pending is not None:
                yield
                return
            self._pending = []
            try:
                yield
            finally:
                messages, self._pending = self._pending, None
                if messages and self.listener is not None:
                    self.listener(messages)

    def _send(self, message: bytes) -> None:
        if self._pending is not None:
            self._pending.append(message)
        elif self.listener is not None:
            self.listener([message])


def pack(messages: Iterable[bytes]) -> bytes:
    """Several messages of a scene as one: each with its length (4 bytes, little-endian) before it."""
    return b"".join(len(message).to_bytes(4, "little") + message for message in messages)


def _path(path: str) -> Path:
    return Path(tuple(part for part in path.split("/") if part))
