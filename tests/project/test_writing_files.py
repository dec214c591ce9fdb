"""Files are written whole or not at all, several at once too."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from cutjoint.errors import InputError
from cutjoint.files import write_files, write_whole


def test_new_files_are_ordinary_and_those_of_a_cache_private(tmp_path: Path) -> None:
    mask = os.umask(0o022)
    try:
        assert write_files({tmp_path / "a": b"1", tmp_path / "b": b"2"}) == (tmp_path / "a", tmp_path / "b")
        write_files({tmp_path / "c": b"3"}, private=True)
    finally:
        os.umask(mask)
    assert [(tmp_path / name).read_bytes() for name in "abc"] == [b"1", b"2", b"3"]
    assert [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in "abc"] == [0o644, 0o644, 0o600]


def test_nothing_changes_where_one_of_several_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"old")
    with pytest.raises(OSError, match="missing"):
        write_files({tmp_path / "a": b"new", tmp_path / "missing" / "b": b"new"})
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_bytes() == b"old"


def test_a_refused_replacement_leaves_no_neighbour(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(28, "no room")

    (tmp_path / "a").write_text("old")
    monkeypatch.setattr("cutjoint.files.os.replace", refuse)
    with pytest.raises(InputError, match=r"cannot write .*: no room"):
        write_whole(tmp_path / "a", "new")
    assert [path.read_text() for path in tmp_path.iterdir()] == ["old"]


def test_no_file_takes_the_place_of_a_pipe_or_device(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(OSError, match="give a file name"):
        write_files({tmp_path / "one": b"1", pipe: b"2"})
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert [one.name for one in tmp_path.iterdir()] == ["pipe"]
