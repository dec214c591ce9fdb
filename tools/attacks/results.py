"""Spoiled result files: whatever loads has the columns of the original, and everything else is one ResultFileError."""

from __future__ import annotations

import io
import json
import warnings
import zipfile
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from attacks.judging import Attack, Wrong
from cutjoint.errors import ResultFileError
from cutjoint.robots import load as robot
from cutjoint.simulation import Result, load, run, save

Columns = dict[str, npt.NDArray[np.generic]]
Random = np.random.Generator


def attacks(seed: int, count: int, folder: Path) -> Iterator[Attack]:
    """`count` result files, spoiled as bytes, as zip files, as arrays or in the words about the run."""
    for number in range(count):
        kind = list(KINDS)[number % len(KINDS)]
        yield Attack(
            f"results {kind} {seed}:{number}", lambda kind=kind, number=number: _act(kind, seed, number, folder)
        )


def _act(kind: str, seed: int, number: int, folder: Path) -> str:
    rng = np.random.default_rng([seed, number])
    original, content = _original(folder)
    spoiled, must = KINDS[kind](rng, content)
    path = folder / "spoiled.npz"
    path.write_bytes(spoiled)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            found = load(path)
    except ResultFileError as error:
        if "\n" in str(error) or len(str(error)) > 1000:
            raise Wrong(f"not one short line: {error}") from error
        return "refused"
    if must:
        raise Wrong("accepted, though it is no result")
    if set(found.columns) != set(original.columns):
        raise Wrong(f"accepted with the columns {', '.join(found.columns)}")
    for name, column in original.columns.items():
        if not np.array_equal(column, found.columns[name]):
            raise Wrong(f"accepted with another column {name}")
    return "accepted"


@cache
def _original(folder: Path) -> tuple[Result, bytes]:
    result = run(robot("fourbar"), duration=0.1, every=0.01)
    path = save(result, folder / "original.npz")
    return result, path.read_bytes()


def _arrays(content: bytes) -> Columns:
    with np.load(io.BytesIO(content)) as stored:
        return {name: stored[name] for name in stored.files}


def _npz(columns: Mapping[str, npt.NDArray[np.generic]], packed: bool = True) -> bytes:
    buffer = io.BytesIO()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        (np.savez_compressed if packed else np.savez)(buffer, **columns)
    return buffer.getvalue()


def _pick(rng: Random, choices: list[str]) -> str:
    return choices[int(rng.integers(len(choices)))]


# ---- bytes: the zip's checksums and its directory must tell ------------------------------------------------------


