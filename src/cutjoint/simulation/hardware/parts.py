"""Hardware as plain tables: a TOML file, and what a result says of how it was made.

    [clock]          rate, jitter, tick
    [encoder]        resolution, offset, noise, delay, at
    [differences]    cutoff                              or [tachometer]  noise
    [drive]          limits, resolution, delay; [drive.torque_speed], [drive.backlash]
    seed

A table that is not there is ideal, a key that is not there has its default; only the clock's rate must be there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import TypeAlias, TypeVar

from cutjoint.errors import InputError, SettingsError
from cutjoint.findings import Findings
from cutjoint.simulation.hardware.values import (
    Backlash,
    Clock,
    Differences,
    Drive,
    Encoder,
    Hardware,
    Tachometer,
    TorqueSpeed,
)
from cutjoint.toml.reading import read_settings, settings_of
from cutjoint.toml.table import TomlTable

Parts: TypeAlias = dict[str, object]
"""Plain JSON values."""

Kind = TypeVar("Kind")
SPEEDS: Mapping[str, type[Differences] | type[Tachometer]] = {"differences": Differences, "tachometer": Tachometer}
INSIDE: Mapping[str, type] = {"torque_speed": TorqueSpeed, "backlash": Backlash}


def parts_of(hardware: Hardware) -> Parts:
    """All of it as plain values; `hardware_of` makes the same hardware of them."""
    speed = next(name for name, kind in SPEEDS.items() if isinstance(hardware.speed, kind))
    return {
        "clock": _listed(hardware.clock),
        "encoder": _listed(hardware.encoder),
        speed: _listed(hardware.speed),
        "drive": _listed(hardware.drive),
        "seed": hardware.seed,
    }


def hardware_of(parts: Mapping[str, object]) -> Hardware:
    """Hardware of plain values, such as `Result.about["hardware"]`.

    Raises:
        SettingsError: keys that are missing or unknown, values that are wrong: all of them.
    """
    return settings_of(TomlTable(parts, (), {}, Findings("hardware")), _taken)


def read_hardware(path: str | Path) -> Hardware:
    """Hardware of a TOML file.

    Raises:
        SettingsError: no such file, no TOML, keys that are missing or unknown, values that are wrong: all of them,
            with their lines.
    """
    return read_settings(path, _taken, "hardware.toml")


def _taken(top: TomlTable) -> Hardware:
    """The hardware of the whole table."""
    findings = top.findings
    if "clock" not in top.data:
        findings.error("no [clock]", "the rate of the controller", "add [clock] with rate = ... [Hz]")
    clock, encoder, drive = _part(Clock, top, "clock"), _part(Encoder, top, "encoder"), _part(Drive, top, "drive")
    speeds = [_part(kind, top, name) for name, kind in SPEEDS.items()]
    if all(name in top.data for name in SPEEDS):
        findings.error("speeds are told twice", "[differences] or [tachometer]", "", top.place("tachometer"))
    seed = top.take("seed")
    top.finish()
    made = None
    if clock is not None and not findings.failed:
        speed = next((one for one in speeds if one is not None), Tachometer())
        try:
            whole = 0 if seed is None else seed
            made = Hardware(clock, encoder or Encoder(), speed, drive or Drive(), whole)  # type: ignore[arg-type]
        except InputError as error:
            findings.error(str(error), at=top.place("seed" if "seed" in str(error) else "clock"))
    if made is None:
        raise SettingsError(findings.problems)
    return made


def _part(kind: type[Kind], table: TomlTable, name: str) -> Kind | None:
    """The value of one table, or None where there is none or it is wrong, which is noted."""
    own = table.table(name)
    if own is None:
        return None
    before = len(own.findings.problems)
    given: dict[str, object] = {}
    for one in fields(kind):  # type: ignore[arg-type]
        if one.name in INSIDE:
            given[one.name] = _part(INSIDE[one.name], own, one.name)
            continue
        required = one.default is MISSING and one.default_factory is MISSING
        value = own.take(one.name, required, "a number")
        if value is None:
            continue
        if one.name != "at" and not _is_numbers(value):
            own.wrong(one.name, value, "a number, or a list of them, one an actuator")
        given[one.name] = value
    own.finish()
    if len(own.findings.problems) > before:
        return None
    try:
        return kind(**given)
    except InputError as error:
        key = next(
            (key for key in given if key.replace("_", " ") in str(error).replace("-", " ").split(" of ")[0]), None
        )
        own.findings.error(str(error), at=own.place(key))
        return None


def _is_numbers(value: object) -> bool:
    items = value if isinstance(value, list | tuple) else [value]
    return bool(items) and all(isinstance(one, int | float) and not isinstance(one, bool) for one in items)


def _listed(value: object) -> Parts:
    """The fields of a value that are not None; tuples as lists."""
    found: Parts = {}
    for one in fields(value):  # type: ignore[arg-type]
        part = getattr(value, one.name)
        if one.name in INSIDE and part is not None:
            part = _listed(part)
        if part is not None:
            found[one.name] = list(part) if isinstance(part, tuple) else part
    return found
