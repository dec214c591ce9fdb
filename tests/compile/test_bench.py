"""The benchmarks run and their contenders agree; how quick anything is, no test says."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

BENCH = Path(__file__).resolve().parents[2] / "tools" / "bench.py"


def bench(*arguments: str) -> dict[str, Any]:
    run = subprocess.run(
        [sys.executable, str(BENCH), "--small", "--json", *arguments],
        capture_output=True,
        text=True,
        check=False,
        timeout=500,
    )
    assert run.returncode == 0, run.stderr[-3000:]
    found: dict[str, Any] = json.loads(run.stdout)
    return found


def test_a_section_runs_and_agrees() -> None:
    found = bench("inverse")
    assert "cores" in found["machine"]
    assert set(found["inverse"]["differences"]) == {"cpm", "omega3"}
    assert max(found["inverse"]["differences"].values()) < 1e-12
    assert all(len(row) == len(found["inverse"]["columns"]) for row in found["inverse"]["rows"])


@pytest.mark.slow
def test_all_sections_run_and_agree() -> None:
    found = bench()
    assert max(found["forward"]["differences"].values()) < 1e-12
    assert max(found["growth"]["differences"].values()) < 1e-9
    assert found["tolerances"]["differences"]["tool"] < 1e-12
    assert found["sweep"]["differences"]["chain against paper"] < 1e-10
    assert set(found["workspace"]["differences"].values()) == {0.0}
    built = found["built"]["differences"]
    assert built.pop("MuJoCo RK4", 0.0) < 3e-4
    assert max(built.values()) < 1e-10
    assert all(error < 1e-8 for error in found["loop"]["differences"].values())
    assert set(found["studies"]["differences"].values()) == {0.0}
    # every engine, peers included, solves the same task: the worst of them to a tenth of a millimetre
    errors = {name: min(error for _, error in points) for name, points in found["loop"]["points"].items()}
    assert max(errors.values()) < 3e-4
    assert len(errors) >= 3


def test_unknown_sections_are_refused() -> None:
    run = subprocess.run([sys.executable, str(BENCH), "forwards"], capture_output=True, text=True, check=False)
    assert run.returncode == 2
    assert "known: forward" in run.stderr
