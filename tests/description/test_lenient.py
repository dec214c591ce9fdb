"""Lenient reading: what does not change the motion is passed with a warning, and the mechanism is the strict one's."""

from __future__ import annotations

import inspect
import warnings
from dataclasses import replace
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest
import typer
from kit.described import FILES, differences
from typer.testing import CliRunner

import cutjoint
from cutjoint.cli import COMMANDS
from cutjoint.description import Inertial, Link, Shape, check, load_description, write
from cutjoint.description.transforms import placement
from cutjoint.errors import DescriptionError, DescriptionWarning

SHAPES = {
    "radius": Shape("sphere", (-1.0,)),
    "text": Shape("sphere", (123.0,)),
    "count": Shape("box", (0.1, 0.2, -0.3)),
    "colour": Shape("box", (0.1, 0.2, 0.3), colour=(7.0, 0.0, 0.0, 1.0)),
}
ROBOTS = ("fourbar", "cpm", "stewart")
SAMPLES = Path(__file__).parent / "samples"
VISUAL = "<visual name='spoiled'><geometry><sphere><radius>{}</radius></sphere></geometry></visual></link>"
BALL = """def Sphere "spoiled" {{
double radius = 0.1
float3 xformOp:scale = {}
uniform token[] xformOpOrder = ["xformOp:scale"]
}}
def Capsule "pill" ("""


def spoiled(robot: str, form: str, flaw: str, folder: Path) -> Path:
    """A shipped robot in a format, with a shape that cannot be drawn on its last link."""
    whole = load_description(robot)
    last = whole.links[-1]
    shapes = (*last.visuals, replace(SHAPES[flaw], placement=placement((0.1, 0.0, 0.0)), name="spoiled"))
    links = (*whole.links[:-1], replace(last, visuals=shapes))
    file = write(replace(whole, links=links), folder / FILES[form], to=form)[0]
    if flaw == "text":
        for part in folder.rglob("*"):
            if part.is_file() and "123" in part.read_text(encoding="utf-8"):
                part.write_text(part.read_text(encoding="utf-8").replace("123", "wide"), encoding="utf-8")
    return file


@pytest.mark.parametrize("flaw", SHAPES)
@pytest.mark.parametrize("form", ["loops", "urdf"])  # MuJoCo, which reads MJCF, takes no file with such a shape
def test_a_shape_that_cannot_be_drawn_is_left_out(form: str, flaw: str, tmp_path: Path) -> None:
    file = spoiled("fourbar", form, flaw, tmp_path)
    with pytest.raises(DescriptionError, match="--lenient, or lenient=True, passes these"):
        load_description(file)
    with pytest.warns(DescriptionWarning):
        lenient = load_description(file, lenient=True)
    plain = load_description(write(load_description("fourbar"), tmp_path / "plain" / FILES[form], to=form)[0])
    bare = [replace(one, links=tuple(replace(link, visuals=()) for link in one.links)) for one in (lenient, plain)]
    assert differences(*bare) == []


def test_in_sdf_and_usd_too(tmp_path: Path) -> None:
    cases = [("fourbar.sdf", "</link>", VISUAL, "0.1", ("-0.1", "wide", "nan", ""))]
    if find_spec("pxr") is not None:
        cases.append(("everything.usda", 'def Capsule "pill" (', BALL, "(1, 1, 1)", ("(1, 2, 3)",)))
    for name, at, part, sound, flaws in cases:
        text, file = (SAMPLES / name).read_text(encoding="utf-8"), tmp_path / name
        file.write_text(text.replace(at, part.format(sound), 1), encoding="utf-8")
        wanted = load_description(file)
        for flaw in flaws:
            file.write_text(text.replace(at, part.format(flaw), 1), encoding="utf-8")
            with pytest.raises(DescriptionError, match="--lenient, or lenient=True, passes these"):
                load_description(file)
            with pytest.warns(DescriptionWarning):
                lenient = load_description(file, lenient=True)
            bare = [replace(one, links=tuple(map(_bare, one.links))) for one in (wanted, lenient)]
            assert differences(*bare) == [], (name, flaw)


def _bare(link: Link) -> Link:
    return replace(link, visuals=(), collisions=())


