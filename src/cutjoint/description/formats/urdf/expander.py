"""Expands a xacro file, in a process of its own: `python expander.py BYTES FILE FOLDER...` writes the XML,
up to so many bytes, to its output.

xacro evaluates Python expressions and opens the files that it is told to; so this runs with bounds on memory, time and
the size of files, writes nowhere, and is ended from outside after a while.  `$(find PACKAGE)` is looked up in the
folders that are given, since there is rarely a ROS here.  Nothing of cutjoint is imported.
"""

from __future__ import annotations

import resource
import stat
import sys
from importlib import import_module
from pathlib import Path

MEMORY = 2**30
"""Bytes of address space."""
SECONDS = 4
"""Of processor time."""
FAILED = 2
"""The exit status where xacro refuses the file; the reason is on stderr."""


def found(package: str, folders: list[Path]) -> str:
    """The folder of a package."""
    for folder in folders:
        for place in (folder / package, *([folder] if folder.name == package else [])):
            if place.is_dir():
                return str(place)
    raise LookupError(
        f"the package '{package}' is in none of ROS_PACKAGE_PATH, AMENT_PREFIX_PATH and the folders above"
    )


def bounded() -> None:
    """Set the bounds of this process."""
    for what, most in ((resource.RLIMIT_AS, MEMORY), (resource.RLIMIT_CPU, SECONDS), (resource.RLIMIT_FSIZE, 0)):
        _, hard = resource.getrlimit(what)
        resource.setrlimit(what, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def main(arguments: list[str]) -> int:
    """Expand the file; the exit status."""
    most, file, *folders = arguments
    bounded()
    xacro = import_module("xacro")
    substitution = import_module("xacro.substitution_args")
    parse = xacro.parse

    def regular(text: object, name: str | None = None) -> object:
        if name is not None and Path(name).exists() and not stat.S_ISREG(Path(name).stat().st_mode):
            raise OSError(f"{name} is not a regular file")
        return parse(text, name)

    def look(package: str) -> str:
        return found(package, [Path(folder) for folder in folders])

    vars(xacro)["parse"] = regular
    vars(substitution)["_eval_find"] = look
    try:
        document = xacro.process_file(file)
    except Exception as error:  # whatever Python expressions of strangers raise
        reason = str(error) or repr(error)
        sys.stderr.write(reason[:2000])
        return FAILED
    data = document.toprettyxml(indent="  ").encode("utf-8")
    if len(data) > int(most):
        sys.stderr.write(f"it makes {len(data) / 2**20:.0f} MB of the file, of at most {int(most) / 2**20:.0f}")
        return FAILED
    sys.stdout.buffer.write(data)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
