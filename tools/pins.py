"""Writes constraints.txt: the exact version of every package that an installation of cutjoint can bring.

    python tools/pins.py            resolve the newest versions that pyproject.toml allows and write the file
    python tools/pins.py --check    compare the file with what is installed here; exit status 1 where they differ

The versions come from pip's own resolver, run without constraints over the package with all its extras, and over what
builds it.  Run it with the oldest supported Python: what serves it serves the newer ones too.  The file names versions
only, never an address: where packages come from is up to whoever installs.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FILE = ROOT / "constraints.txt"
EXTRAS = "dev,bench"
# What an editable installation needs on top of the build backend; the backend asks for it only while it builds.
EDITABLE = "editables"
# Made by `venv` itself, not by an installation of cutjoint.
NOT_OURS = {"pip", "setuptools", "wheel", "cutjoint"}
HEADER = """\
# Exact versions of everything that `make` installs, the tools that build the package included.
# Written by tools/pins.py; the same versions serve Python 3.11, 3.12 and 3.13.
"""


def normal(name: str) -> str:
    """A distribution's name as packaging tools compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def read(text: str) -> dict[str, str]:
    """Name -> version of the pins in `text`.

    Raises:
        ValueError: a line is neither a comment nor a plain `name==version`.
    """
    pins = {}
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.startswith("#"):
            continue
        match = re.fullmatch(r"([A-Za-z0-9._-]+)==([A-Za-z0-9.+!]+)", line.strip())
        if match is None:
            raise ValueError(f"line {number} is not `name==version`: {line!r}")
        pins[normal(match[1])] = match[2]
    return pins


def installed() -> dict[str, str]:
    """Name -> version of what is installed in the running environment, but for the package itself."""
    found = {normal(one.metadata["Name"]): one.version for one in importlib.metadata.distributions()}
    return {name: version for name, version in found.items() if name not in NOT_OURS}


def resolve(*requirements: str) -> dict[str, str]:
    """Name -> version that pip would install for `requirements`, with no constraint at all."""
    clean = {key: value for key, value in os.environ.items() if key not in ("PIP_CONSTRAINT", "PIP_BUILD_CONSTRAINT")}
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        command = [sys.executable, "-m", "pip", "install", "--quiet", "--dry-run", "--ignore-installed"]
        subprocess.run([*command, "--report", str(report), *requirements], cwd=ROOT, env=clean, check=True)
        rows = json.loads(report.read_text())["install"]
    return {row["metadata"]["name"]: row["metadata"]["version"] for row in rows}


def main() -> int:
    """Write or check the file; the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare the file with what is installed")
    if parser.parse_args().check:
        pins = read(FILE.read_text())
        wrong = {name: version for name, version in installed().items() if pins.get(name) != version}
        for name, version in sorted(wrong.items()):
            print(f"{name} {version} is installed, {FILE.name} says {pins.get(name, 'nothing')}")
        return 1 if wrong else 0
    build = tomllib.loads((ROOT / "pyproject.toml").read_text())["build-system"]["requires"]
    pins = resolve(f".[{EXTRAS}]", *build, EDITABLE)
    lines = sorted(f"{name}=={version}" for name, version in pins.items() if normal(name) not in NOT_OURS)
    fresh = FILE.with_suffix(".new")
    fresh.write_text(HEADER + "\n".join(sorted(lines, key=str.lower)) + "\n")
    fresh.replace(FILE)
    print(f"{FILE.name}: {len(lines)} packages")
    return 0


if __name__ == "__main__":
    sys.exit(main())
