"""Workspaces on disk: what is read is what was written, what is damaged or strange is refused."""

from __future__ import annotations

import json
import subprocess
import sys
import zlib
from base64 import b64decode
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from kit.regions import ball, random_region, region

from cutjoint.errors import InputError, ResultFileError
from cutjoint.workspace import Workspace, load, save

SEEDS = [0, *(pytest.param(one, marks=pytest.mark.slow) for one in range(1, 12))]


def same(a: Workspace, b: Workspace) -> None:
    assert (a.robot, a.extent, a.told) == (b.robot, b.extent, b.told)
    assert dict(a.held) == dict(b.held)
    assert [(x.name, x.unit) for x in a.axes] == [(x.name, x.unit) for x in b.axes]
    assert list(a.maps) == list(b.maps)
    pairs = [(x.values, y.values) for x, y in zip(a.axes, b.axes, strict=True)]
    pairs += [(a.inside, b.inside), (a.q, b.q)]
    for name, one in a.maps.items():
        assert (one.title, one.unit, one.best) == (
            b.maps[name].title,
            b.maps[name].unit,
            b.maps[name].best,
        )
        pairs.append((one.values, b.maps[name].values))
    for x, y in pairs:
        assert x.dtype == y.dtype
        assert not y.flags.writeable
        np.testing.assert_array_equal(x, y)


@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_saved_is_loaded(axes: int, seed: int, tmp_path: Path) -> None:
    made = random_region(seed, axes)
    same(made, load(save(made, tmp_path / "w.npz")))


