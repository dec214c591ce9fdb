"""`cutjoint list`, `info` and `crosscheck` as a user runs them: what they print, JSON, exit status, helpful errors."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from cutjoint.cli import app, main
from cutjoint.description import catalogue
from cutjoint.errors import DescriptionError, UnknownNameError
from cutjoint.robots import PUBLISHED


def run(*arguments: str) -> str:
    """Standard output of a command that must do well."""
    result = CliRunner().invoke(app, arguments, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout


def fails(*arguments: str) -> Any:
    """The exception of a command that must not do well."""
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code != 0
    return result.exception


def test_list_shows_every_robot() -> None:
    text = run("list")
    for name in catalogue.names():
        assert name in text
    data = json.loads(run("list", "--json"))
    assert [row["name"] for row in data["robots"]] == list(catalogue.names())
    rows = {row["name"]: row for row in data["robots"]}
    assert {name for name, row in rows.items() if row["published_model"]} == set(PUBLISHED)
    assert rows["cpm"]["variants"] == ["distributed", "lumped"]
    assert (rows["cpm"]["actuators"], rows["cpm"]["cuts"]) == (3, 2)
    assert data["examples"] == []


@pytest.mark.skipif(not catalogue.example_names(), reason="example-robot-data is not installed")
def test_list_shows_the_examples_when_asked() -> None:
    assert "ur5" in run("list", "--examples")
    assert "ur5" in json.loads(run("list", "--examples", "--json"))["examples"]


def test_info_tells_mobility_masses_actuators_cuts_and_source() -> None:
    text = " ".join(run("info", "cpm", "--no-modes").split())
    for part in (
        "Cartesian Parallel Manipulator",
        "Elkady",
        "8.66557 kg",
        "velocities of the open tree 12",
        "constraint rows 12 9 independent",
        "mobility 3",
        "they determine the motion",
        "limb1_slide translation 0.6 m",
        "limb2_to_platform fixed 6 limb1_platform - limb2_platform",
        "gravity (0, 0, 9.81)",
    ):
        assert part in text


@pytest.mark.parametrize("name", catalogue.names())
def test_info_is_json_for_every_robot(name: str) -> None:
    data = json.loads(run("info", name, "--json", "--no-modes"))
    assert data["name"] == name
    report = data["mobility"]
    assert report["mobility"] == report["velocities"] - report["rank"]
    assert data["mass_kg"] == pytest.approx(sum(link["mass_kg"] for link in data["links"]))
    assert len(data["actuators"]) == report["actuators"]
    assert max(report["gap"]) < 1e-12
    assert data["working_modes"] is None


def test_info_of_a_variant_and_its_working_modes() -> None:
    data = json.loads(run("info", "cpm", "--variant", "lumped", "--json"))
    assert data["variant"] == "lumped"
    assert len(data["working_modes"]) == 8
    assert "variant lumped" in run("info", "cpm", "--variant", "lumped", "--no-modes")
    assert "8 (" not in run("info", "fivebar")


def test_info_says_what_is_wrong_with_the_actuation() -> None:
    assert "these still move: left, load, right" in " ".join(run("info", "underactuated", "--no-modes").split())
    assert "1 more than the mobility" in " ".join(run("info", "redundant", "--no-modes").split())


@pytest.mark.skipif(not catalogue.example_names(), reason="example-robot-data is not installed")
def test_info_of_a_robot_without_loops() -> None:
    data = json.loads(run("info", "ur5", "--json"))
    assert data["mobility"]["mobility"] == 6
    assert data["cuts"] == []
    assert "mobility" in run("info", "ur5")


def test_info_takes_a_path() -> None:
    folder = catalogue.path("fourbar").parent
    for path in (folder, folder / "loops.toml"):
        assert json.loads(run("info", str(path), "--json", "--no-modes"))["name"] == "fourbar"


@pytest.mark.parametrize("robot", list(PUBLISHED))
def test_crosscheck_prints_a_table(robot: str) -> None:
    text = run("crosscheck", robot, "--samples", "3")
    for quantity in ("tool position", "Jacobian", "J_dot v", "mass matrix", "inverse dynamics", "forward dynamics"):
        assert quantity in text
    assert "agrees" in text
    assert "DISAGREES" not in text


def test_crosscheck_of_all_robots_as_json(tmp_path: Path) -> None:
    data = json.loads(run("crosscheck", "--samples", "2", "--seed", "5", "--json", "-"))
    assert set(data) == set(PUBLISHED)
    for robot in data.values():
        assert robot["passes"]
        assert (robot["samples"], robot["seed"], robot["refused"]) == (2, 5, 0)
        for row in robot["quantities"].values():
            assert row["worst_relative_error"] <= row["tolerance"] == 1e-10
    file = tmp_path / "out.json"
    run("crosscheck", "--samples", "2", "--seed", "5", "--json", str(file))
    assert json.loads(file.read_text()) == data


def test_crosscheck_of_the_physical_variant_shows_what_the_hypothesis_costs() -> None:
    text = run("crosscheck", "cpm", "--variant", "distributed")
    assert "limb1_slide" in text
    assert "%" in text
    data = json.loads(run("crosscheck", "cpm", "--variant", "distributed", "--json", "-"))["cpm"]
    assert max(row["error"] for row in data.values()) == pytest.approx(0.109, abs=0.002)
    assert all(0.0 < row["percent_of_peak"] < row["percent_of_inertial_peak"] for row in data.values())


def test_crosscheck_fails_with_status_1(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the wrong inertias for the right model."""
    monkeypatch.setitem(
        PUBLISHED,
        "cpm",
        PUBLISHED["cpm"].__class__(**{**vars(PUBLISHED["cpm"]), "variant": "distributed", "physical": "none"}),
    )
    result = CliRunner().invoke(app, ["crosscheck", "cpm", "--samples", "2"])
    assert result.exit_code == 1
    assert "DISAGREES" in result.stdout
    assert "mass matrix" in result.stdout
    as_json = CliRunner().invoke(app, ["crosscheck", "cpm", "--samples", "2", "--json", "-"])
    assert as_json.exit_code == 1
    assert not json.loads(as_json.stdout)["cpm"]["passes"]


