"""Results on disk: npz with a schema version (complete), CSV for plotting tools (one row a sample; written only)."""

from __future__ import annotations

import csv
import io
import json
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import InputError, ResultFileError
from cutjoint.files import check_place, write_whole
from cutjoint.simulation.result import ARRAYS, Result

SCHEMA = 1
SUFFIXES = (".npz", ".csv")


def save(result: Result, path: str | Path) -> Path:
    """Write `result` to `path`; the suffix picks the format (.npz or .csv).

    Raises:
        InputError: another suffix, or a folder that does not exist or cannot be written.
    """
    target = check_target(path)
    return write_whole(target, _npz(result) if target.suffix == ".npz" else _csv(result))


def check_target(path: str | Path) -> Path:
    """`path` as a place where a result can be written; worth asking before a long run.

    Raises:
        InputError: unknown suffix, no such folder, or a folder of that name.
    """
    target = Path(path)
    if target.suffix not in SUFFIXES:
        raise InputError(f"a result file ends in {' or '.join(SUFFIXES)}; found {str(target)!r}")
    return check_place(target)


def load(path: str | Path) -> Result:
    """Read a result that `save` wrote as npz.

    Raises:
        ResultFileError: no such file, cut short, damaged, or of another schema version.
    """
    source = Path(path)
    try:
        with np.load(source, allow_pickle=False) as stored:
            content = {name: np.asarray(stored[name]) for name in stored.files}
    except FileNotFoundError as error:
        raise ResultFileError(f"{source}: no such file", path=str(source)) from error
    except IsADirectoryError as error:
        raise ResultFileError(f"{source} is a folder, expected a result file", path=str(source)) from error
    except (OSError, ValueError, TypeError, EOFError, zipfile.BadZipFile, KeyError) as error:
        raise ResultFileError(
            f"{source} is not a whole result file ({error}); run `cutjoint simulate --save` again", path=str(source)
        ) from error
    schema = content.get("schema")
    if schema is None or schema.tolist() != SCHEMA:
        found = "none" if schema is None else schema.tolist()
        raise ResultFileError(
            f"{source} has result schema {found}, this version reads {SCHEMA}; simulate again or use the version of "
            "cutjoint that wrote it",
            path=str(source),
        )
    missing = [name for name in (*ARRAYS, "about") if name not in content]
    if missing:
        raise ResultFileError(f"{source} lacks {', '.join(missing)}", path=str(source))
    try:
        return Result(**{name: content[name] for name in ARRAYS}, about=json.loads(str(content["about"])))
    except (ValueError, TypeError) as error:
        raise ResultFileError(f"{source} does not hold a result: {error}", path=str(source)) from error


def _npz(result: Result) -> bytes:
    buffer = io.BytesIO()
    arrays = {name: getattr(result, name) for name in ARRAYS}
    np.savez_compressed(buffer, schema=SCHEMA, about=json.dumps(dict(result.about)), **arrays)
    return buffer.getvalue()


def _csv(result: Result) -> str:
    rows = result.about.get("actuators") or [(f"q{i + 1}", "rotation") for i in range(result.q.shape[1])]
    names, kinds = [str(row[0]) for row in rows], [str(row[1]) for row in rows]
    columns = list(_columns(result, names, kinds))
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow([title for title, _ in columns])
    writer.writerows(zip(*(values.tolist() for _, values in columns), strict=True))
    return buffer.getvalue()


def _columns(result: Result, names: list[str], kinds: list[str]) -> Iterator[tuple[str, Array]]:
    yield "time [s]", result.time
    for array, title, unit in (
        ("q", "", ""),
        ("v", " speed", "/s"),
        ("desired_q", " desired", ""),
        ("desired_v", " speed desired", "/s"),
    ):
        for i, (name, kind) in enumerate(zip(names, kinds, strict=True)):
            base = "m" if kind == "translation" else "rad"
            yield f"{name}{title} [{base}{unit}]", getattr(result, array)[:, i]
    for i, (name, kind) in enumerate(zip(names, kinds, strict=True)):
        yield f"{name} effort [{'N' if kind == 'translation' else 'N m'}]", result.effort[:, i]
    for array, title, unit in (
        ("tool", "tool", "m"),
        ("tool_velocity", "tool velocity", "m/s"),
        ("desired_tool", "desired tool", "m"),
        ("desired_tool_velocity", "desired tool velocity", "m/s"),
    ):
        for i, axis in enumerate("xyz"):
            yield f"{title} {axis} [{unit}]", getattr(result, array)[:, i]
    yield "loop gap [m]", result.gap[:, 0]
    yield "loop gap [rad]", result.gap[:, 1]
    for array in ("kinetic", "potential", "work"):
        yield f"{array} [J]", getattr(result, array)
