"""The XML of a URDF, expanded where it is xacro (https://wiki.ros.org/xacro) and the package `xacro` is installed.

Xacro is a language with Python expressions and includes, so it runs as a process of its own (`expander.py`), within
bounds.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from cutjoint.description.files import search_folders
from cutjoint.description.xml import Element, left_in, parse_xml, read_xml
from cutjoint.extras import how_to_get, is_installed
from cutjoint.findings import LARGEST_FILE, Findings, clip

TIMEOUT = 20.0
"""Seconds by the clock; large robots take one.  Its processor time is bounded more tightly."""
_EXPECTED = "a plain file without xacro, or one that the package xacro expands without arguments"
_BY_HAND = "expand it first: xacro robot.urdf.xacro > robot.urdf"


def read_expanded(path: Path, findings: Findings) -> Element | None:
    """The root element of a URDF, or None after noting why not."""
    root = read_xml(path, findings, "URDF")
    rests = [] if root is None else left_in(root)
    if root is None or not rests:
        return root
    if not is_installed("xacro"):
        for inside, line in rests:
            findings.error(f"xacro left in: {inside}", _EXPECTED, f"{how_to_get('xacro')}, or {_BY_HAND}", line)
        return None
    try:
        data = _expand(path)
    except _Refused as refused:
        inside, line = rests[0]
        findings.error(f"xacro left in: {inside}, and xacro refuses the file: {refused}", _EXPECTED, _BY_HAND, line)
        return None
    findings.file = f"{path} (expanded)"
    root = parse_xml(data, findings, "URDF")
    for inside, line in [] if root is None else left_in(root):
        findings.error(f"xacro left in: {inside}", _EXPECTED, _BY_HAND, line)
    return None if findings.failed else root


class _Refused(Exception):
    """Why xacro does not expand a file."""


def _expand(path: Path) -> bytes:
    """What xacro makes of a file."""
    script = Path(__file__).with_name("expander.py")
    folders = map(str, search_folders(path))
    command = [sys.executable, "-P", str(script), str(LARGEST_FILE), str(path), *folders]
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True
    ) as process:
        try:
            data, told = process.communicate(timeout=TIMEOUT)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            raise _Refused(f"it took longer than {TIMEOUT:g} s") from None
        except BaseException:
            process.kill()
            raise
    if process.returncode != 0:
        reason = told.decode("utf-8", "replace").strip()
        raise _Refused(clip(reason or f"it ended with status {process.returncode}", 300))
    return data
