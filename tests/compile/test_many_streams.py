"""Many runs in chunks are the runs at once; a file is whole, or says where it stopped."""

from __future__ import annotations

import json
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cutjoint.compile import compiled, simulate_many
from cutjoint.compile.many.results import SAMPLED, Many
from cutjoint.control import PD
from cutjoint.errors import InputError
from cutjoint.motion import Circle, Reference
from cutjoint.papers.cpm.published import CIRCLE
from cutjoint.simulation.hardware import Clock, Differences, Encoder, Hardware

ALL = (*SAMPLED, "error_rms", "error_max", "effort_max")
HARDWARE = Hardware(Clock(1000.0), Encoder(resolution=1e-5, noise=1e-6), Differences(100.0))


@pytest.fixture(scope="module")
def settings(kit: Any) -> dict[str, Any]:
    """37 runs; one of them leaves its limbs' reach."""
    paper = kit.model("paper cpm")
    reference = Reference(Circle(CIRCLE.centre, CIRCLE.radius, CIRCLE.omega), paper, 0.02)
    rng = np.random.default_rng(0)
    speed = np.zeros((37, 3))
    speed[11, 1] = 60.0
    return {
        "plant": compiled(paper, parameters=["payload"]),
        "law": PD(1.0, 300.0),
        "reference": reference,
        "gains": {"kp": rng.uniform(6e3, 9e3, (37, 3))},
        "parameters": {"payload": rng.uniform(0.0, 1.0, 37)},
        "start": reference.at(0.0).q + 1e-3 * rng.normal(size=(37, 3)),
        "start_velocity": speed,
        "hardware": HARDWARE,
        "step": 1e-3,
    }


@pytest.mark.parametrize("chunk", [1, 8, 10, 36, 37, 1000])
def test_chunks_are_the_whole(settings: dict[str, Any], chunk: int) -> None:
    whole = simulate_many(every=5e-3, **settings)
    assert set(whole.failed) == {11}
    chunks: list[tuple[int, Many]] = []
    done: list[float] = []
    summary = simulate_many(
        every=5e-3,
        into=lambda first, many: chunks.append((first, many)),
        chunk=chunk,
        progress=done.append,
        **settings,
    )
    assert [first for first, _ in chunks] == list(range(0, 37, chunk))
    for name in ALL:
        found = np.concatenate([getattr(many, name) for _, many in chunks])
        np.testing.assert_allclose(found, getattr(whole, name), rtol=1e-12, atol=1e-13)
    assert {first + k for first, many in chunks for k in many.failed} == {11}
    assert (summary.runs, summary.failed, summary.slow) == (37, 1, 0)
    assert done == sorted(done)
    assert done[-1] == pytest.approx(1.0)
    kept = np.arange(37) != 11
    for name in ("error_rms", "error_max", "effort_max"):
        rows, one = getattr(whole, name)[kept], getattr(summary, name)
        assert one.count == 36
        np.testing.assert_allclose(one.mean, rows.mean(axis=0), rtol=1e-13)
        np.testing.assert_allclose(one.variance, rows.var(axis=0, ddof=1), rtol=1e-11)
        np.testing.assert_allclose(one.smallest, rows.min(axis=0), rtol=1e-12)
        np.testing.assert_allclose(one.largest, rows.max(axis=0), rtol=1e-12)


