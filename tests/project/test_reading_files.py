"""Only ordinary files of a bounded size are read, whoever asks for one."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from cutjoint.control import efforts_from_csv
from cutjoint.description import Shape, load_description, read_checked
from cutjoint.description.meshes import read_meshes
from cutjoint.errors import CutjointError, FileError
from cutjoint.files import check_place, read_file
from cutjoint.motion.from_file import motion_from_file
from cutjoint.plugins import part
from cutjoint.robots import published
from cutjoint.simulation import load as load_result
from cutjoint.simulation.hardware.parts import read_hardware
from cutjoint.viewer.picture.shapes import load_mesh


@pytest.fixture
def hostile(tmp_path: Path) -> dict[str, str]:
    """Paths at which there is no file, by what there is."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "a").symlink_to(tmp_path / "b")
    (tmp_path / "b").symlink_to(tmp_path / "a")
    listening = socket.socket(socket.AF_UNIX)
    listening.bind(os.path.relpath(tmp_path / "socket"))  # such names are short
    with (tmp_path / "huge").open("wb") as file:
        file.truncate(10**11)
    return {
        "a pipe": str(tmp_path / "pipe"),
        "a socket": str(tmp_path / "socket"),
        "a device": "/dev/zero",
        "a directory": str(tmp_path),
        "lead to each other": str(tmp_path / "a"),
        "MB are read": str(tmp_path / "huge"),
        "zero byte": f"{tmp_path}/x\0y",
        "of 300 bytes": str(tmp_path / ("n" * 300)),
        "too long": str(tmp_path) + "/d" * 3000,
        "no file name of this system": f"{tmp_path}/\ud800",
        "no such file": str(tmp_path / "none"),
        "an empty name": "",
    }


def test_each_is_refused_in_words(hostile: dict[str, str]) -> None:
    for why, path in hostile.items():
        with pytest.raises(FileError, match=why) as caught:
            read_file(path, 10**6)
        assert caught.value.missing == (why == "no such file")
        assert len(str(caught.value)) < 400


READERS: dict[str, Callable[[str], object]] = {
    "a robot": lambda path: load_description(Path(path)),
    "a result": load_result,
    "hardware": read_hardware,
    "a mesh": lambda path: read_meshes(Path(path)),
    "a shape": lambda path: load_mesh(Shape("mesh", (1.0, 1.0, 1.0), mesh=Path(path))),
    "efforts": lambda path: efforts_from_csv(path, published("cpm").actuators),
    "a motion": lambda path: motion_from_file(path, published("cpm")),
    "a part": lambda path: part(f"{path}.py:Name"),
}


@pytest.mark.parametrize("reader", READERS)
def test_no_reader_waits_for_a_pipe_or_reads_a_device(hostile: dict[str, str], reader: str) -> None:
    for path in hostile.values():
        with pytest.raises(CutjointError):
            READERS[reader](path)


def test_a_file_that_a_file_names_is_looked_at_too(hostile: dict[str, str], tmp_path: Path) -> None:
    for why in ("a pipe", "a device", "a socket"):
        loops = tmp_path / "loops.toml"
        loops.write_text(f'schema = 1\nurdf = "{hostile[why]}"\nactuators = ["a"]\n')
        problems = read_checked(loops).problems
        assert any(why in one.found for one in problems), problems


def test_what_is_written_goes_to_files_only(hostile: dict[str, str]) -> None:
    for why in ("a pipe", "a device", "a socket", "of 300 bytes", "zero byte"):
        with pytest.raises(CutjointError):
            check_place(hostile[why])


def test_a_file_that_is_read_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "whole"
    content = bytes(range(256)) * 10_000
    path.write_bytes(content)
    assert read_file(path, len(content)) == content
    with pytest.raises(FileError, match="at most"):
        read_file(path, len(content) - 1)
