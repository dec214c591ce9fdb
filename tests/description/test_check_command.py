"""`cutjoint check` and `cutjoint export` as a user runs them."""

from __future__ import annotations

import json
from pathlib import Path

import typer
from typer.testing import CliRunner

from cutjoint.commands import check, export
from cutjoint.description import load_description


def run(module, *arguments: object):
    app = typer.Typer()
    app.command()(module.command)
    return CliRunner().invoke(app, [str(one) for one in arguments])


def test_a_sound_robot_has_status_0(fourbar) -> None:
    result = run(check, fourbar())
    assert result.exit_code == 0
    told = "fourbar loads: 0 errors, 0 warnings; 4 links, 3 joints, 1 cut joint, 0 couplings, 1 actuator"
    assert told in " ".join(result.output.split())


def test_warnings_alone_have_status_0(fourbar) -> None:
    result = run(check, fourbar(urdf=[('<mass value="0.4"/>', '<mass value="654000"/>')]))
    assert result.exit_code == 0
    assert "654 t" in result.output
    assert "0 errors, 1 warning;" in result.output


def test_every_problem_is_shown_with_status_1(fourbar) -> None:
    path: Path = fourbar(
        urdf=[('<mass value="0.4"/>', '<mass value="-1"/>'), ('size="0.2 0.02 0.02"', 'size="[red]0,2[/]"')],
        loops=[('link = "rocker"', 'link = "roker"')],
    )
    result = run(check, path)
    assert result.exit_code == 1
    for text in ("is -1 kg", "[red]0,2[/]", "'roker'", "did you mean 'rocker'", "3 errors, 0 warnings", "robot.urdf:"):
        assert text in result.output, text


def test_json_holds_the_same(fourbar) -> None:
    path: Path = fourbar(loops=[('link = "rocker"', 'link = "roker"')])
    result = run(check, path, "--json")
    assert result.exit_code == 1
    data = json.loads(result.output)
    assert data["loads"] is False
    (problem,) = data["problems"]
    assert problem["file"] == str(path)
    assert problem["line"] == path.read_text().splitlines().index("[[cut]]") + 1
    assert problem["severity"] == "error"
    assert "roker" in problem["found"]
    assert "rocker" in problem["mend"]


def test_lenient_passes_what_does_not_prevent_computing(fourbar) -> None:
    path: Path = fourbar(urdf=[('<box size="0.2 0.02 0.02"/>', '<mesh filename="arm.stl"/>')])
    strict = run(check, path)
    assert strict.exit_code == 1
    assert "--lenient" in strict.output
    lenient = run(check, path, "--lenient")
    assert lenient.exit_code == 0
    assert "'arm.stl'" in lenient.output
    assert load_description(path, lenient=True).link("crank").visuals == ()


def test_export_writes_what_loads_again(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    for form, file in (("mjcf", "fourbar.xml"), ("urdf", "fourbar.urdf"), ("loops", "fourbar/loops.toml")):
        result = run(export, "fourbar", "--to", form)
        assert result.exit_code == 0, result.output
        assert result.output.splitlines()[0] == file
        assert load_description(tmp_path / file).name == "fourbar"