def test_unknown_names_come_with_the_nearest_known_one() -> None:
    for arguments, nearest in (
        (("info", "omega"), "omega3"),
        (("info", "cpn"), "cpm"),
        (("info", "cpm", "--variant", "lumpt"), "lumped"),
        (("info", "cpm", "--home", "defalt"), "default"),
        (("crosscheck", "omega33"), "omega3"),
        (("crosscheck", "cpm", "--variant", "lumpet"), "lumped"),
    ):
        error = fails(*arguments)
        assert isinstance(error, UnknownNameError)
        assert f"did you mean '{nearest}'" in str(error)
    error = fails("crosscheck", "fivebar")
    assert isinstance(error, UnknownNameError)
    assert "cpm, cpm_rotary, omega3" in str(error)


def test_files_that_are_wrong_are_errors_of_their_own(tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_text("<robot name='x'><link name='a'>", encoding="utf-8")
    assert isinstance(fails("info", str(file)), DescriptionError)
    assert isinstance(fails("info", str(tmp_path / "none.urdf")), DescriptionError)


def test_bad_options_are_refused() -> None:
    for arguments in (
        ("crosscheck", "cpm", "--samples", "0"),
        ("crosscheck", "cpm", "--seed", "-1"),
        ("crosscheck", "cpm", "--samples", "many"),
        ("info",),
        ("info", "cpm", "--nothing"),
        ("nothing",),
    ):
        result = CliRunner().invoke(app, arguments)
        assert result.exit_code == 2


def test_main_prints_errors_plainly_with_status_2(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["cutjoint", "info", "omega"])
    monkeypatch.setattr("cutjoint.interrupts.watch", lambda: None)  # this process lives on
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 2
    printed = capsys.readouterr()
    assert printed.err.startswith("UnknownNameError: ")
    assert "Traceback" not in printed.err
    assert printed.out == ""


def test_the_installed_program_keeps_json_and_progress_apart() -> None:
    program = [sys.executable, "-c", "from cutjoint.cli import main; main()"]
    done = subprocess.run(
        [*program, "crosscheck", "cpm", "--samples", "2", "--json", "-"],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    assert done.stdout.startswith("{")
    assert json.loads(done.stdout)["cpm"]["passes"]


def test_help_is_there_for_all() -> None:
    for name in ("list", "info", "crosscheck"):
        assert "Usage" in run(name, "--help")