@pytest.mark.slow
@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("form", FILES)
def test_what_is_sound_is_the_same_read_either_way(robot: str, form: str, tmp_path: Path) -> None:
    file = write(load_description(robot), tmp_path / FILES[form], to=form)[0]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert differences(load_description(file), load_description(file, lenient=True)) == []


def test_descriptions_without_a_file_are_checked_alike() -> None:
    whole = load_description("fourbar")
    links = tuple(replace(link, visuals=(SHAPES["radius"],)) for link in whole.links)
    found = check(replace(whole, links=links))
    assert {(one.severity, one.tolerable) for one in found} == {("error", True)}
    assert {one.severity for one in check(replace(whole, links=links), lenient=True)} == {"warning"}


def test_what_changes_the_motion_is_never_passed(tmp_path: Path) -> None:
    whole = load_description("fourbar")
    heavy = whole.with_inertial(whole.links[-1].name, Inertial(-1.0))
    assert check(heavy, lenient=True)[0].severity == "error"
    folder = tmp_path / "robot"
    write(whole, folder)
    text = (folder / "loops.toml").read_text(encoding="utf-8")
    (folder / "loops.toml").write_text(text.replace("[[cut]]", "[[cuts]]"), encoding="utf-8")
    with pytest.raises(DescriptionError):
        load_description(folder, lenient=True)


def test_load_takes_it_too(tmp_path: Path) -> None:
    file = spoiled("fourbar", "urdf", "radius", tmp_path)
    with pytest.raises(DescriptionError):
        cutjoint.load(file)
    with pytest.warns(DescriptionWarning, match="-1"):
        chain = cutjoint.load(file, lenient=True)
    assert chain.mobility().mobility == cutjoint.load("fourbar").mobility().mobility


NAMED = [name for name in COMMANDS if name not in ("new", "list", "reproduce", "study", "synthesise")]
"""The commands that take the file of a robot."""
OF_RUNS = ("plot", "report", "states")
"""Those of them that take it beside a run."""
ARGUMENTS = {
    "info": ["--no-modes"],
    "simulate": ["--free", "--duration", "0.01", "--plant", "chain"],
    "view": ["--html", "OUT"],
    "play": ["--trajectory", "SPEC", "--html", "OUT"],
    "compile": ["--functions", "tool", "--no-cache"],
    "crosscheck": ["--engine", "yourdfpy", "--samples", "2"],
    "export": ["--out", "OUT"],
    "check": [],
    "cut": [],
    "workspace": ["--cells", "4"],
    "size": ["--trajectory", "about-home", "--duration", "0.1"],
    "retime": ["--trajectory", "about-home", "--speed", "1"],
    "stiffness": ["--actuator", "1e5"],
    "accuracy": ["--tolerance", "joints.*.origin.x=0.1 mm", "--samples", "10"],
    "tune": ["--by", "poles", "--bandwidth", "30"],
}


def test_every_command_with_a_robot_has_the_one_option() -> None:
    assert set(NAMED) == {*ARGUMENTS, *OF_RUNS}
    for name in COMMANDS:
        parameters = inspect.signature(import_module(f"cutjoint.commands.{name}").command).parameters
        assert ("lenient" in parameters) == (name in NAMED), name


@pytest.mark.slow
@pytest.mark.parametrize("name", ARGUMENTS)
def test_every_command_passes_them_with_a_warning(name: str, tmp_path: Path) -> None:
    if name == "compile" and find_spec("llvmlite") is None:
        pytest.skip("llvmlite is not installed")
    file = spoiled("fourbar", "loops", "radius", tmp_path)
    app = typer.Typer()
    app.command()(import_module(f"cutjoint.commands.{name}").command)
    words = {"OUT": str(tmp_path / "out.html"), "SPEC": "hold:0.1"}
    rest = [words.get(one, one) for one in ARGUMENTS[name]]
    strict = CliRunner().invoke(app, [str(file), *rest])
    assert strict.exit_code == 1
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        lenient = CliRunner().invoke(app, [str(file), *rest, "--lenient"])
    assert lenient.exit_code == 0, (lenient.output, lenient.exception)
    told = [str(one.message) for one in caught if issubclass(one.category, DescriptionWarning)]
    assert any("-1" in one for one in told) or "sphere" in lenient.output
