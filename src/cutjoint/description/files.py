"""Files on this machine: read with every way in which that goes wrong turned into a problem, and meshes found by name.

`package://`, `model://`, `file://` and relative names of meshes are looked up in ROS_PACKAGE_PATH, GAZEBO_MODEL_PATH,
GZ_SIM_RESOURCE_PATH, SDF_PATH, AMENT_PREFIX_PATH, the folders above the file that names the mesh, and the optional
package example-robot-data.
"""

from __future__ import annotations

import os
import sys
from functools import cache
from pathlib import Path
from urllib.parse import unquote

from cutjoint.files import is_file
from cutjoint.findings import Findings

_ABOVE = 5


@cache
def example_robot_data() -> Path | None:
    """The folder `share/example-robot-data` of the optional package, or None.  Imports nothing."""
    for entry in sys.path:
        base = Path(entry)
        for share in (base / "cmeel.prefix" / "share", base.parent.parent.parent / "share"):
            if (share / "example-robot-data" / "robots").is_dir():
                return share / "example-robot-data"
    return None


def search_folders(near: Path) -> list[Path]:
    """Folders that may hold a package named in a file at `near`, in the order in which they are tried."""
    folders: list[Path] = []
    for variable in ("ROS_PACKAGE_PATH", "GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH", "SDF_PATH"):
        folders += [Path(part) for part in os.environ.get(variable, "").split(os.pathsep) if part]
    folders += [Path(part) / "share" for part in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if part]
    folders += list(near.resolve().parents)[:_ABOVE]
    share = example_robot_data()
    if share is not None:
        folders += [share.parent, share / "robots"]
    return folders


def read_mesh(name: str, what: str, mend: str, near: Path, findings: Findings, line: int | None) -> Path | None:
    """The file that a mesh name means in a description at `near`, or None after noting that `what` is not there."""
    found, tried = find_mesh(name, near) if name else (None, [])
    if found is None:
        places = ", ".join(map(str, list(dict.fromkeys(tried))[:2]))
        findings.doubt(f"{what} not found", f"a file, such as {places}", mend, line)
    return found


def find_mesh(name: str, near: Path) -> tuple[Path | None, list[Path]]:
    """The file that a mesh name means in a description at `near`, and the paths that were tried."""
    for scheme in ("package://", "model://"):
        if name.startswith(scheme):
            inside = unquote(name[len(scheme) :])
            package, _, rest = inside.partition("/")
            if not package:
                return _first([near.parent / rest, near.parent.parent / rest, near.parent.parent / "meshes" / rest])
            tried: list[Path] = []
            for folder in search_folders(near):
                candidates = [folder / inside]
                if folder.name == package:
                    candidates.append(folder / rest)
                tried += candidates
            return _first(tried)
    path = Path(unquote(name[len("file://") :])) if name.startswith("file://") else near.parent / name
    return _first([path])


def _first(candidates: list[Path]) -> tuple[Path | None, list[Path]]:
    candidates = [Path(os.path.normpath(path)) for path in candidates]
    return next((path for path in candidates if is_file(path)), None), candidates
