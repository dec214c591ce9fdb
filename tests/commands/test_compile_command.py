"""`cutjoint compile`: says what it does, and the second time finds it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from cutjoint.commands.compile import command
from cutjoint.errors import UnknownNameError

app = typer.Typer()
app.command()(command)


def call(*arguments: str) -> str:
    result = CliRunner().invoke(app, list(arguments), catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def test_it_says_what_it_does_and_finds_it_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CUTJOINT_CACHE", str(tmp_path))
    first = call("fourbar")
    assert re.search(r"^forward +\d+ +\d+\.\d\d s +", first, re.MULTILINE)
    assert "operations" in first
    assert re.search(r"^forward +\d+ +cached ", call("fourbar"), re.MULTILINE)
    rows = json.loads(call("fourbar", "--json", "--functions", "forward,step"))
    assert [row["function"] for row in rows] == ["forward", "step"]
    assert all(row["cached"] and row["operations"] > 10 for row in rows)
    assert not any(row["cached"] for row in json.loads(call("fourbar", "--json", "--no-cache")))


def test_published_models_arguments_and_times() -> None:
    (row,) = json.loads(
        call("cpm", "--published", "--functions", "forward", "--arguments", "payload", "--measure", "--json")
    )
    assert row["scalar_ns"] > 0.0
    assert row["batch_ns"] > 0.0
    assert "full_forward" in call("redundant")
    with pytest.raises(UnknownNameError, match="compiled function"):
        call("fourbar", "--functions", "forwards")
