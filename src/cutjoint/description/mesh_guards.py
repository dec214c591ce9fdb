"""What is wrong with the bytes of a mesh file before anybody interprets them: that it ends where it says, unpacks to
about what it is, declares no entities, and draws no part of it thousands of times.

The parsers of meshes take counts and references as they find them; a file of a few kilobytes can fill the memory.
"""

from __future__ import annotations

import io
import json
import struct
import zipfile
from collections.abc import Callable, Mapping

from lxml import etree

LARGEST = 64 * 2**20
"""Bytes of a mesh file."""
UNPACKED = 4 * LARGEST
"""Bytes of what a packed file unpacks to, and of what is drawn of a file with each part as often as it is used."""
MOST_NUMBERS = 2**24
"""In all arrays of a glTF file."""
_STL_HEAD = 84
_STL_TRIANGLE = 50


class MeshFault(ValueError):
    """What is wrong with a mesh file."""


def check_stl(data: bytes) -> None:
    """The triangles that a binary STL counts are there; one in ASCII ends as it began."""
    if len(data) >= _STL_HEAD:
        (count,) = struct.unpack_from("<I", data, 80)
        if len(data) == _STL_HEAD + count * _STL_TRIANGLE and count:
            return
    if data.lstrip()[:5].lower() != b"solid" or b"facet" not in data.lower():
        if len(data) < _STL_HEAD:
            raise MeshFault(f"{len(data)} bytes, less than the heading of an STL file")
        raise MeshFault(
            f"it counts {count} triangles, which take {_STL_HEAD + count * _STL_TRIANGLE} bytes, and has {len(data)}"
        )
    if b"endsolid" not in data[-1000:].lower():
        raise MeshFault("it ends without 'endsolid', so it was cut short")


def check_ply(data: bytes) -> None:
    """All elements that a PLY file counts are there, in ASCII a line each, in binary a byte each at least."""
    head, end, body = data.partition(b"end_header")
    if not data.startswith(b"ply") or not end:
        raise MeshFault("it has no heading of a PLY file")
    counts = {}
    for line in head.splitlines():
        words = line.split()
        if words[:1] == [b"element"]:
            if len(words) != 3 or not words[2].isdigit() or len(words[2]) > 12:
                raise MeshFault(f"its heading has the line {line[:60]!r}")
            counts[words[1]] = int(words[2])
    lines = body.strip().splitlines() if b"format ascii" in head else None
    wanted = sum(counts.values())
    if not counts.get(b"vertex") or not counts.get(b"face"):
        raise MeshFault("it counts no vertices, or no faces")
    if wanted > len(body) or (lines is not None and wanted != len(lines)):
        there = f"{len(body)} bytes" if lines is None else f"{len(lines)} lines"
        raise MeshFault(f"it counts {wanted} elements, and has {there} of them")


def check_off(data: bytes) -> None:
    """The vertices and faces that an OFF file counts are there, a line each."""
    lines = [line for one in data.splitlines() if (line := one.partition(b"#")[0].strip())]
    first = lines[0].removeprefix(b"C").removeprefix(b"OFF").strip() if lines else b""
    counts = first or (lines[1] if len(lines) > 1 else b"")
    words = counts.split()
    if not lines or b"OFF" not in lines[0] or len(words) < 2 or not all(one.isdigit() for one in words[:2]):
        raise MeshFault("it has no heading of an OFF file")
    wanted = int(words[0][:12]) + int(words[1][:12])
    if (there := len(lines) - (1 if first else 2)) != wanted:
        raise MeshFault(f"it counts {wanted} vertices and faces, and has {there} lines of them")