def _flipped(rng: Random, content: bytes) -> tuple[bytes, bool]:
    data = bytearray(content)
    for _ in range(int(rng.integers(1, 4))):
        data[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
    return bytes(data), False


def _cut(rng: Random, content: bytes) -> tuple[bytes, bool]:
    return content[: int(rng.integers(len(content)))], True


def _overwritten(rng: Random, content: bytes) -> tuple[bytes, bool]:
    data, at, size = bytearray(content), int(rng.integers(len(content))), int(rng.integers(1, 200))
    data[at : at + size] = rng.bytes(len(data[at : at + size]))
    return bytes(data), False


def _removed(rng: Random, content: bytes) -> tuple[bytes, bool]:
    at, size = int(rng.integers(len(content))), int(rng.integers(1, 200))
    return content[:at] + content[at + size :], True


def _extended(rng: Random, content: bytes) -> tuple[bytes, bool]:
    extra = rng.bytes(int(rng.integers(1, 100)))
    return (content + extra, True) if rng.integers(2) else (extra + content, False)


# ---- members -----------------------------------------------------------------------------------------------------


def _members(rng: Random, content: bytes) -> tuple[bytes, bool]:
    """A member dropped, doubled, renamed, exchanged with another, packed by another method or with another's data."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = [(one.filename, archive.read(one)) for one in archive.infolist()]
    at, other = int(rng.integers(len(members))), int(rng.integers(len(members)))
    method, must, what = zipfile.ZIP_DEFLATED, True, int(rng.integers(6))
    if what == 0:
        del members[at]
    elif what == 1:
        members.append(members[at])
    elif what == 2:
        members[at] = (
            members[at][0].replace(".npy", _pick(rng, ["", ".txt", "2.npy", "/", "\x00.npy"])),
            members[at][1],
        )
    elif what == 3:
        must = members[at][1][:128] != members[other][1][:128]  # their types or shapes
        members[at] = (members[at][0], members[other][1])
        if not must:
            return _cut(rng, content)
    elif what == 4:
        method = zipfile.ZIP_BZIP2 if rng.integers(2) else zipfile.ZIP_LZMA
    else:
        members += [(f"more{k}.npy", b"") for k in range(int(rng.integers(1, 300)))]
    buffer = io.BytesIO()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with zipfile.ZipFile(buffer, "w", method) as archive:
            for name, data in members:
                archive.writestr(name, data)
    return buffer.getvalue(), must


def _bomb(rng: Random, content: bytes) -> tuple[bytes, bool]:
    """An array whose heading or whose zip entry promises far more than there is."""
    shape = int(10 ** rng.uniform(6, 18))
    dtype = _pick(rng, ["<f8", "<f4", "|O", "<U1000"])
    name = _pick(rng, ["time", "q", "about", "schema", "more"])
    heading = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': ({shape},), }}".ljust(117).encode() + b"\n"
    data = b"\x93NUMPY\x01\x00" + len(heading).to_bytes(2, "little") + heading
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = {one.filename: archive.read(one) for one in archive.infolist()}
    members[f"{name}.npy"] = data + bytes(int(rng.integers(0, 20_000_000)))
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for member, stored in members.items():
            archive.writestr(member, stored)
    return buffer.getvalue(), True


# ---- arrays ------------------------------------------------------------------------------------------------------


def _typed(rng: Random, content: bytes) -> tuple[bytes, bool]:
    """A column of another type."""
    columns = _arrays(content)
    name = _pick(rng, [one for one in columns if one not in ("schema", "about")])
    column = columns[name]
    kinds: list[Callable[[], npt.NDArray[np.generic]]] = [
        lambda: column.astype(np.complex128),
        lambda: column.astype(str),
        lambda: column.astype(object),
        lambda: column.astype(bool),
        lambda: column.astype("datetime64[s]"),
        lambda: column.astype("timedelta64[s]"),
        lambda: column.astype(np.int64),
        lambda: column.astype(np.float32),
        lambda: column.astype("S8"),
        lambda: np.zeros(column.shape, dtype=[("a", "<f8")]),
        lambda: column.astype(np.longdouble),
    ]
    columns[name] = kinds[int(rng.integers(len(kinds)))]()
    return _npz(columns), True


def _shaped(rng: Random, content: bytes) -> tuple[bytes, bool]:
    """A column of another width, length or rank."""
    columns = _arrays(content)
    name = _pick(rng, [one for one in columns if one not in ("schema", "about", "q_full")])
    column = columns[name]
    kinds: list[Callable[[], npt.NDArray[np.generic]]] = [
        lambda: column[:-1],
        lambda: column[..., None],
        lambda: np.concatenate([column, column]),
        lambda: column[:0],
        lambda: column.reshape(-1)[0],
        lambda: np.zeros((0, *column.shape[1:])),
        lambda: column[None],
        lambda: np.concatenate([column, column], axis=-1),
    ]
    columns[name] = kinds[int(rng.integers(len(kinds)))]()
    return _npz(columns), True


def _valued(rng: Random, content: bytes) -> tuple[bytes, bool]:
    """Numbers that are not finite, or times that do not grow."""
    columns = _arrays(content)
    if rng.integers(2):
        time = columns["time"].copy()
        at = int(rng.integers(1, len(time)))
        time[at] = time[at - 1] - rng.choice([0.0, 1.0, 1e-12])
        columns["time"] = time if rng.integers(2) else columns["time"][::-1]
    else:
        name = _pick(rng, [one for one in columns if one not in ("schema", "about")])
        column = columns[name].copy()
        column.flat[int(rng.integers(column.size))] = rng.choice([np.nan, np.inf, -np.inf])
        columns[name] = column
    return _npz(columns, packed=bool(rng.integers(2))), True


def _words(rng: Random, content: bytes) -> tuple[bytes, bool]:
    """What is said about the run: no JSON, deep, huge, of other types; and the schema."""
    columns = _arrays(content)
    if not rng.integers(6):
        schemas: list[object] = [2, -1, 1.0, "1", True, [1], 10**18, None]
        columns["schema"] = np.array(schemas[int(rng.integers(len(schemas)))])
        return _npz(columns), True
    text = str(columns["about"])
    about = json.loads(text)
    texts = [
        "", "7", "null", "[]", '"x"', "{", text[:-1], text + "}", "nan", "[" * 100_000,
        '{"a":' * 5000 + "1" + "}" * 5000,
        text[:-1] + ', "rate": NaN}', text[:-1] + ', "strayed": -Infinity}', text[:-1] + f', "steps": {"9" * 5000}}}',
        text[:-1] + f', "steps": {"9" * 400}}}', text[:-1] + ', "more": "\\ud800"}', text[:-1] + ', "strayed": 1e999}',
        text[:-1] + ', "robot": "again"}',
    ]  # fmt: skip
    wrong: list[object] = [7, None, True, "x", [1], {"time": 1}, [[["x"]]], -1, 1e400]
    if rng.integers(2):
        columns["about"] = np.array(texts[int(rng.integers(len(texts)))])
        return _npz(columns), True
    key = _pick(rng, ["robot", "plant", "law", "integrator", "actuators", "evaluations", "steps", "columns", "gains"])
    if key == "gains":
        wrong = [7, None, "x", [1]]
    value = wrong[int(rng.integers(len(wrong)))]
    fits = (isinstance(value, str) and key in ("robot", "plant", "law", "integrator")) or (
        value == 7 and key in ("steps", "evaluations")
    )
    if fits or (key == "columns" and value is None):
        value = 1e400
    about[key] = value
    columns["about"] = np.array(json.dumps(about))
    return _npz(columns), True


def _random(rng: Random, _: bytes) -> tuple[bytes, bool]:
    heads = [b"", b"PK\x03\x04", b"PK\x05\x06" + bytes(18), b"\x93NUMPY\x01\x00", b"\x80\x04"]
    return heads[int(rng.integers(len(heads)))] + rng.bytes(int(rng.integers(0, 3000))), True


KINDS: Mapping[str, Callable[[Random, bytes], tuple[bytes, bool]]] = {
    "flipped": _flipped, "cut": _cut, "overwritten": _overwritten, "removed": _removed, "extended": _extended,
    "members": _members, "bomb": _bomb, "typed": _typed, "shaped": _shaped, "valued": _valued, "words": _words,
    "random": _random,
}  # fmt: skip
"""Ways to spoil a file: the spoiled bytes, and whether they must be refused."""
