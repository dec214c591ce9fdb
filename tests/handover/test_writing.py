"""Joint states on disk: read back by other programs they are the same numbers."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import cutjoint
from cutjoint.cli import app
from cutjoint.errors import InputError, MissingPackageError
from cutjoint.handover import CarriedChild, JointStates, check_target, write
from cutjoint.simulation import ConstrainedPlant, run, save

RANDOM = np.random.default_rng(0)
TURNS = RANDOM.normal(size=(3, 4))
STATES = JointStates(
    time=np.array([0.0, 1.001, 12.000000001]),
    names=("slide", "hinge"),
    position=RANDOM.normal(size=(3, 2)),
    velocity=RANDOM.normal(size=(3, 2)),
    effort=RANDOM.normal(size=(3, 2)),
    carried=(
        CarriedChild(
            "ball", "arm", "cup", RANDOM.normal(size=(3, 3)), TURNS / np.linalg.norm(TURNS, axis=1, keepdims=True)
        ),
    ),
)
NANOSECONDS = [0, 1_001_000_000, 12_000_000_001]


def from_lines(file: Path) -> Mapping[str, list[dict[str, object]]]:
    """Topic -> fields of its messages; what is published was advertised before."""
    kinds, found = {}, defaultdict(list)
    for line in map(json.loads, file.read_text(encoding="utf-8").splitlines()):
        if line["op"] == "advertise":
            kinds[line["topic"]] = line["type"]
        else:
            assert line["op"] == "publish"
            assert line["topic"] in kinds
            found[line["topic"]].append(line["msg"])
    assert set(kinds) == set(found)
    return found


def from_bag(folder: Path) -> Mapping[str, list[dict[str, object]]]:
    """The same of a rosbag2, as the library rosbags reads it."""
    rosbag2, typesys = pytest.importorskip("rosbags.rosbag2"), pytest.importorskip("rosbags.typesys")
    types, found = typesys.get_typestore(typesys.Stores.ROS2_JAZZY), defaultdict(list)
    with rosbag2.Reader(folder) as bag:
        for connection, time, raw in bag.messages():
            fields = plain(types.deserialize_cdr(raw, connection.msgtype))
            assert isinstance(fields, dict)
            found[connection.topic].append(fields)
            stamped = fields if "header" in fields else fields["transforms"][0]
            stamp = stamped["header"]["stamp"]
            assert time == stamp["sec"] * 10**9 + stamp["nanosec"]
    return found


def plain(message: object) -> object:
    """A message of rosbags as plain values."""
    if hasattr(message, "__dataclass_fields__"):
        names = [name for name in message.__dataclass_fields__ if name != "__msgtype__"]
        return {name: plain(getattr(message, name)) for name in names}
    if isinstance(message, np.ndarray):
        return message.tolist()
    return [plain(one) for one in message] if isinstance(message, list) else message


@pytest.mark.parametrize(
    ("name", "read"), [("run.jsonl", from_lines), pytest.param("run", from_bag, marks=pytest.mark.slow)]
)
def test_what_is_read_back_is_what_was_written(tmp_path: Path, name: str, read: object) -> None:
    assert write(STATES, tmp_path / name) == tmp_path / name
    assert callable(read)
    found = read(tmp_path / name)
    assert set(found) == {"/joint_states", "/tf"}
    assert len(found["/joint_states"]) == len(found["/tf"]) == 3
    for i, (joints, placed) in enumerate(zip(found["/joint_states"], found["/tf"], strict=True)):
        stamp = {"sec": NANOSECONDS[i] // 10**9, "nanosec": NANOSECONDS[i] % 10**9}
        assert joints["header"] == {"stamp": stamp, "frame_id": ""}
        assert joints["name"] == ["slide", "hinge"]
        for what in ("position", "velocity", "effort"):
            assert joints[what] == getattr(STATES, what)[i].tolist()
        (one,) = placed["transforms"]
        assert one["header"] == {"stamp": stamp, "frame_id": "arm"}
        assert one["child_frame_id"] == "cup"
        ball = STATES.carried[0]
        assert list(one["transform"]["translation"].values()) == ball.position[i].tolist()
        assert [one["transform"]["rotation"][axis] for axis in "xyzw"] == ball.orientation[i].tolist()
    assert [file.name for file in tmp_path.iterdir()] == [name]  # nothing is left beside it


def test_a_topic_without_messages_is_not_there(tmp_path: Path) -> None:
    empty = np.zeros((3, 0))
    only = JointStates(STATES.time, STATES.names, STATES.position, empty, STATES.effort)
    found = from_lines(write(only, tmp_path / "run.jsonl"))
    assert set(found) == {"/joint_states"}
    assert all(one["velocity"] == [] for one in found["/joint_states"])


def test_where_it_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"'\.csv'; known: '\.jsonl'"):
        check_target(tmp_path / "run.csv")
    with pytest.raises(InputError, match=r"no such folder|does not exist|not there"):
        check_target(tmp_path / "nowhere" / "run.jsonl")
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "mine").write_text("kept")
    with pytest.raises(InputError, match="there already"):
        write(STATES, tmp_path / "bag")
    assert (tmp_path / "bag" / "mine").read_text() == "kept"


def test_without_rosbags_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "rosbags", None)
    with pytest.raises(MissingPackageError, match=r"cutjoint\[ros\]"):
        check_target(tmp_path / "bag")
    check_target(tmp_path / "run.jsonl")


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of a five-bar."""
    chain = cutjoint.load("fivebar")
    file = tmp_path_factory.mktemp("runs") / "run.npz"
    save(run(ConstrainedPlant(chain), duration=0.01, every=0.005), file)
    return file


def test_the_command_writes_what_the_function_does(saved: Path, tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["states", str(saved), "-o", str(tmp_path / "run.jsonl")], catch_exceptions=False)
    assert done.exit_code == 0
    assert "3 samples of 4 joints" in done.stdout
    assert len(from_lines(tmp_path / "run.jsonl")["/joint_states"]) == 3


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["{run}", "-o", "{folder}/run.txt"], "joint states are not written as"),
        (["{run}.csv", "-o", "{folder}/run.jsonl"], "CSV files are not read; give the .npz"),
        (["{run}", "-o", "{folder}/run.jsonl", "--robot", "stewart"], "not of the chain stewart"),
    ],
)
def test_the_command_says_what_is_wrong(saved: Path, tmp_path: Path, arguments: list[str], told: str) -> None:
    words = [one.format(run=saved, folder=tmp_path) for one in arguments]
    done = CliRunner().invoke(app, ["states", *words])
    assert isinstance(done.exception, InputError)
    assert told in str(done.exception)
    assert list(tmp_path.iterdir()) == []
