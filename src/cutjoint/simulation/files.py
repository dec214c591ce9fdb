"""Results on disk: npz with a schema version (complete), CSV for plotting tools (one row a sample; written only)."""

from __future__ import annotations

import csv
import io
import json
import zipfile
from pathlib import Path

import numpy as np

from cutjoint.errors import InputError, ResultFileError
from cutjoint.files import check_place, write_whole
from cutjoint.simulation.observables import OBSERVABLES
from cutjoint.simulation.result import ARRAYS, Result, result_of

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

    def refused(why: str) -> ResultFileError:
        return ResultFileError(f"{source}{why}", path=str(source))

    try:
        with np.load(source, allow_pickle=False) as stored:
            content = {name: np.asarray(stored[name]) for name in stored.files}
    except FileNotFoundError as error:
        raise refused(": no such file") from error
    except IsADirectoryError as error:
        raise refused(" is a folder, expected a result file") from error
    except (OSError, ValueError, TypeError, EOFError, zipfile.BadZipFile, KeyError) as error:
        raise refused(f" is not a whole result file ({error}); run `cutjoint simulate --save` again") from error
    schema = content["schema"].tolist() if "schema" in content else "none"
    if schema != SCHEMA:
        mend = "simulate again or use the version of cutjoint that wrote it"
        raise refused(f" has result schema {schema}, this version reads {SCHEMA}; {mend}")
    missing = [name for name in (*ARRAYS, "about") if name not in content]
    if missing:
        raise refused(f" lacks {', '.join(missing)}")
    try:
        about = json.loads(str(content["about"]))
        return result_of({name: content[name] for name in OBSERVABLES if name in content}, about)
    except (ValueError, TypeError) as error:
        raise refused(f" does not hold a result: {error}") from error


def _npz(result: Result) -> bytes:
    buffer = io.BytesIO()
    # numpy's stubs take any array for its option allow_pickle.
    np.savez_compressed(buffer, schema=SCHEMA, about=json.dumps(dict(result.about)), **result.columns)  # type: ignore[arg-type]
    return buffer.getvalue()


def _csv(result: Result) -> str:
    actuators = result.about.get("actuators") or [[f"q{i + 1}", "rotation"] for i in range(result.q.shape[1])]
    shown = {name: column for name, column in result.columns.items() if OBSERVABLES[name].size != "nq"}
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow([title for name in shown for title in OBSERVABLES[name].titles(actuators)])
    writer.writerows(np.column_stack(list(shown.values())).tolist())
    return buffer.getvalue()