def check_gltf(data: bytes) -> None:
    """A binary glTF is as long as it says; the numbers that arrays count are not many more than there are bytes."""
    text = data
    if data[:4] == b"glTF":
        if len(data) < 20:
            raise MeshFault("it is cut short in its heading")
        whole, size = struct.unpack_from("<I", data, 8)[0], struct.unpack_from("<I", data, 12)[0]
        if whole != len(data):
            raise MeshFault(f"it should have {whole} bytes, and has {len(data)}")
        text = data[20 : 20 + size]
    try:
        tree = json.loads(text)
        arrays = tree.get("accessors", [])
        numbers = sum(int(one["count"]) for one in arrays)
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError, OverflowError) as error:
        raise MeshFault(f"it has no heading of a glTF file ({type(error).__name__}: {error})") from error
    if not 0 < numbers <= MOST_NUMBERS or any("bufferView" not in one for one in arrays):
        raise MeshFault(f"its arrays count {numbers} entries, expected 1 to {MOST_NUMBERS}, all of them in a buffer")


def check_dae(data: bytes) -> None:
    """A Collada file declares no entities, and draws what it has a bounded number of times, in no circle."""
    refuse_entities(data)
    try:
        root = etree.fromstring(data, etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=True))
    except (etree.XMLSyntaxError, ValueError) as error:
        raise MeshFault(f"its XML does not parse: {error}") from error
    named = {one.get("id"): one for one in root.iter(etree.Element) if one.get("id")}
    sizes: dict[object, int] = {}

    def size(element: etree._Element, inside: tuple[object, ...]) -> int:
        """Bytes of text that are drawn of a node, with all that it names."""
        if element in sizes:
            return sizes[element]
        if element in inside or len(inside) > 100:
            raise MeshFault("its nodes contain each other, or are nested more than 100 levels deep")
        total = 0
        for child in element:
            name = etree.QName(child).localname if isinstance(child.tag, str) else ""
            if name == "node":
                total += size(child, (*inside, element))
            elif name.startswith("instance_"):
                target = named.get((child.get("url") or "").removeprefix("#"))
                if target is not None and name == "instance_node":
                    total += size(target, (*inside, element))
                elif target is not None:
                    total += 100 + sum(len(text) for text in target.itertext())
        sizes[element] = total
        return total

    for scene in root.iter("{*}visual_scene"):
        if (drawn := size(scene, ())) > UNPACKED:
            raise MeshFault(f"it draws its parts so often that they would take {drawn / 1e6:.3g} MB")


def check_3mf(data: bytes) -> None:
    """A 3MF archive unpacks to a bounded size, and its XML declares no entities."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            if len(members) > 1000 or sum(one.file_size for one in members) > UNPACKED:
                raise MeshFault(f"it unpacks to {sum(one.file_size for one in members) / 1e6:.0f} MB")
            for one in members:
                content = archive.read(one)
                if one.filename.endswith((".model", ".xml", ".rels")):
                    refuse_entities(content)
    except MeshFault:
        raise
    except Exception as error:  # zlib, zipfile and struct have an error each for what is damaged
        raise MeshFault(f"it is no whole archive ({error})") from error


def refuse_entities(data: bytes) -> None:
    """That XML declares none, in whatever encoding: they can swell, and name files."""
    plain = data.replace(b"\0", b"")
    if b"<!DOCTYPE" in plain or b"<!ENTITY" in plain:
        raise MeshFault("it has a DOCTYPE or entity declaration, which is refused for safety")


def check_obj(data: bytes) -> None:
    """An OBJ file is text, with vertices and faces."""
    if b"\0" in data:
        raise MeshFault("it has zero bytes, so it is no text")
    if b"v " not in data or b"f " not in data:
        raise MeshFault("it has no vertices, or no faces")


GUARDS: Mapping[str, Callable[[bytes], None]] = {
    ".stl": check_stl,
    ".obj": check_obj,
    ".dae": check_dae,
    ".ply": check_ply,
    ".off": check_off,
    ".glb": check_gltf,
    ".gltf": check_gltf,
    ".3mf": check_3mf,
}
"""Suffix -> what raises MeshFault."""
