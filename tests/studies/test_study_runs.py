"""A study gives the same table whoever simulates its blocks, in whatever order, however often it is killed."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.control import PD
from cutjoint.description import with_values
from cutjoint.errors import ActuationError, CutjointError, InputError, Interrupted, StudyError
from cutjoint.motion import Reference
from cutjoint.motion.catalogue import trajectory
from cutjoint.report.answers.study import scale_of, study_page
from cutjoint.robots import load
from cutjoint.simulation import ReducedPlant, RungeKutta4, run
from cutjoint.simulation.hardware import Clock, Drive, Encoder, Hardware
from cutjoint.studies import begun, read_study, run_study, summary_of, table_of
from cutjoint.studies.blocks import BlockPlan, Prepared, digest
from cutjoint.studies.cases import recipe_of
from cutjoint.studies.sampling import drawn

ROOT = Path(__file__).resolve().parents[2]
STUDY = """
robot = "fivebar"
method = "latin-hypercube"
runs = 900
block = 64
seed = 11
duration = 0.2
trajectory = "about-home:0.1,0.2"
[controller]
name = "pd"
gains = { kp = 20.0, kd = 1.0 }
[hardware]
rate = 500.0
noise = 1e-5
delay = 2e-3
filter = 100.0
[[vary]]
path = "links.left_distal.mass"
relative = 0.3
[[vary]]
path = "gains.kp"
normal = [20.0, 2.0]
[[vary]]
path = "start.left_shoulder"
uniform = [-0.01, 0.01]
[keep]
columns = ["error_rms", "effort_max", "energy", "tool_error_max", "speed_max", "effort_rms", "power_max"]
every = 0.01
"""


def written(folder: Path, text: str = STUDY) -> Path:
    file = folder / "wear.toml"
    file.write_text(text)
    return file


def sums(folder: Path) -> dict[str, str]:
    """Digests of the files of all blocks."""
    return {one.name: digest(one.read_bytes()) for one in sorted((folder / "parts").iterdir())}


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the study, run without any trouble."""
    folder = tmp_path_factory.mktemp("plain")
    return run_study(written(folder), folder / "runs")


@pytest.mark.slow
def test_a_run_of_a_study_is_the_run_alone(plain: Path) -> None:
    table, study = table_of(plain), read_study(plain.parent / "wear.toml")
    spreads = recipe_of(study).cases[0].spreads
    values = drawn(study.method, spreads, 900, 11, 0, 900)
    chain, hardware = load("fivebar"), study.hardware[0][1]
    reference = Reference(trajectory("about-home:0.1,0.2", chain), chain, 0.2)
    assert np.array_equal(table["run"], np.arange(900))
    for k in (0, 130, 899):
        assert np.array_equal([table[one.path][k] for one in study.varied], values[k])
        mass, kp, away = values[k]
        inertial = chain.description.link("left_distal").inertial
        assert inertial is not None
        robot = ClosedChain(with_values(chain.description, {"links.left_distal.mass": mass}))
        start = reference.at(0.0).q + np.array([away, 0.0])
        alone = run(
            ReducedPlant(robot),
            PD(kp, 1.0),
            reference,
            integrator=RungeKutta4(1e-3),
            hardware=hardware,
            run_number=k,
            start=robot.close(start),
            duration=0.2,
        )
        error = np.sqrt(np.mean((alone.desired_q - alone.q) ** 2, axis=0))
        names = [one.name for one in chain.actuators]
        assert np.allclose([table[f"error_rms_{one}"][k] for one in names], error, rtol=1e-9)
        assert np.allclose([table[f"effort_max_{one}"][k] for one in names], np.abs(alone.effort).max(axis=0))
        some = slice(None, None, 10)
        assert np.allclose(alone.time[some], np.arange(0.0, 0.205, 0.01))
        power = np.abs(alone.effort[some] * alone.v[some])
        assert np.isclose(table["energy"][k], np.trapezoid(power, alone.time[some], axis=0).sum(), rtol=1e-8)
        assert np.allclose([table[f"speed_max_{one}"][k] for one in names], np.abs(alone.v[some]).max(axis=0))
        away_from = np.linalg.norm(alone.tool[some] - alone.desired_tool[some], axis=1)
        assert np.isclose(table["tool_error_max"][k], away_from.max(), rtol=1e-8)


@pytest.mark.slow
def test_blocks_are_the_same_of_any_size_and_order(plain: Path, tmp_path: Path) -> None:
    whole = table_of(plain)
    prepared = Prepared(recipe_of(read_study(plain.parent / "wear.toml")))
    for size in (1, 7, 256):
        plan = BlockPlan(1, 900, size)
        for block in (plan.count - 1, 0):
            span = plan.span(block)
            table = prepared.rows(span)
            for name, values in whole.items():
                assert np.array_equal(table.column(name).to_numpy(), values[span.begin : span.end]), (size, name)
    assert run_study(written(tmp_path), tmp_path / "one", workers=1)
    assert sums(tmp_path / "one") == sums(plain)


