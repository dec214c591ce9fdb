"""Reading a file into memory with every way in which that goes wrong turned into a problem."""

from __future__ import annotations

from pathlib import Path

from cutjoint.description.findings import Findings, closest

LARGEST_FILE = 32 * 2**20
"""Bytes.  The largest robot descriptions in use have about 1 MB."""


def read_text_file(path: Path, findings: Findings, kind: str) -> bytes | None:
    """The bytes of a text file, or None after noting why not.  `kind` names the format for messages."""
    findings.file = findings.file or str(path)
    try:
        if path.is_dir():
            findings.error("a directory", f"a {kind} file", "name the file inside it, or add a loops.toml to it")
            return None
        if not path.exists():
            found = closest(path.name, _neighbours(path))
            findings.error("file not found", f"a {kind} file", f"did you mean '{found}'?" if found else "")
            return None
        if path.stat().st_size > LARGEST_FILE:
            size = path.stat().st_size / 2**20
            findings.error(f"a file of {size:.0f} MB", f"at most {LARGEST_FILE / 2**20:.0f} MB of {kind}")
            return None
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        findings.error(f"the file cannot be read: {error}", f"a readable {kind} file")
        return None
    if not data.strip():
        findings.error("an empty file", f"a {kind} file", "the copy or download may have failed")
        return None
    if b"\0" in data and not data.startswith((b"\xff\xfe", b"\xfe\xff")):
        findings.error("a binary file", f"a {kind} text file", "a mesh or an archive does not describe a robot")
        return None
    return data


def _neighbours(path: Path) -> list[str]:
    """Names of the files beside `path`."""
    try:
        return [one.name for one in path.parent.iterdir() if one.is_file()]
    except OSError:
        return []
