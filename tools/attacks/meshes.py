"""Spoiled meshes: each is shown with finite corners and triangles between them, or is one InputError in time."""

from __future__ import annotations

import io
import os
import struct
import zipfile
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path

import numpy as np

from attacks.judging import Attack, Wrong
from cutjoint.description import Shape
from cutjoint.description.meshes import MOST_FACES
from cutjoint.errors import InputError
from cutjoint.viewer.picture.shapes import load_mesh

Random = np.random.Generator
SUFFIXES = (".stl", ".ascii.stl", ".obj", ".dae", ".ply", ".ascii.ply", ".off", ".glb", ".gltf", ".3mf")
WORDS = [b"nan", b"inf", b"-1", b"0", b"1e308", b"1e-320", b"2147483648", b"4294967295", b"9" * 400, b"", b"x", b"\0"]


def attacks(seed: int, count: int, folder: Path) -> Iterator[Attack]:
    """`count` spoiled meshes of all formats."""
    _zip_bomb()
    for number in range(count):
        kind = list(KINDS)[number % len(KINDS)]
        suffix = SUFFIXES[number // len(KINDS) % len(SUFFIXES)]
        yield Attack(
            f"meshes {kind} {suffix} {seed}:{number}",
            lambda kind=kind, suffix=suffix, number=number: _act(kind, suffix, seed, number, folder),
        )


def _act(kind: str, suffix: str, seed: int, number: int, folder: Path) -> str:
    rng = np.random.default_rng([seed, number])
    path = folder / f"spoiled{suffix}"
    path.unlink(missing_ok=True)
    content, must = KINDS[kind](rng, _originals()[suffix], suffix)
    if content is None:
        os.mkfifo(path)
    else:
        path.write_bytes(content)
    try:
        found = load_mesh(Shape("mesh", (1.0, 1.0, 1.0), mesh=path))
    except InputError as error:
        if kind == "whole":
            raise Wrong(f"refused though it is sound: {error}") from error
        if "\n" in str(error) or len(str(error)) > 1000:
            raise Wrong(f"not one short line: {error}") from error
        return "refused"
    if must:
        raise Wrong(f"accepted with {sum(len(one.faces) for one in found)} triangles")
    for mesh in found:
        vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
        if not np.isfinite(vertices).all() or len(faces) > MOST_FACES:
            raise Wrong("accepted with corners that are not finite, or far too many triangles")
        if len(faces) and not (faces.min() >= 0 and faces.max() < len(vertices)):
            raise Wrong("accepted with triangles between corners that are not there")
    return "accepted"


@cache
def _originals() -> Mapping[str, bytes]:
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.1)
    made = {}
    for suffix in SUFFIXES:
        kind = suffix[1:].replace("ascii.stl", "stl_ascii").replace("ascii.ply", "ply")
        options = {"encoding": "ascii"} if suffix == ".ascii.ply" else {"embed_buffers": True} if kind == "gltf" else {}
        data = trimesh.Scene(ball).export(file_type=kind, **options) if kind in ("gltf", "3mf") else None
        data = ball.export(file_type=kind, **options) if data is None else data
        if isinstance(data, dict):
            data = data["model.gltf"]
        made[suffix] = data.encode() if isinstance(data, str) else bytes(data)
    return made


Spoiled = tuple[bytes | None, bool]


def _whole(_: Random, content: bytes, __: str) -> Spoiled:
    return content, False