@pytest.mark.slow
def test_one_that_was_interrupted_goes_on(plain: Path, tmp_path: Path) -> None:
    file, folder = written(tmp_path), tmp_path / "runs"

    def stop(done: float) -> None:
        if done > 300:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted, match="the same command goes on") as found:
        run_study(file, folder, progress=stop)
    assert 0.0 < found.value.done < 1.0
    before = summary_of(folder)
    assert 0 < before.runs < 900
    assert "of 900 runs are done" in before.told[0]
    with begun(file, folder) as ready, begun(file, folder) as second:
        assert ready.estimate.done == len(sums(folder))

        def also(_: float) -> None:
            with pytest.raises(InputError, match="another process is at the study"):
                second.run()

        ready.run(also)
        with pytest.raises(InputError, match="meanwhile"):
            second.run()
    assert sums(folder) == sums(plain)
    assert run_study(file, folder) == folder  # nothing left to do
    assert sums(folder) == sums(plain)
    one, other = summary_of(folder), summary_of(plain)
    for a, b in zip(one.columns, other.columns, strict=True):
        assert (a.mean, a.deviation, a.least, a.largest) == (b.mean, b.deviation, b.least, b.largest)
        assert np.array_equal(a.quantiles, b.quantiles)
    assert one.rankings == other.rankings
    everything = table_of(plain)
    for one_column in other.columns:
        values = everything[one_column.column]
        assert np.isclose(one_column.mean, values.mean(), rtol=1e-12)
        assert np.isclose(one_column.deviation, values.std(ddof=1), rtol=1e-9)
        assert np.allclose(one_column.quantiles, np.quantile(values, [0.05, 0.25, 0.5, 0.75, 0.95]))
        assert one_column.counts.sum() == 900


def stopped_by(file: Path, folder: Path, trouble: Callable[[], None]) -> str:
    """What a study says to which something happens on the way."""
    happened: list[bool] = []

    def look(done: float) -> None:
        if done > 200 and not happened:
            happened.append(True)
            trouble()

    with pytest.raises(CutjointError) as found:
        run_study(file, folder, progress=look)
    return str(found.value)


@pytest.mark.slow
def test_what_happens_to_the_disk_is_told_and_mended(plain: Path, tmp_path: Path) -> None:
    resource = pytest.importorskip("resource")
    file, folder = written(tmp_path), tmp_path / "runs"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:  # a disk that is full: no file can be written beyond so many bytes
        full = stopped_by(file, folder, lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1])))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert "cannot be written" in full or "too large" in full
    gone = stopped_by(file, folder, lambda: shutil.rmtree(folder))
    assert str(folder) in gone
    run_study(file, folder)
    assert sums(folder) == sums(plain)
    part = folder / "parts" / "part-000002.parquet"
    content = part.read_bytes()
    for damaged in (content[:-20], content[:200] + bytes([content[200] ^ 1]) + content[201:]):
        part.write_bytes(damaged)
        for read in (summary_of, table_of, lambda place: begun(file, place)):
            with pytest.raises(StudyError, match=r"block 2 in .* is not as it was written"):
                read(folder)


@pytest.mark.slow
def test_numbers_of_hardware_are_those_of_the_run_alone(tmp_path: Path) -> None:
    varied = [("hardware.noise", "log-uniform = [1e-6, 1e-3]"), ("hardware.limits", "relative = 0.5")]
    text = text_with(varied, runs="20", seed="4") + "\n[hardware]\nrate = 500.0\nnoise = 1e-5\nlimits = [0.9, 1.2]\n"
    file = written(tmp_path, text.replace('name = "pd"', 'name = "pd"\ngains = { kp = 20.0, kd = 1.0 }', 1))
    table = table_of(run_study(file, tmp_path / "runs"))
    chain = load("fivebar")
    for k in (0, 13):
        limits = tuple(table["hardware.limits"][k] * np.array([0.9, 1.2]))
        hardware = Hardware(Clock(500.0), Encoder(noise=table["hardware.noise"][k]), drive=Drive(limits), seed=4)
        way = Reference(trajectory("about-home", chain), chain, 0.05)
        alone = run(
            ReducedPlant(chain), PD(20.0, 1.0), way, integrator=RungeKutta4(1e-3), hardware=hardware, run_number=k
        )
        for name, error, effort in zip(
            [one.name for one in chain.actuators],
            np.abs(alone.desired_q - alone.q).max(axis=0),
            np.abs(alone.effort).max(axis=0),
            strict=True,
        ):
            assert np.isclose(table[f"error_max_{name}"][k], error, rtol=1e-9)
            assert np.isclose(table[f"effort_max_{name}"][k], effort, rtol=1e-9)


