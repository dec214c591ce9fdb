"""Ctrl-C in a run: nothing is lost, in Python and on the command line, wherever it comes."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from cutjoint.cli import app
from cutjoint.errors import CutjointError, Interrupted
from cutjoint.motion import Circle, Reference
from cutjoint.papers.cpm import CpmModel
from cutjoint.papers.cpm.published import CIRCLE
from cutjoint.simulation import Result, RungeKutta4, load, run

CIRCLING = Circle(CIRCLE.centre, CIRCLE.radius, CIRCLE.omega)
PAPER = CpmModel()
LONG = ("simulate", "cpm", "--rate", "1000", "--trajectory", "hold:600", "--json")


def cpm_run(law: Callable[..., Any], **options: Any) -> Result:
    return run(PAPER, law, Reference(CIRCLING, PAPER, 0.05), every=1e-3, **options)


def pd(_: float, desired: Any, q: Any, v: Any) -> Any:
    return 8000.0 * (desired.q - q) + 300.0 * (desired.v - v)


@pytest.mark.parametrize(
    ("options", "answers"),
    [
        ({"rate": 1000.0}, 30),
        pytest.param({"rate": 1000.0, "integrator": RungeKutta4(5e-4)}, 30, marks=pytest.mark.slow),
        pytest.param({}, 150, marks=pytest.mark.slow),
    ],
)
def test_a_result_until_then_is_that_of_the_whole_run(options: dict[str, Any], answers: int) -> None:
    """Whether it comes between two steps, or while the law is asked."""
    whole, asked = cpm_run(pd, **options), 0

    def interrupting(*given: Any) -> Any:
        nonlocal asked
        asked += 1
        if asked == answers:
            raise KeyboardInterrupt
        return pd(*given)

    def stop(t: float) -> None:
        if t > 0.02:
            raise KeyboardInterrupt

    for law, progress in ((interrupting, None), (pd, stop)):
        with pytest.raises(KeyboardInterrupt) as caught:
            cpm_run(law, progress=progress, **options)
        error = caught.value
        assert isinstance(error, Interrupted)
        assert not isinstance(error, CutjointError)
        found = error.result
        assert isinstance(found, Result)
        assert 0.0 < error.done == found.time[-1] / 0.05 < 1.0
        inside = found.time <= 0.02 if law is pd else found.time >= 0.0  # the last sample is where it was stopped
        assert inside.sum() >= 1
        for name, column in found.columns.items():
            np.testing.assert_allclose(column[inside], whole.columns[name][: len(found)][inside], rtol=1e-9, atol=1e-12)
        again = pickle.loads(pickle.dumps(error))
        assert (str(again), again.done, len(again.result)) == (str(error), error.done, len(found))


def test_a_rarely_recorded_run_ends_with_the_state_that_it_had_reached() -> None:
    def stop(t: float) -> None:
        if t > 0.0203:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        run(PAPER, pd, Reference(CIRCLING, PAPER, 0.05), rate=1000.0, every=0.015, progress=stop)
    found = caught.value.result
    assert isinstance(found, Result)
    np.testing.assert_allclose(found.time, [0.0, 0.015, 0.021], atol=1e-12)


def test_the_command_keeps_what_there_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    count = 0

    def check() -> None:
        nonlocal count
        count += 1
        if count > 40:
            raise KeyboardInterrupt

    monkeypatch.setattr("cutjoint.interrupts.check", check)
    file = tmp_path / "run.npz"
    done = CliRunner().invoke(app, [*LONG[:-1], "--plant", "paper", "--save", str(file)])
    assert done.exit_code == 130, done.output
    assert [one.name for one in tmp_path.iterdir()] == ["run.stopped.npz"]
    assert load(tmp_path / "run.stopped.npz").time[-1] == pytest.approx(0.041, abs=2e-3)
    assert "interrupted" in done.stderr
    assert "run.stopped.npz" in done.stderr


def started(*words: str, folder: Path) -> subprocess.Popen[str]:
    """The program in a session of its own, with SIGINT as a terminal's programs have it."""
    return subprocess.Popen(
        [sys.executable, "-m", "cutjoint", *words],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_program_ends_with_the_status_of_the_signal(tmp_path: Path, number: signal.Signals) -> None:
    process = started(*LONG, "--save", "run.npz", folder=tmp_path)
    time.sleep(12.0)
    process.send_signal(number)
    process.send_signal(number)  # twice within a moment, as `timeout` does, is once
    _, err = process.communicate(timeout=20)
    assert process.returncode == 128 + number, err
    assert "Traceback" not in err
    assert [one.name for one in tmp_path.iterdir()] == ["run.stopped.npz"]
    end = float(load(tmp_path / "run.stopped.npz").time[-1])
    assert f"t = {end:.6g} s of 600 s" in err


@pytest.mark.slow
@pytest.mark.parametrize("moment", [0.1, 0.2, 0.4, 0.7, 1.0])
def test_before_anything_is_computed_it_just_ends(tmp_path: Path, moment: float) -> None:
    """Amid the imports: no traceback, but where Python itself has not come to the program yet."""
    process = started(*LONG, "--save", "run.npz", folder=tmp_path)
    time.sleep(moment)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    if "site" in err:  # Python's own start, before any line of the program
        assert "cutjoint" not in err
    else:
        assert process.returncode in (130, -signal.SIGINT), err
        assert "Traceback" not in err
    left = [one.name for one in tmp_path.iterdir()]
    assert left == (["run.stopped.npz"] if "run.stopped.npz" in err else [])  # a quick machine is further by then


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_no_worker_is_left(tmp_path: Path, number: signal.Signals) -> None:
    sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))
    try:
        from interrupts import living
    finally:
        sys.path.pop(0)
    process = started("reproduce", "cpm", "--output", "page.html", folder=tmp_path)
    until = time.monotonic() + 30.0
    workers = len(os.sched_getaffinity(0))
    while len(living(process.pid)) < min(workers, 4) and time.monotonic() < until:
        time.sleep(0.1)
    time.sleep(1.0)
    process.send_signal(number)
    process.wait(10)
    until = time.monotonic() + 5.0
    while living(process.pid) and time.monotonic() < until:
        time.sleep(0.05)
    assert living(process.pid) == []
    assert [one.name for one in tmp_path.iterdir()] == (["page.stopped.html"] if number is signal.SIGINT else [])


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
@pytest.mark.parametrize("name", ["new", "cut", "plot", "plot-page", "report", "states", "states-bag"])
def test_files_are_whole_or_not_there(name: str) -> None:
    """SIGINT, SIGTERM and SIGKILL at moments drawn by lot, as `tools/interrupts.py` has it."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))
    try:
        from interrupts import tried
    finally:
        sys.path.pop(0)
    told: list[str] = []
    assert tried(name, 3, told.append, seed=1) == []
    assert "; 0 faults" in told[-1]