def _flipped(rng: Random, content: bytes, _: str) -> Spoiled:
    data = bytearray(content)
    for _number in range(int(rng.integers(1, 6))):
        data[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
    return bytes(data), False


def _cut(rng: Random, content: bytes, suffix: str) -> Spoiled:
    # An OBJ that ends early is a shorter OBJ; the others say how much there should be, or how they end.
    return content[: int(rng.integers(len(content) - 2))], suffix != ".obj"


def _words(rng: Random, content: bytes, _: str) -> Spoiled:
    """Words of text, or four bytes, replaced by numbers that nobody writes."""
    data = content
    for _number in range(int(rng.integers(1, 4))):
        at = int(rng.integers(len(data)))
        word = WORDS[int(rng.integers(len(WORDS)))]
        if b"\0" in content[:2000]:
            value = float(rng.choice([np.nan, np.inf, 1e38, -1.0]))
            number = (
                struct.pack("<f", value) if rng.integers(2) else struct.pack("<I", int(rng.choice([2**31, 2**32 - 1])))
            )
            data = data[:at] + number + data[at + 4 :]
        else:
            start, end = data.rfind(b" ", 0, at) + 1, data.find(b" ", at)
            data = data[:start] + word + data[end:] if end > start else data
    return data, False


def _swapped(rng: Random, _: bytes, suffix: str) -> Spoiled:
    """The content of another format."""
    other = SUFFIXES[int(rng.integers(len(SUFFIXES)))]
    return _originals()[other], other.split(".")[-1] != suffix.split(".")[-1] and not _alike(other, suffix)


def _alike(other: str, suffix: str) -> bool:
    return {other, suffix} <= {".glb", ".gltf"}


def _junk(rng: Random, content: bytes, _: str) -> Spoiled:
    head = content[: int(rng.integers(0, 200))]
    return [b"", b" \n", head, rng.bytes(3000)][int(rng.integers(4))], True


def _counts(rng: Random, content: bytes, suffix: str) -> Spoiled:
    """Headings that promise far more than there is, and archives that unpack to far more than they are."""
    count = int(rng.choice([0, 10**6, 2**31 - 1, 2**31, 2**32 - 1]))
    if suffix == ".stl":
        return content[:80] + struct.pack("<I", count) + content[84:], True
    if suffix.endswith("ply"):
        what = b"vertex" if rng.integers(2) else b"face"
        start = content.index(b"element " + what)
        end = content.index(b"\n", start)
        return content[:start] + b"element " + what + b" %d" % count + content[end:], True
    if suffix == ".off":
        return b"OFF\n%d %d 0\n" % (count, count) + content.split(b"\n", 2)[2], True
    if suffix == ".3mf":
        return _zip_bomb(), True
    if suffix in (".glb", ".gltf"):
        key = [b'"count":', b'"byteLength":', b'"bufferView":'][int(rng.integers(3))]
        at = content.find(key)
        end = min(content.index(one, at) for one in (b",", b"}") if one in content[at:])
        return content[:at] + (key + b"%d" % count).ljust(end - at) + content[end:], False
    return content * 3, False


@cache
def _zip_bomb() -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr("3D/3dmodel.model", b"<model>" + b" " * 300_000_000)
    return buffer.getvalue()


def _outside(rng: Random, content: bytes, suffix: str) -> Spoiled:
    """Files that name devices, files of others, or themselves; and a pipe in place of a file."""
    target = [b"/dev/zero", b"/dev/stdin", b"../../../../../../etc/passwd", b"spoiled" + suffix.encode()][
        int(rng.integers(4))
    ]
    if suffix == ".obj":
        return b"mtllib " + target + b"\n" + content, False
    if suffix == ".dae":
        image = b'<library_images><image id="a"><init_from>' + target + b"</init_from></image></library_images>"
        return content.replace(b"<library_geometries>", image + b"<library_geometries>"), False
    if suffix == ".gltf":
        at = content.find(b'"uri":')
        end = content.index(b'"', at + 8)
        return content[: at + 6] + b'"' + target + content[end:], False
    return None, True


def _entities(rng: Random, content: bytes, suffix: str) -> Spoiled:
    """Entities that swell, and nodes that contain each other."""
    if suffix not in (".dae", ".3mf"):
        return _flipped(rng, content, suffix)
    if suffix == ".dae" and rng.integers(2):
        nodes = b"".join(
            b'<node id="n%d"><instance_node url="#n%d"/><instance_node url="#n%d"/></node>' % (k, k + 1, k + 1)
            for k in range(40)
        )
        nodes += b'<node id="n40"><instance_node url="#n0"/></node>'
        return content.replace(b"</visual_scene>", nodes + b"</visual_scene>"), False
    bomb = b"<!DOCTYPE x [<!ENTITY a0 'ha'>" + b"".join(
        b"<!ENTITY a%d '&a%d;&a%d;&a%d;&a%d;'>" % (k + 1, k, k, k, k) for k in range(30)
    )
    bomb += b"]>"
    if suffix == ".dae":
        body = content[content.index(b"<COLLADA") :] if b"<COLLADA" in content else content
        return b"<?xml version='1.0'?>" + bomb + body.replace(b"<up_axis>", b"<up_axis>&a30;"), True
    parts = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as archive, zipfile.ZipFile(parts, "w") as spoiled:
        for one in archive.infolist():
            data = archive.read(one)
            if one.filename.endswith(".model"):
                data = b"<?xml version='1.0'?>" + bomb + b"<model>&a30;</model>"
            spoiled.writestr(one.filename, data)
    return parts.getvalue(), True


KINDS: Mapping[str, Callable[[Random, bytes, str], Spoiled]] = {
    "whole": _whole,
    "flipped": _flipped,
    "cut": _cut,
    "words": _words,
    "swapped": _swapped,
    "junk": _junk,
    "counts": _counts,
    "outside": _outside,
    "entities": _entities,
}
"""Ways to spoil a mesh: the spoiled bytes (None: a pipe), and whether they must be refused."""
