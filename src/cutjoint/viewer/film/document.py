"""A scene as one page that needs nothing else: meshcat's bundle, our player and the data, in one file.

The page's content security policy names its own scripts by their hashes and forbids every connection, so the file
makes no network request and runs nothing else, wherever it is opened.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
import os
from collections.abc import Mapping
from pathlib import Path

from cutjoint.errors import ViewerError
from cutjoint.files import write_files
from cutjoint.reprs import one_line, quoted
from cutjoint.viewer.browser.camera import photograph
from cutjoint.viewer.picture.scene import Scene, pack
from cutjoint.viewer.server.assets import File, bundle, page


class Document:
    """A page with a scene and the data of its player.

    In Jupyter it shows itself; `save` writes the file, `picture` a PNG.
    """

    def __init__(self, scene: Scene, data: Mapping[str, object]) -> None:
        self._scene = scene
        self._data = dict(data)

    def __repr__(self) -> str:
        return one_line("Document", [quoted(str(self._data.get("title", "cutjoint")))])

    @property
    def html(self) -> str:
        """The whole page."""
        scripts = [page("look.js"), bundle(), page("curves.js"), page("stage.js"), page("play.js")]
        hashes = " ".join(f"'sha256-{_digest(script)}'" for script in scripts)
        policy = (
            f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; img-src data: blob:; "
            "base-uri 'none'; form-action 'none'"
        )
        parts = {
            "policy": html.escape(policy),
            "title": html.escape(str(self._data.get("title", "cutjoint"))),
            "style": page("page.css"),
            "scene": base64.b64encode(pack(self._scene.messages())).decode(),
            "data": json.dumps(self._data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"),
            "scripts": "\n".join(f"<script>{script}</script>" for script in scripts),
        }
        text = page("play.html")
        for name, part in parts.items():
            head, _, tail = text.partition(f"{{{{{name}}}}}")
            text = head + part + tail
        return text

    def files(self) -> dict[str, File]:
        """For a `Bridge`: the page at `/`, under its own policy."""
        policy = "frame-ancestors 'none'"
        return {
            "/": File(self.html.encode(), "text/html; charset=utf-8", policy),
            "/favicon.ico": File(b"", "image/x-icon"),
        }

    def save(self, path: str | os.PathLike[str]) -> int:
        """Write the page to `path`, whole or not at all; returns its size [bytes].

        Raises:
            ViewerError: it cannot be written there.
        """
        return _write(path, self.html.encode())

    def picture(self, path: str | os.PathLike[str], *, time: float = 0.0, width: int = 1280, height: int = 800) -> int:
        """Write a PNG of the scene at `time` [s] to `path`, through a headless browser; returns its size [bytes].

        Raises:
            ViewerError: no browser is found, it does not answer in time, or the file cannot be written.
        """
        return _write(path, photograph(self.files(), time=time, width=width, height=height))

    def _repr_html_(self) -> str:
        frame = html.escape(self.html, quote=True)
        return (
            f'<iframe srcdoc="{frame}" style="width: 100%; height: 480px; border: 0" sandbox="allow-scripts"></iframe>'
        )


def _write(path: str | os.PathLike[str], content: bytes) -> int:
    """Write `content` to `path`; its size [bytes]."""
    try:
        write_files({Path(path): content})
    except OSError as error:
        raise ViewerError(f"cannot write {path}: {error.strerror or error}") from error
    return len(content)


def _digest(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
