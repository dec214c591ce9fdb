"""A TOML file as a table that is read key by key, and settings that are made of it.

def _taken(top: TomlTable) -> Probe:
    made = Probe(top.string("robot", required=True), whole(top, "runs", 1, 1000) or 1)
    top.finish()
    return made

probe = read_settings("probe.toml", _taken)        # SettingsError: all that is wrong, with lines
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from cutjoint.errors import InputError, SettingsError
from cutjoint.findings import Findings, read_text_file
from cutjoint.toml.table import TomlTable, line_index, parse

Made = TypeVar("Made")


def read_toml(path: Path, findings: Findings, kind: str) -> TomlTable | None:
    """The whole of a TOML file, or None after noting why not; `kind` names the format for messages."""
    data = read_text_file(path, findings, kind)
    values = None if data is None else parse(data, findings)
    if data is None or values is None:
        return None
    return TomlTable(values, (), line_index(data.decode("utf-8")), findings)


def read_settings(path: str | os.PathLike[str], taken: Callable[[TomlTable], Made], kind: str = "TOML") -> Made:
    """What `taken` makes of the whole of a TOML file; it notes what is wrong and asks for every key it knows.

    Raises:
        SettingsError: no such file, no TOML, or something was noted: all of it, with lines.
    """
    findings = Findings(str(path))
    top = read_toml(Path(path), findings, kind)
    if top is None:
        raise SettingsError(findings.problems)
    return settings_of(top, taken)


def settings_of(top: TomlTable, taken: Callable[[TomlTable], Made]) -> Made:
    """What `taken` makes of a table.

    Raises:
        SettingsError: something was noted; an InputError of `taken` is noted at the table.
    """
    try:
        made = taken(top)
    except InputError as error:
        top.findings.error(str(error), at=top.place())
        raise SettingsError(top.findings.problems) from error
    if top.findings.failed:
        raise SettingsError(top.findings.problems)
    return made