def test_a_file_holds_all_of_it(settings: dict[str, Any], tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    whole = simulate_many(every=5e-3, **settings)
    path = tmp_path / "runs.parquet"
    summary = simulate_many(every=5e-3, into=path, chunk=10, **settings)
    assert summary.runs == 37
    assert [one.name for one in tmp_path.iterdir()] == ["runs.parquet"]
    file = parquet.ParquetFile(path)
    assert [file.metadata.row_group(k).num_rows for k in range(file.num_row_groups)] == [10, 10, 10, 7]
    table = file.read()
    about = json.loads(table.schema.metadata[b"cutjoint"])
    np.testing.assert_allclose(about["time"], whole.time)
    assert about["hardware"]["encoder"]["noise"] == 1e-6
    assert table["run"].to_pylist() == list(range(37))
    assert [k for k, why in enumerate(table["failed"].to_pylist()) if why is not None] == [11]
    assert not any(table["slow"].to_pylist())
    np.testing.assert_array_equal(table["payload"], settings["parameters"]["payload"])
    for k, one in enumerate(settings["plant"].actuators):
        np.testing.assert_array_equal(table[f"kp_{one.name}"], settings["gains"]["kp"][:, k])
        np.testing.assert_array_equal(table[f"start_{one.name}"], settings["start"][:, k])
        for name in ("error_rms", "error_max", "effort_max"):
            np.testing.assert_allclose(table[f"{name}_{one.name}"], getattr(whole, name)[:, k], rtol=1e-12)
        for name in SAMPLED:
            if name != "positions":
                found = np.array(table[f"{name}_{one.name}"].to_pylist(), dtype=float)
                np.testing.assert_allclose(found, getattr(whole, name)[:, :, k], rtol=1e-12, atol=1e-13)
    found = np.array(table["positions"].to_pylist(), dtype=float).reshape(whole.positions.shape)
    np.testing.assert_allclose(found, whole.positions, rtol=1e-12)


def test_without_samples_a_file_has_only_errors(settings: dict[str, Any], tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    simulate_many(into=str(tmp_path / "runs.parquet"), **settings)
    names = parquet.read_schema(tmp_path / "runs.parquet").names
    assert "run" in names
    assert not [name for name in names if name.startswith(("q_", "positions", "measured"))]


@pytest.mark.parametrize(("stopped", "runs"), [(KeyboardInterrupt, 30), (RuntimeError, 20)])
def test_what_was_done_is_kept(
    settings: dict[str, Any], tmp_path: Path, stopped: type[BaseException], runs: int
) -> None:
    """Of an interrupt the runs of the chunk too that were done; other errors may be those of a run."""
    parquet = pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "runs.parquet"
    path.write_bytes(b"an older file")

    def stop(part: float) -> None:
        if part > 0.7:
            raise stopped("enough")

    with pytest.raises(stopped) as caught:
        simulate_many(into=path, chunk=10, progress=stop, threads=1, **settings)
    assert path.read_bytes() == b"an older file"
    assert sorted(one.name for one in tmp_path.iterdir()) == ["runs.parquet", "runs.parquet.stopped"]
    table = parquet.read_table(tmp_path / "runs.parquet.stopped")
    assert table["run"].to_pylist() == list(range(runs))
    whole = simulate_many(**settings)
    np.testing.assert_allclose(
        table[f"error_rms_{settings['plant'].actuators[0].name}"], whole.error_rms[:runs, 0], rtol=1e-12
    )
    assert f"runs 0 to {runs - 1}" in "".join(caught.value.__notes__)


def test_nothing_is_left_of_a_start_that_fails(settings: dict[str, Any], tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")

    def stop(part: float) -> None:
        raise RuntimeError

    with pytest.raises(RuntimeError):
        simulate_many(into=tmp_path / "runs.parquet", progress=stop, **settings)
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="does not exist"):
        simulate_many(into=tmp_path / "none" / "runs.parquet", **settings)
    with pytest.raises(InputError, match="into of simulate_many must be a function"):
        simulate_many(into=3, **settings)
    with pytest.raises(InputError, match="chunk must be"):
        simulate_many(into=print, chunk=0, **settings)


def test_memory_does_not_grow_with_the_runs(settings: dict[str, Any], tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    few = {name: settings[name] for name in ("plant", "law", "reference", "hardware")}
    few["gains"] = {"kp": [7e3]}

    def peak(chunks: int) -> int:
        tracemalloc.start()
        try:
            simulate_many(runs=256 * chunks, every=1e-3, chunk=256, into=tmp_path / "runs.parquet", **few)
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    peak(1)
    assert peak(12) < 1.3 * peak(3)
