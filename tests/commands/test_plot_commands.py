"""`cutjoint plot` and `cutjoint report`: files where they are looked for, and one clear error for what is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest
from kit.runs import made
from typer.testing import CliRunner

from cutjoint.cli import app
from cutjoint.commands.plot import WHAT
from cutjoint.errors import CutjointError
from cutjoint.simulation import save
from cutjoint.simulation.panels import PANELS


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    return save(made(about={"limits": 20.0}), tmp_path / "run.npz")


def call(*arguments: object) -> str:
    result = CliRunner().invoke(app, list(map(str, arguments)), catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def test_the_help_names_every_panel() -> None:
    assert [*WHAT.split(", "), "reactions"] == list(PANELS)


def test_a_plot_lies_beside_its_run_unless_told_otherwise(saved: Path) -> None:
    call("plot", saved, "--what", "tool", "--from", 0.5)
    assert saved.with_suffix(".svg").read_text().startswith("<?xml")
    other = save(made(31), saved.with_name("other.npz"))
    call("plot", saved, other, "-o", saved.with_name("both.html"))
    assert "motor1, other" in saved.with_name("both.html").read_text()


def test_a_report_says_on_the_terminal_too_whether_to_believe_it(saved: Path) -> None:
    told = " ".join(call("report", saved).split())
    assert "run: This run can be believed" in told
    assert saved.with_suffix(".html").exists()


@pytest.mark.parametrize(("command", "suffix"), [("plot", ".svg"), ("report", ".html")])
def test_files_of_others_are_not_replaced_unless_named(saved: Path, command: str, suffix: str) -> None:
    beside = saved.with_suffix(suffix)
    beside.write_text("<html>of somebody else</html>")
    with pytest.raises(CutjointError, match=f"`cutjoint {command}` did not make it"):
        call(command, saved)
    assert beside.read_text() == "<html>of somebody else</html>"
    tool = ["--what", "tool"] if command == "plot" else []
    call(command, saved, *tool, "-o", beside)
    call(command, saved, *tool)  # its own it replaces
    if suffix == ".html":
        call("plot", saved, "--what", "tool", "-o", beside)
        with pytest.raises(CutjointError, match="did not make it"):
            call(command, saved)


WRONG = {
    "unknown": (["plot", "RUN", "--what", "efort"], "did you mean 'effort'"),
    "no error": (["plot", "RUN", "--what", "error"], "followed nothing"),
    "backwards": (["plot", "RUN", "--from", "2", "--to", "1"], "give a start before its end"),
    "suffix": (["plot", "RUN", "-o", "run.pdf"], "written as"),
    "folder": (["plot", "RUN", "-o", "missing/run.svg"], "does not exist"),
    "no run": (["plot", "none.npz"], "no such file"),
    "no result": (["report", "run.csv"], "CSV files are not read"),
    "page": (["report", "RUN", "-o", "run.svg"], "written as"),
    "another robot": (["report", "RUN", "--robot", "fourbar"], "made with"),
    "variant alone": (["report", "RUN", "--variant", "lumped"], "--robot"),
    "no robot": (["plot", "RUN", "--what", "reactions"], "no robot here"),
    "no such robot": (["plot", "RUN", "--robot", "fuorbar"], "fourbar"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_said_and_nothing_is_written(case: str, saved: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(saved.parent)
    arguments, words = WRONG[case]
    with pytest.raises(CutjointError, match=words):
        call(*(str(saved) if one == "RUN" else one for one in arguments))
    assert [one.name for one in saved.parent.iterdir()] == ["run.npz"]