def arrays_of(file: Path) -> dict[str, np.ndarray]:
    """The arrays of a .vti file, as its format says."""
    found = {}
    for one in ElementTree.parse(file).iter("DataArray"):
        text = (one.text or "").encode()
        count = int(np.frombuffer(b64decode(text[:12])[:8], "<u8")[0])
        head_size = -(-(8 * (3 + count)) // 3) * 4
        head = np.frombuffer(b64decode(text[:head_size]), "<u8")
        packed, content = b64decode(text[head_size:]), b""
        for size in head[3:]:
            content += zlib.decompress(packed[: int(size)])
            packed = packed[int(size) :]
        assert len(content) == (count - (head[2] > 0)) * head[1] + head[2]
        kind = {"UInt8": "u1", "Float64": "<f8"}[one.attrib["type"]]
        found[one.attrib["Name"]] = np.frombuffer(content, kind).reshape(-1, int(one.attrib["NumberOfComponents"]))
    return found


@pytest.mark.parametrize("axes", [1, 2, 3])
@pytest.mark.parametrize("seed", SEEDS)
def test_vtk_images_hold_every_cell(axes: int, seed: int, tmp_path: Path) -> None:
    made = random_region(seed, axes)
    file = save(made, tmp_path / "w.vti")
    image = next(ElementTree.parse(file).iter("ImageData"))
    start, steps = (np.array(image.attrib[name].split(), dtype=float) for name in ("Origin", "Spacing"))
    sizes = np.array(image.attrib["WholeExtent"].split(), dtype=int)[1::2] + 1
    found = arrays_of(file)
    for axis, first, step, size in zip(made.axes, start, steps, sizes, strict=False):
        np.testing.assert_allclose(first + step * np.arange(size), axis.values, rtol=1e-12, atol=1e-9 * step)
    wanted = {"inside": made.inside, "condition": made.maps["condition"].values}
    wanted["speed [m/s]"] = made.maps["speed"].values
    for name, values in wanted.items():
        np.testing.assert_array_equal(found[name][:, 0], values.ravel(order="F"))
    flat = np.stack([made.q[..., k].ravel(order="F") for k in range(made.q.shape[-1])], axis=1)
    np.testing.assert_array_equal(found["q"], flat)


@pytest.mark.slow
def test_parquet_has_a_row_a_reached_cell(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    made = region(ball, 9, names=("x", "y", "rz"))
    table = parquet.read_table(save(made, tmp_path / "w.parquet"), use_threads=False)
    assert table.column_names == ["x", "y", "rz", "q1", "q2", "q3", "condition", "speed"]
    np.testing.assert_array_equal(np.column_stack([table[name] for name in ("x", "y", "rz")]), made.points)
    np.testing.assert_array_equal(table["speed"], made.maps["speed"].values[made.inside])
    units = {field.name: (field.metadata or {}).get(b"unit") for field in table.schema}
    assert (units["x"], units["rz"], units["speed"], units["condition"]) == (b"m", b"rad", b"m/s", None)
    about = json.loads(table.schema.metadata[b"cutjoint"])
    assert (about["robot"], about["held"]) == ("drawn", {"rz": 0.25})


@pytest.mark.slow
def test_a_process_with_a_robot_writes_parquet_and_ends_well(tmp_path: Path) -> None:
    """Threads of pyarrow and those of Pinocchio in one process were seen to abort at its end."""
    pytest.importorskip("pyarrow")
    code = (
        "import sys, cutjoint; from cutjoint.workspace import save, workspace\n"
        "save(workspace(cutjoint.load('fivebar'), cells=8), sys.argv[1])\n"
        "from pyarrow.parquet import read_table\n"
        "print(read_table(sys.argv[1], use_threads=False).num_rows)"
    )
    for k in range(2):
        command = [sys.executable, "-c", code, str(tmp_path / f"{k}.parquet")]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")
        assert int(done.stdout) > 10


def test_places_are_looked_at(tmp_path: Path) -> None:
    made = region(ball, 5)
    for name in ("w.txt", "no/w.npz", "w"):
        with pytest.raises(InputError):
            save(made, tmp_path / name)
    with pytest.raises(ResultFileError, match="no such file"):
        load(tmp_path / "none.npz")


def changed(file: Path, to: Path, **new: object) -> Path:
    """A file with other arrays; None leaves one out, and what is a dict changes words of `about`."""
    with np.load(file) as old:
        arrays = {name: old[name] for name in old.files}
    for name, value in new.items():
        if isinstance(value, dict):
            value = json.dumps({**json.loads(str(arrays[name])), **value})
        if value is None:
            del arrays[name]
        else:
            arrays[name] = np.asarray(value)
    np.savez(to, **arrays)
    return to


def test_strange_files_are_refused(tmp_path: Path) -> None:
    made = region(ball, 6)
    file = save(made, tmp_path / "w.npz")
    other = np.ones((6, 6, 5))
    for new, told in (
        ({"kind": "other"}, "does not hold a workspace"),
        ({"kind": None}, "does not hold a workspace"),
        ({"schema": 9}, "schema 9"),
        ({"inside": None}, "lacks inside"),
        ({"more": other}, "also holds more"),
        ({"map0": other}, "do not fit"),
        ({"q": other}, "do not fit"),
        ({"inside": np.ones((6, 6, 6))}, "float64"),
        ({"map1": np.ones((6, 6, 6))}, "not reached"),
        ({"axis0": np.zeros(6)}, "evenly"),
        ({"axis1": np.array([0.0, 1, 2, 3, 4, np.nan])}, "evenly"),
        ({"about": {"axes": [["x", "m"]] * 3}}, "two of the axis"),
        ({"about": {"axes": [["x", "inch"], ["y", "m"], ["z", "m"]]}}, "inch"),
        ({"about": {"axes": 3}}, "'axes'"),
        ({"about": {"held": {"rz": "a"}}}, "'held'"),
        ({"about": {"extent": -1.0}}, "'extent'"),
        ({"about": {"extent": float("nan")}}, "'extent'"),
        ({"about": {"maps": [["a", "b", "", "most"]] * 2}}, "two of the map"),
        ({"about": {"robot": None}}, "'robot'"),
        ({"about": "[" * 100_000}, "does not hold"),
    ):
        with pytest.raises(ResultFileError, match=told):
            load(changed(file, tmp_path / "changed.npz", **new))
    same(made, load(changed(file, tmp_path / "changed.npz")))
    content = file.read_bytes()
    for cut in (0, 10, len(content) // 2, len(content) - 1):
        (tmp_path / "cut.npz").write_bytes(content[:cut])
        with pytest.raises(ResultFileError):
            load(tmp_path / "cut.npz")
