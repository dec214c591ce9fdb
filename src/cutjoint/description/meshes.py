"""Meshes read out of files that nobody has to trust: plain files of bounded size, looked at before they are parsed.

Materials and buffers that a file names are read from its own folder only; textures are not read at all.
"""

from __future__ import annotations

import io
import logging
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, cast
from urllib.parse import unquote

import numpy as np

from cutjoint.description.formats.common.child import ChildFailed, in_child
from cutjoint.description.mesh_guards import GUARDS, LARGEST, MeshFault
from cutjoint.errors import FileError, InputError, shown
from cutjoint.extras import needed
from cutjoint.files import read_file
from cutjoint.findings import clip

if TYPE_CHECKING:
    from trimesh import Trimesh

AT_ONCE = 200_000
"""Bytes of a mesh that is read at once; larger ones, which can be made to take minutes, are read in a child process."""
SECONDS = 5.0
MEGABYTES = 4000
"""Of the child process: a million triangles in words take 4 s."""
MOST_FACES = 1_000_000
FURTHEST = 1e6
"""Of a corner from the origin, in the units of the file."""
BESIDE = (".mtl", ".bin")
"""Files that a mesh may name."""


def read_meshes(path: Path) -> tuple[Trimesh, ...]:
    """The parts of a mesh file, as they are placed in it, in the units of the file.

    Raises:
        InputError: no such file or none at all, of another kind, too large, damaged, or without triangles.
    """
    guard = GUARDS.get(path.suffix.lower())
    if guard is None:
        raise InputError(f"mesh file {shown(str(path))} is of an unknown kind; known: {', '.join(GUARDS)}")
    try:
        data = read_file(path, LARGEST)
        guard(data)
        if len(data) <= AT_ONCE:
            return parsed((path, data))
        return cast("tuple[Trimesh, ...]", in_child(f"{__name__}:parsed", (path.absolute(), data), SECONDS, MEGABYTES))
    except FileError as error:
        if error.missing:
            raise InputError(f"mesh file {shown(str(path))} is not there; give it or remove the shape") from error
        raise InputError(f"mesh file {error}") from error
    except ChildFailed as error:
        words = error.reason.removeprefix("raised MeshFault: ")
        raise InputError(f"mesh file {shown(str(path))} cannot be read: {words}") from error
    except InputError:
        raise
    except Exception as error:  # parsers of meshes raise whatever they stumble over
        words = clip(str(error), 200) or type(error).__name__
        raise InputError(f"mesh file {shown(str(path))} cannot be read: {words}") from error


logging.getLogger("trimesh").addHandler(logging.NullHandler())  # or Python prints its tracebacks where nobody listens


class _Beside:
    """What trimesh asks for the files that a mesh in `folder` names (its own resolvers read whatever is there)."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def get(self, name: str) -> bytes:
        """The content of a file in the folder.

        Raises:
            MeshFault: it is of another kind, or elsewhere.
            FileError: it is no file.
        """
        plain = PurePath(unquote(str(name)).replace("\\", "/"))
        if plain.is_absolute() or ".." in plain.parts or plain.suffix.lower() not in BESIDE:
            raise MeshFault(f"it names {clip(str(name))}, and may name {' and '.join(BESIDE)} files beside it")
        found = (self._folder / plain).resolve()
        if not found.is_relative_to(self._folder.resolve()):
            raise MeshFault(f"it names {clip(str(name))}, which leads out of its folder")
        return read_file(found, LARGEST)

    __getitem__ = get

    def keys(self) -> tuple[str, ...]:
        """Of what is known to be there: nothing, before it is asked for."""
        return ()

    def namespaced(self, _: str) -> _Beside:
        """For a folder inside."""
        return self


def parsed(file: tuple[Path, bytes]) -> tuple[Trimesh, ...]:
    """The checked parts of a mesh file: its path and its content."""
    path, data = file
    with np.errstate(all="ignore"):
        return _checked(_parsed(data, path))


def _parsed(data: bytes, path: Path) -> list[Trimesh]:
    trimesh = needed("trimesh", "a mesh file")
    kind = path.suffix.lower()[1:]
    loaded = trimesh.load(io.BytesIO(data), file_type=kind, force="scene", resolver=_Beside(path.parent), process=False)
    faces = [len(getattr(loaded.geometry[loaded.graph[node][1]], "faces", ())) for node in loaded.graph.nodes_geometry]
    if sum(faces) > MOST_FACES:
        raise MeshFault(f"{sum(faces)} triangles, more than {MOST_FACES}; simplify it")
    return [one for one in loaded.dump() if isinstance(one, trimesh.Trimesh) and len(one.faces)]


def _checked(meshes: list[Trimesh]) -> tuple[Trimesh, ...]:
    """Meshes whose corners are there and finite."""
    if not meshes:
        raise MeshFault("it holds no triangles")
    for mesh in meshes:
        corners, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
        if faces.min() < 0 or faces.max() >= len(corners):
            raise MeshFault(f"it has triangles between corners that are not there (of {len(corners)})")
        if not (np.abs(corners) <= FURTHEST).all():
            raise MeshFault(f"it holds corners that are not finite, or further than {FURTHEST:g} away")
        mesh.merge_vertices()
    return tuple(meshes)
