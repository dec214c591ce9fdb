"""What is in a written page of the viewer: its scene, its data, and the tracks of its animation."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import umsgpack


def scene_of(page: str) -> list[dict[str, Any]]:
    found = re.search(r'id="scene-data"[^>]*>([^<]*)<', page)
    assert found
    data, commands = base64.b64decode(found[1]), []
    while data:
        size = int.from_bytes(data[:4], "little")
        commands.append(umsgpack.unpackb(data[4 : 4 + size]))
        data = data[4 + size :]
    return commands


def data_of(page: str) -> dict[str, Any]:
    found = re.search(r'<script id="data"[^>]*>(.*?)</script>', page, re.DOTALL)
    assert found
    data: dict[str, Any] = json.loads(found[1])
    return data


def tracks_of(page: str) -> Iterator[tuple[str, str, Any]]:
    (animation,) = [c for c in scene_of(page) if c["type"] == "set_animation"]
    for clip in animation["animations"]:
        for track in clip["clip"]["tracks"]:
            width = 4 if track["name"] == ".quaternion" else 3
            yield clip["path"], track["name"], np.frombuffer(track["values"].data, "<f4").reshape(-1, width)
