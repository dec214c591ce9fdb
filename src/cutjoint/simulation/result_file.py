"""Results on disk: npz with a schema version (complete), or CSV for plotting tools (one row a sample; written only).

A file that is read is strangers' work: its kind and size are looked at first, then the headings of all its arrays, and
what does not fit together is refused before anything is unpacked.
"""

from __future__ import annotations

import io
import json
import os
import warnings
from pathlib import Path

import numpy as np

from cutjoint.doors import door
from cutjoint.errors import FileError, InputError, ResultFileError
from cutjoint.files import check_place, read_file, write_whole
from cutjoint.simulation.about_run import about_of, json_words
from cutjoint.simulation.array_archive import ArchiveError, ArrayArchive
from cutjoint.simulation.csv_text import csv_text
from cutjoint.simulation.observables import OBSERVABLES
from cutjoint.simulation.result import ARRAYS, Result, result_of

SCHEMA = 1
SUFFIXES = (".npz", ".csv")
LARGEST = 2**30
"""Bytes of a result file, and twice that unpacked: a run of an hour, sampled every millisecond, has less."""
COLUMNS = "columns"
"""Where among the words about a run its file keeps name and shape of its columns, so that none can be lost unseen."""


@door
def save(result: Result, path: str | Path) -> Path:
    """Write `result` to `path`; the suffix picks the format (.npz or .csv).

    Raises:
        InputError: another suffix, or a folder that does not exist or cannot be written.
    """
    target = check_target(path)
    return write_whole(target, _npz(result, target.parent) if target.suffix == ".npz" else _csv(result))


def check_target(path: str | Path) -> Path:
    """`path` as a place where a result can be written; worth asking before a long run.

    Raises:
        InputError: unknown suffix, no such folder, or a folder of that name.
    """
    target = check_place(path)
    if target.suffix not in SUFFIXES:
        raise InputError(f"a result file ends in {' or '.join(SUFFIXES)}; found {str(target)!r}")
    return target


@door
def load(path: str | Path) -> Result:
    """Read a result that `save` wrote as npz.  Columns without a row in `OBSERVABLES` are left out, with a warning.

    Raises:
        ResultFileError: no such file or none at all, cut short, damaged, too large, of another schema version, or with
            contents that are no result.
    """

    def refused(why: str) -> ResultFileError:
        return ResultFileError(f"{path}{why}", path=str(path))

    try:
        with ArrayArchive(read_file(path, LARGEST), 2 * LARGEST) as archive:
            schema = archive.number("schema")
            if schema != SCHEMA:
                mend = "simulate again or use the version of cutjoint that wrote it"
                raise refused(f" has result schema {schema}, this version reads {SCHEMA}; {mend}")
            words = json_words(archive.text("about"))
            names = _columns(archive, words.pop(COLUMNS, None))
            about = about_of(words)
            if "file" in about:
                about["file"] = os.path.normpath(Path(path).absolute().parent / about["file"])
            return result_of({name: np.asarray(archive.array(name), dtype=np.float64) for name in names}, about)
    except FileError as error:
        raise refused(f": {error.why}{error.mend and f' ({error.mend})'}") from error
    except ArchiveError as error:
        raise refused(f" is not a whole result file ({error}); run `cutjoint simulate --save` again") from error
    except (ValueError, TypeError, RecursionError) as error:
        raise refused(f" does not hold a result: {error}") from error


def _columns(archive: ArrayArchive, listed: object) -> list[str]:
    """The names of the columns in a file, which are there and fit each other.

    `listed` are the shapes by name that it was written with; files of earlier versions do not tell.

    Raises:
        ValueError: some are missing, or are no columns of one result.
    """
    there = [name for name in archive.names if name not in ("schema", "about")]
    if not isinstance(listed, dict | None):
        raise ValueError(f"its list of columns reads {str(listed)[:60]!r}")
    if missing := [name for name in dict.fromkeys((*ARRAYS, *(listed or ()))) if name not in there]:
        raise ValueError(f"it lacks {', '.join(missing)}")
    if unknown := [name for name in there if name not in OBSERVABLES]:
        told = f"the result file also holds {', '.join(unknown)}, for which OBSERVABLES has no row; left out"
        warnings.warn(told, stacklevel=3)
    names = [name for name in OBSERVABLES if name in there]
    shapes = {name: archive.shape(name) for name in names}
    if other := [f"{name} ({archive.kind(name)})" for name in names if archive.kind(name) != "float64"]:
        raise ValueError(f"expected columns of 64-bit numbers, found {', '.join(other)}")
    m = shapes["time"][0] if len(shapes["time"]) == 1 and shapes["time"] != (0,) else -1
    n = shapes["q"][1] if len(shapes["q"]) == 2 else -1
    if wrong := [f"{name} {shape}" for name, shape in shapes.items() if not OBSERVABLES[name].fits(shape, m, n)]:
        raise ValueError(f"its columns do not fit together: {', '.join(wrong)}")
    if lost := [name for name in listed or {} if name in shapes and listed and listed[name] != list(shapes[name])]:
        raise ValueError(f"it was written with other shapes of {', '.join(lost)}")
    return names


def _npz(result: Result, folder: Path) -> bytes:
    buffer = io.BytesIO()
    said = dict(result.about)
    if "file" in result.about:
        said["file"] = _seen_from(folder.absolute(), result.about["file"])
    about = json.dumps({**said, COLUMNS: {name: one.shape for name, one in result.columns.items()}})
    # numpy's stubs take any array for its option allow_pickle.
    np.savez_compressed(buffer, schema=SCHEMA, about=about, **result.columns)  # type: ignore[arg-type]
    return buffer.getvalue()


def _seen_from(folder: Path, file: str) -> str:
    """The way to a robot's file from the result's folder: both may be moved together, and no more is told of a disk."""
    try:
        return Path(os.path.relpath(file, folder)).as_posix()
    except ValueError:  # of another drive
        return file


def _csv(result: Result) -> str:
    actuators = result.about.get("actuators") or [[f"q{i + 1}", "rotation"] for i in range(result.q.shape[1])]
    shown = {name: column for name, column in result.columns.items() if OBSERVABLES[name].size != "nq"}
    titles = [title for name in shown for title in OBSERVABLES[name].titles(actuators)]
    return csv_text(titles, list(shown.values()))
