"""The cache folder: used when it is right, ignored and mended when it is anything else."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cutjoint.compile import Made, compiled, kept
from cutjoint.compile.expressions.program import Program
from cutjoint.compile.functions import cache

CALL = ([0.1, -0.2], [1.0, 2.0])


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache folder."""
    monkeypatch.setenv("CUTJOINT_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache" / "programs"


def made(kit: Any, **options: Any) -> tuple[Made, np.ndarray]:
    """Compile forward dynamics of the five-bar as a new process would, and call it."""
    reports: list[Made] = []
    machine = compiled(kit.model("fivebar"), report=reports.append, **options)
    return reports[0] if reports else _first(machine, reports), machine.forward_dynamics(machine.home, *CALL)


def _first(machine: Any, reports: list[Made]) -> Made:
    machine.kernel("forward")
    return reports[0]


class Fatal:
    """Something that would end this process if it were ever unpickled."""

    def __reduce__(self) -> Any:
        return os.abort, ()


def only_file(folder: Path) -> Path:
    (file,) = folder.iterdir()
    return file


def test_the_second_time_it_is_found(kit: Any, folder: Path) -> None:
    first, a = made(kit)
    second, b = made(kit)
    assert (first.cached, second.cached) == (False, True)
    np.testing.assert_array_equal(a, b)
    assert oct(folder.stat().st_mode & 0o777) == "0o700"
    assert oct(only_file(folder).stat().st_mode & 0o777) == "0o600"


def test_without_a_cache_nothing_is_written(kit: Any, folder: Path) -> None:
    assert not made(kit, cached=False)[0].cached
    assert not folder.exists()


@pytest.mark.parametrize("harm", ["empty", "truncated", "flipped", "foreign text", "foreign pickle", "other name"])
def test_a_damaged_file_is_replaced(kit: Any, folder: Path, harm: str) -> None:
    _, right = made(kit)
    file = only_file(folder)
    data = file.read_bytes()
    harmed = {
        "empty": b"",
        "truncated": data[: len(data) // 2],
        "flipped": data[:900] + bytes([data[900] ^ 1]) + data[901:],
        "foreign text": b"import os; os.abort()\n",
        "foreign pickle": pickle.dumps(Fatal()),
        "other name": b"0" * 64 + data[64:],
    }[harm]
    file.write_bytes(harmed)
    again, found = made(kit)
    assert not again.cached
    np.testing.assert_array_equal(found, right)
    assert file.read_bytes() == data
    assert made(kit)[0].cached


def forge(file: Path, change: Any) -> None:
    """Write a program that is right in form, with its own digest and the right name, but computes something else."""
    data = file.read_bytes()
    name, body = data[:65], data[65:]
    program = Program.from_bytes(body)
    values = np.array(program.values)
    change(values)
    parts = (program.op, program.operands, values, program.outputs)
    file.write_bytes(name + Program(program.name, program.arguments, program.results, *parts).to_bytes())


def test_a_forged_file_that_computes_something_else_is_not_used(kit: Any, folder: Path) -> None:
    _, right = made(kit)
    file = only_file(folder)

    def heavier(values: np.ndarray) -> None:
        values[values != 0.0] *= 1.0 + 1e-6

    forge(file, heavier)
    again, found = made(kit)
    assert not again.cached
    np.testing.assert_array_equal(found, right)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="owners and modes of POSIX")
def test_a_file_that_others_can_write_or_a_link_is_not_used(kit: Any, folder: Path, tmp_path: Path) -> None:
    made(kit)
    file = only_file(folder)
    file.chmod(0o666)
    assert not made(kit)[0].cached
    assert made(kit)[0].cached
    elsewhere = tmp_path / "elsewhere"
    elsewhere.write_bytes(file.read_bytes())
    file.unlink()
    file.symlink_to(elsewhere)
    assert not made(kit)[0].cached
    assert not file.is_symlink()
    folder.chmod(0o777)
    assert not made(kit)[0].cached
    folder.chmod(0o700)
    assert made(kit)[0].cached


def test_a_folder_that_cannot_be_written_is_no_error(kit: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    monkeypatch.setenv("CUTJOINT_CACHE", str(blocked))
    assert not made(kit)[0].cached
    assert blocked.read_text() == "not a folder"


def test_the_name_depends_on_model_code_and_options(kit: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    one, two = kit.machine("fivebar").source.content, kit.machine("fourbar").source.content
    heavier = kit.model("fivebar").with_payload(0.1)
    names = {
        cache.key(one, "forward", "a"),
        cache.key(two, "forward", "a"),
        cache.key(compiled(heavier).source.content, "forward", "a"),
        cache.key(compiled(kit.model("fivebar"), parameters=["payload"]).source.content, "forward", "a"),
        cache.key(one, "inverse", "a"),
        cache.key(one, "forward", "b"),
    }
    monkeypatch.setattr(cache, "code_version", lambda: "another version")
    names.add(cache.key(one, "forward", "a"))
    assert len(names) == 7
    assert all(len(name) == 64 and int(name, 16) >= 0 for name in names)


def test_the_version_is_the_source_text() -> None:
    assert cache.code_version() == cache.code_version()
    assert len(cache.code_version()) == len(sha256().hexdigest())
    files = dict(one for place in kept.DECISIVE for one in kept.sources(place))
    for name in ("compile/machine/llvm/text.py", "compile/equations/cut_rows.py", "papers/omega3/equations.py"):
        assert files[name]
    assert files["description/cuts.py"].startswith(b'"""The types of cut joints')


def test_two_processes_at_once(kit: Any, folder: Path) -> None:
    script = (
        "import numpy as np\n"
        "from cutjoint.compile import compiled\n"
        "from cutjoint.robots import load\n"
        "machine = compiled(load('fivebar'))\n"
        f"print(machine.forward_dynamics(machine.home, *{CALL!r}).tolist())\n"
    )
    running = [
        subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, env=dict(os.environ))
        for _ in range(2)
    ]
    answers = [process.communicate()[0] for process in running]
    assert [process.returncode for process in running] == [0, 0]
    assert answers[0] == answers[1]
    assert made(kit)[0].cached
    assert len(list(folder.iterdir())) == 1
    assert answers[0].strip() == str(made(kit)[1].tolist())


@pytest.mark.parametrize("part", ["arguments", "results"])
def test_a_program_that_takes_or_gives_other_things_is_not_used(kit: Any, folder: Path, part: str) -> None:
    """Right digest, right name, right numbers even, but not what this function of this model takes or gives."""
    _, right = made(kit)
    file = only_file(folder)
    data = file.read_bytes()
    program = Program.from_bytes(data[65:])
    named = tuple((f"{name}_", size) for name, size in getattr(program, part))
    file.write_bytes(data[:65] + replace(program, **{part: named}).to_bytes())
    again, found = made(kit)
    assert not again.cached
    np.testing.assert_array_equal(found, right)
    assert file.read_bytes() == data


# ---- machine code ------------------------------------------------------------------------------------------------


def code_of(folder: Path) -> Path:
    return only_file(folder.parent / "machine")


def without_llvm(monkeypatch: pytest.MonkeyPatch) -> None:
    """From here on, whoever compiles fails."""
    from cutjoint.compile.machine.llvm import native

    def refuse(*_: Any) -> None:
        raise AssertionError("compiled once more")

    monkeypatch.setattr(native, "_flat", refuse)


def test_machine_code_is_made_once(kit: Any, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _, right = made(kit)
    assert oct(code_of(folder).stat().st_mode & 0o777) == "0o600"
    without_llvm(monkeypatch)
    np.testing.assert_array_equal(made(kit)[1], right)
    with pytest.raises(AssertionError, match="once more"):
        made(kit, cached=False)


@pytest.mark.parametrize("harm", ["empty", "truncated", "flipped", "writable by others", "link"])
def test_machine_code_that_may_not_be_used_is_made_anew(kit: Any, folder: Path, tmp_path: Path, harm: str) -> None:
    _, right = made(kit)
    file = code_of(folder)
    data = file.read_bytes()
    if harm == "writable by others":
        file.chmod(0o666)
    elif harm == "link":
        (tmp_path / "elsewhere").write_bytes(data)
        file.unlink()
        file.symlink_to(tmp_path / "elsewhere")
    else:
        flipped = data[:900] + bytes([data[900] ^ 1]) + data[901:]
        file.write_bytes({"empty": b"", "truncated": data[: len(data) // 2], "flipped": flipped}[harm])
    np.testing.assert_array_equal(made(kit)[1], right)
    assert code_of(folder).read_bytes() == data
    assert not code_of(folder).is_symlink()
    assert oct(code_of(folder).stat().st_mode & 0o777) == "0o600"


def test_machine_code_of_something_else_is_not_used(kit: Any, folder: Path) -> None:
    """Right name, right digest, and the code of a heavier robot."""
    _, right = made(kit)
    file = code_of(folder)
    data = file.read_bytes()
    compiled(kit.model("fivebar").with_payload(0.1)).kernel("forward")
    (other,) = set((folder.parent / "machine").iterdir()) - {file}
    file.write_bytes(data[:65] + other.read_bytes()[65:])
    other.unlink()
    np.testing.assert_array_equal(made(kit)[1], right)
    assert code_of(folder).read_bytes() == data