def command(*words: str, folder: Path) -> subprocess.Popen[str]:
    """`cutjoint study` in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "cutjoint", "study", *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT / "src")},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.slow
def test_one_that_was_killed_goes_on(plain: Path, tmp_path: Path) -> None:
    written(tmp_path)
    for _ in range(3):
        killed = command("wear.toml", "-o", "runs", "--no-report", "--workers", "1", folder=tmp_path)
        parts, before = tmp_path / "runs" / "parts", 0
        if parts.exists():
            before = len(list(parts.iterdir()))
        until = time.monotonic() + 120.0
        while killed.poll() is None and time.monotonic() < until:
            if parts.exists() and len(list(parts.iterdir())) > before:
                break
            time.sleep(0.002)
        killed.send_signal(signal.SIGKILL)
        killed.communicate()
    left = tmp_path / "runs" / "parts" / ".part-000001.parquet.0123456789ab"  # as a kill just then leaves one
    left.write_bytes(b"whole, and not yet in its place")
    ended = command("wear.toml", "-o", "runs", "--no-report", "--json", folder=tmp_path)
    out, err = ended.communicate(timeout=300)
    assert ended.returncode == 0, err
    assert json.loads(out)["runs"] == 900
    assert [one.name for one in (tmp_path / "runs").rglob("*") if one.name.startswith(".")] == []
    assert sums(tmp_path / "runs") == sums(plain)


@pytest.mark.slow
def test_a_cluster_that_loses_a_worker_loses_nothing(
    plain: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed = pytest.importorskip("distributed")
    # Workers see the source by this process's path; a dashboard would take a port.
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs=50
    ) as cluster:
        killed: list[int] = []

        def stop(done: float) -> None:
            if done > 64:
                raise KeyboardInterrupt

        with (
            begun(written(tmp_path), tmp_path / "runs", scheduler=cluster.scheduler_address) as ready,
            pytest.raises(Interrupted, match="the same command goes on"),
        ):
            ready.run(stop)
        assert 0 < len(sums(tmp_path / "runs")) < 15

        def kill(done: float) -> None:
            if done > 128 and not killed:
                killed.append(next(iter(cluster.workers.values())).process.pid)
                os.kill(killed[0], signal.SIGKILL)

        with begun(written(tmp_path), tmp_path / "runs", scheduler=cluster.scheduler_address) as ready:
            assert ready.cluster is not None
            assert ready.cluster.threads == 2
            ready.run(kill)
        assert killed
        usual = distributed.Client.get_versions

        def older(client: object, **options: object) -> dict[str, dict[str, dict[str, str]]]:
            found = usual(client, **options)
            found["client"]["packages"]["numpy"] = "0.1"
            return found

        monkeypatch.setattr(distributed.Client, "get_versions", older)
        with pytest.raises(InputError, match=r"has numpy .*, here is 0\.1.*same versions"):
            begun(written(tmp_path), tmp_path / "other", scheduler=cluster.scheduler_address)
    assert not (tmp_path / "other").exists()
    assert sums(tmp_path / "runs") == sums(plain)
    manifest = json.loads((tmp_path / "runs" / "manifest.json").read_text())
    assert sorted(map(int, manifest["done"])) == list(range(15))


@pytest.mark.slow
def test_the_page_of_a_study_has_all_of_it(plain: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    summary = summary_of(plain)
    page = study_page(summary)
    shown = [one.column for one in summary.columns]
    assert all(f"<td>{name}</td>" in page for name in shown)
    assert page.count("<figure>") == 3 * min(len(shown), 12)
    assert "http" not in page.replace("http://www.w3.org", "")
    for one in summary.columns:
        factor, unit = scale_of([one])
        assert 0.1 <= max(abs(one.least), abs(one.largest)) / factor < 1000.0 or unit == one.unit
    monkeypatch.setattr("cutjoint.report.answers.study.is_installed", lambda _: False)
    plainly = study_page(summary)
    assert "<figure>" not in plainly
    assert "cutjoint[report]" in plainly


@pytest.mark.slow
def test_another_study_in_the_folder_is_refused(plain: Path, tmp_path: Path) -> None:
    for text, told in (
        (STUDY.replace("seed = 11", "seed = 12"), "another study"),
        (STUDY.replace("block = 64", "block = 65"), "another study"),
    ):
        with pytest.raises(InputError, match=told):
            begun(written(tmp_path, text), plain)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "own.txt").write_text("mine")
    with pytest.raises(InputError, match="no folder of a study"):
        begun(written(tmp_path), tmp_path / "full")
    with pytest.raises(InputError, match="does not exist"):
        begun(written(tmp_path), tmp_path / "no" / "runs")
    (tmp_path / "killed" / "parts").mkdir(parents=True)
    with begun(written(tmp_path), tmp_path / "killed") as ready:
        assert ready.estimate.done == 0


@pytest.mark.slow
def test_a_folder_that_was_changed_is_told(plain: Path, tmp_path: Path) -> None:
    file, folder = written(tmp_path), tmp_path / "runs"
    shutil.copytree(plain, folder)
    manifest = folder / "manifest.json"
    whole = json.loads(manifest.read_text())
    for key, value, told in (
        ("processors", ["abacus 1"], "another kind of processor"),
        ("versions", {**whole["versions"], "numpy": "1.0"}, "other versions"),
        ("robot", "x", "another robot"),
        ("format", 0, "none of this version"),
    ):
        manifest.write_text(json.dumps({**whole, key: value}))
        with pytest.raises(InputError, match=told):
            begun(file, folder)
    manifest.write_text(json.dumps({**whole, "processors": ["abacus 1"]}))
    with begun(file, folder, any_processor=True) as ready:
        ready.run()
    assert len(json.loads(manifest.read_text())["processors"]) == 2
    manifest.write_text("{")
    with pytest.raises(InputError, match="damaged"):
        begun(file, folder)
    manifest.write_text(json.dumps(whole))
    part = folder / "parts" / "part-000003.parquet"
    content = bytearray(part.read_bytes())
    content[100] ^= 1
    part.write_bytes(content)
    with pytest.raises(StudyError, match="block 3"):
        begun(file, folder)
    part.unlink()
    with pytest.raises(StudyError, match="block 3"):
        begun(file, folder)
    rest = {block: one for block, one in whole["done"].items() if block != "3"}
    manifest.write_text(json.dumps({**whole, "done": rest}))
    run_study(file, folder)
    assert sums(folder) == sums(plain)


def text_with(spreads: Sequence[tuple[str, str]], **more: str) -> str:
    """A short study of a robot with other paths."""
    head = {"robot": '"fivebar"', "runs": "64", "duration": "0.05", **more}
    lines = [f"{name} = {value}" for name, value in head.items()]
    lines += ["[controller]", 'name = "pd"']
    for path, spread in spreads:
        lines += ["[[vary]]", f'path = "{path}"', spread]
    return "\n".join(lines)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spreads", "told"),
    [
        ((("joints.left_elbow.origin.x", "uniform = [0.2, 0.9]"),), "the robot cannot start"),
        ((("links.left_distal.inertia.xx", "uniform = [1e-6, 10.0]"),), "triangle inequality"),
    ],
)
def test_ends_that_cannot_be_are_refused(spreads: Sequence[tuple[str, str]], told: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=told):
        begun(written(tmp_path, text_with(spreads)), tmp_path / "runs")
    assert not (tmp_path / "runs").exists()


@pytest.mark.slow
def test_what_does_not_fit_the_disk_is_refused(tmp_path: Path) -> None:
    file = written(tmp_path, text_with([("payload", "uniform = [0.0, 0.1]")], runs="9_000_000_000"))
    with begun(file, tmp_path / "runs") as ready:
        assert ready.estimate.disk > 1e11
        with pytest.raises(InputError, match=r"are free|days"):
            ready.run()
    assert not (tmp_path / "runs").exists()


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["cpm", "omega3", "stewart", "fourbar", "cpm_rotary"])
def test_any_robot_has_studies(robot: str, tmp_path: Path) -> None:
    link = next(
        one.name
        for one in load(robot).description.links
        if one.inertial is not None and one.inertial.mass > 0.0 and "base" not in one.name
    )
    text = text_with(
        [(f"links.{link}.mass", "relative = 0.2"), ("gains.kp", "relative = 0.1")],
        robot=f'"{robot}"', runs="24", trajectory='"hold:0.05"',
    )  # fmt: skip
    run_study(written(tmp_path, text), tmp_path / "runs")
    summary = summary_of(tmp_path / "runs")
    assert (summary.runs, summary.failed) == (24, 0)
    assert all(np.isfinite(one.mean) for one in summary.columns)


def test_a_robot_whose_actuators_are_too_many_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ActuationError, match="redundant"):
        begun(written(tmp_path, text_with([], robot='"redundant"')), tmp_path / "runs")


def test_the_digest_of_a_file_is_sha256() -> None:
    assert digest(b"x") == hashlib.sha256(b"x").hexdigest()
