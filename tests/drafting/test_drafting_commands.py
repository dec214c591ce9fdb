"""`cutjoint new` and `cutjoint cut` as a user runs them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import typer
from kit.mechanisms import MECHANISMS
from kit.uncut import random, uncut, written
from typer.testing import CliRunner

from cutjoint.commands import check, cut, new
from cutjoint.description import load_description
from cutjoint.drafting import TEMPLATES, draft, folder, write_draft
from cutjoint.errors import CutjointError, InputError


def run(module, *arguments: object):
    app = typer.Typer()
    app.command()(module.command)
    return CliRunner().invoke(app, [str(one) for one in arguments], catch_exceptions=True)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_new_makes_a_robot_that_check_has_nothing_against(here: Path) -> None:
    result = run(new, "arm", "--template", "fivebar", "--proximal", "0.15")
    assert result.exit_code == 0
    assert "made arm: Planar five-bar, moves in 2 ways, 2 motors" in result.output
    assert "proximal 0.15 m" in result.output
    assert [line.split("#")[0].strip() for line in result.output.splitlines()[-3:]] == [
        "cutjoint check arm",
        "cutjoint view arm",
        "cutjoint simulate arm",
    ]
    assert sorted(one.name for one in (here / "arm").iterdir()) == ["README.md", "loops.toml", "robot.urdf"]
    assert sorted(one.name for one in here.iterdir()) == ["arm"]
    checked = run(check, "arm")
    assert checked.exit_code == 0
    assert "arm loads: 0 errors, 0 warnings; 6 links, 5 joints, 1 cut joint" in checked.output
    assert "cutjoint new arm --template fivebar --base 0.2 --proximal 0.15 --distal 0.25" in (
        (here / "arm" / "README.md").read_text()
    )


@pytest.mark.slow
@pytest.mark.parametrize("template", TEMPLATES)
def test_every_template_is_clean(template: str, here: Path) -> None:
    made = json.loads(run(new, "it", "-t", template, "--json").output)
    assert (made["template"], made["warnings"]) == (template, [])
    checked = json.loads(run(check, "it", "--json").output)
    assert (checked["loads"], checked["closes"], checked["problems"]) == (True, True, [])
    assert checked["mobility"]["mobility"] == made["mobility"]
    assert checked["task"]["problem"] is None
    again = draft("it", template, made["sizes"], made["density"])
    assert all((here / "it" / name).read_text() == text for name, text in again.files.items())


def test_new_writes_into_an_empty_folder_only(here: Path) -> None:
    (here / "empty").mkdir()
    assert run(new, "arm", "-o", "empty").exit_code == 0
    before = (here / "empty" / "loops.toml").read_text()
    assert isinstance(run(new, "arm", "-t", "delta", "-o", "empty").exception, InputError)
    assert (here / "empty" / "loops.toml").read_text() == before
    (here / "file").write_text("mine")
    assert "no folder" in str(run(new, "arm", "-o", "file").exception)
    assert (here / "file").read_text() == "mine"
    (here / "link").symlink_to(here / "nowhere")
    assert "no folder" in str(run(new, "arm", "-o", "link").exception)
    assert run(new, "arm", "-o", here / "deep" / "er").exit_code == 0
    assert (here / "deep" / "er" / "robot.urdf").is_file()


def test_nothing_stays_where_writing_fails(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = draft("arm")

    def fail(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(folder, "write_files", fail)
    with pytest.raises(InputError, match="cannot write arm: No space left on device"):
        write_draft(made, "arm")
    assert list(here.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["arm", "--crank", "12cm"], "--crank must be a number of metres, such as 0.12; found '12cm'"),
        (["arm", "--crank", "-1"], "crank must be from 0.001 to 100 m"),
        (["arm", "--density", "0"], "the density must be from 1 to 25000 kg/m3"),
        (["arm", "--density", "lead"], "--density must be a number of kg/m3, such as 2700"),
        (["arm", "--rod", "1"], "unknown size of template fourbar 'rod'"),
        (["arm", "-t", "deltas"], "did you mean 'delta'"),
        (["cpm"], "ships with cutjoint"),
    ],
)
def test_new_says_what_is_wrong_and_writes_nothing(arguments: list[str], told: str, here: Path) -> None:
    result = run(new, *arguments)
    assert isinstance(result.exception, CutjointError)
    assert told in str(result.exception)
    assert list(here.iterdir()) == []


def test_the_help_teaches_which_template_has_which_size() -> None:
    output = CliRunner().invoke(_app(), ["--help"], env={"COLUMNS": "200"}).output
    text = " ".join(output.replace("\N{BOX DRAWINGS LIGHT VERTICAL}", " ").split())
    for template, row in TEMPLATES.items():
        assert f"{template} ({row.about})" in text
        for name, size in row.sizes.items():
            assert f"--{name}" in text
            assert f"{template}: {size.about} ({size.default:g})" in text


def test_the_guide_lists_all_sizes() -> None:
    guide = (Path(__file__).resolve().parents[2] / "docs/adding-a-robot.md").read_text()
    for template, row in TEMPLATES.items():
        (line,) = [one for one in guide.splitlines() if one.startswith(f"| `{template}` |")]
        assert line.count("`--") == len(row.sizes)
        for name, size in row.sizes.items():
            assert f"`--{name}` {size.default:g}" in line


def _app() -> typer.Typer:
    app = typer.Typer()
    app.command()(new.command)
    return app


def open_parallelogram(folder: Path) -> Path:
    plan = MECHANISMS["parallelogram"](random(7)).plan
    robot = load_description(plan.write(folder / "a"))
    return written(uncut(robot, ("_loop_1", "_loop_2")), folder / "open", tree_alone=True)


def test_cut_writes_a_robot_that_check_has_nothing_against(here: Path) -> None:
    file = open_parallelogram(here)
    result = run(cut, file, "-o", "closed")
    assert result.exit_code == 0
    assert "mobility 1, 5 rows, 3 of them redundant" in result.output
    assert all(len(line) <= 80 for line in result.output.splitlines() if str(here) not in line)
    head = (here / "closed" / "loops.toml").read_text().split("schema")[0]
    assert "out of robot.urdf" in head
    assert "else spherical (mobility 1)" in head
    data = json.loads(run(check, "closed", "--json").output)
    assert (data["closes"], data["mobility"]["mobility"], data["mobility"]["determined"]) == (True, 1, True)
    assert [one for one in data["problems"] if one["severity"] == "error"] == []
    assert isinstance(run(cut, file, "-o", "closed").exception, InputError)


@pytest.mark.slow
def test_cut_takes_the_type_that_is_asked_for(here: Path) -> None:
    file = open_parallelogram(here)
    name = json.loads(run(cut, file, "--json").output)["cuts"][0]["name"]
    data = json.loads(run(cut, file, "--type", f"{name}=spherical", "--json").output)
    assert (data["cuts"][0]["type"], len(data["mobility"]["redundant_rows"])) == ("spherical", 1)
    for wrong, told in (
        (f"{name}=weld", "it may be revolute, spherical"),
        (name, "--type CUT=TYPE"),
        ("knee=fixed", f"Known: {name}"),
    ):
        assert told in str(run(cut, file, "--type", wrong).exception)


def test_cut_says_where_there_is_nothing_to_close(here: Path) -> None:
    file = load_description("stewart").path.parent / "robot.urdf"
    result = run(cut, file, "-o", "out")
    assert result.exit_code == 1
    assert "nothing to close" in result.output
    assert "leg1_piston" in result.output
    assert not (here / "out").exists()
    data = json.loads(run(cut, file, "--json").output)
    assert (data["cuts"], data["mobility"]) == ([], None)


def test_cut_of_what_is_no_robot_is_an_error(here: Path) -> None:
    (here / "bad.urdf").write_text("<robot")
    assert isinstance(run(cut, "bad.urdf").exception, CutjointError)
    assert isinstance(run(cut, "nowhere.urdf").exception, CutjointError)
    assert isinstance(run(cut, "nobody").exception, CutjointError)
