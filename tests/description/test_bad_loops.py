"""Bad input in a loops.toml: each message says where, what was found, what was expected, how to mend it."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cutjoint.description import check, load_description, read_checked
from cutjoint.description.model import TASK_NAMES
from cutjoint.errors import DescriptionError, UnknownNameError

COUPLING = '[[coupling]]\nname = "gear"\njoint = "rocker_turn"\ndriver = "crank_turn"\nratio = 2.0\n\n[tool]'
CUT_FRAMES = (
    'frames = [\n  { link = "coupler", xyz = [0.4, 0.0, 0.0] },\n  { link = "rocker", xyz = [0.3, 0.0, 0.0] },\n]'
)
SECOND_CUT = '\n[[cut]]\nname = "tip"\ntype = "fixed"\nframes = ["ground", "rocker"]\n\n[home.default]'

# name: (edits, mark of the line it stands on, found, expected, mend)
ERRORS = {
    "truncated": (
        [('frame = { link = "coupler"', 'frame = { link = "coupler')],
        "frame = {",
        "does not parse",
        "TOML",
        "",
    ),
    "decimal comma": ([("-9.81, 0.0", "-9,81, 0,0")], "gravity", "gravity of the file is .*9, 81", "3 numbers", ""),
    "decimal comma alone": (
        [("crank_turn = 1.0", "crank_turn = 1,0")],
        "crank_turn = 1",
        "does not parse",
        "",
        "points",
    ),
    "schema missing": ([("schema = 1", "")], None, "the file without 'schema'", "schema = 1", "add schema"),
    "schema of tomorrow": ([("schema = 1", "schema = 2")], "schema", "schema of the file is 2", "schema = 1", ""),
    "unknown key": ([("actuators =", "actuator =")], "actuator", "unknown key 'actuator'", "actuators", "'actuators'"),
    "unknown key in a cut": (
        [('type = "revolute"', 'tpye = "revolute"')],
        "tpye",
        "'tpye' in .*cut.* 1",
        "type",
        "'type'",
    ),
    "unknown key in a frame": (
        [("xyz = [0.4", "xzy = [0.4")],
        "frames",
        "unknown key 'xzy'",
        "link, rpy, xyz",
        "'xyz'",
    ),
    "unknown table": ([("[home.default]", "[hone.default]")], "[hone.default]", "unknown key 'hone'", "home", "'home'"),
    "wrong cut type": (
        [('type = "revolute"', 'type = "revolut"')],
        "revolut",
        "type 'revolut' of .*cut",
        "one of fixed, revolute, prismatic, universal, spherical",
        "'revolute'",
    ),
    "unknown frame": (
        [('{ link = "rocker", xyz', '{ link = "roker", xyz')],
        "[[cut]]",
        "cut 'tip' names the unknown frame 'roker'",
        "a frame of the tree",
        "'rocker'",
    ),
    "one frame": ([(CUT_FRAMES, 'frames = ["coupler"]')], "frames", "frames of .*cut", "two frames", ""),
    "frame is a number": ([(CUT_FRAMES, "frames = [1, 2]")], "frames", "frames of .* is 1", "a link", ""),
    "frame with two numbers": (
        [("xyz = [0.4, 0.0, 0.0]", "xyz = [0.4, 0.0]")],
        "frames",
        r"xyz of .*\[0.4, 0.0\]",
        "3",
        "",
    ),
    "frames on one link": (
        [('{ link = "rocker", xyz', '{ link = "coupler", xyz')],
        "[[cut]]",
        "both frames of cut 'tip' are on link 'coupler'",
        "two links",
        "move against",
    ),
    "cut named twice": ([("\n[home.default]", SECOND_CUT)], "[[cut]]", "2 cuts are called 'tip'", "own", "rename"),
    "unknown actuator": (
        [('["crank_turn"]', '["krank_turn"]')],
        "actuators",
        "unknown joint 'krank_turn'",
        "",
        "'crank_turn'",
    ),
    "repeated actuator": (
        [('["crank_turn"]', '["crank_turn", "crank_turn"]')],
        "actuators",
        "2 times",
        "once",
        "remove",
    ),
    "actuators is a string": ([('["crank_turn"]', '"crank_turn"')], "actuators", "actuators of the file", "list", ""),
    "unknown tool": (
        [('frame = { link = "coupler"', 'frame = { link = "copler"')],
        "[tool]",
        "frame 'copler'",
        "",
        "'coupler'",
    ),
    "unknown coordinate of the task": (
        [("[tool]", '[tool]\ntask = ["x", "rotz"]')],
        "task =",
        "the task has 'rotz'",
        "one of x, y, z, rx, ry, rz",
        "'rz'",
    ),
    "repeated coordinate of the task": (
        [("[tool]", '[tool]\ntask = ["x", "y", "x"]')],
        "task =",
        "the task has 'x' 2 times",
        "once",
        "remove",
    ),
    "empty task": ([("[tool]", "[tool]\ntask = []")], "task =", r"task of \[tool\] is \[\]", "some of x.*home", ""),
    "task is a string": ([("[tool]", '[tool]\ntask = "xy"')], "task =", "task of .*'xy'", "list of strings", ""),
    "task with a number": ([("[tool]", '[tool]\ntask = ["x", 2]')], "task =", "task of .*2", "list of strings", ""),
    "task without a frame": (
        [('frame = { link = "coupler", xyz = [0.2, 0.1, 0.0] }', 'task = ["x"]')],
        "[tool]",
        "without 'frame'",
        "a link",
        "add frame",
    ),
    "unknown axes": (
        [("[tool]", '[tool]\naxes = "tol"')],
        "axes =",
        "the task has the axes 'tol'",
        "one of world, tool",
        "'tool'",
    ),
    "axes is a list": ([("[tool]", "[tool]\naxes = [1]")], "axes =", r"axes of .*\[1\]", "a string", ""),
    "gravity text": (
        [("gravity = [0.0", 'gravity = ["0.0"')],
        "gravity",
        "gravity of the file is",
        "without quotes",
        "",
    ),
    "gravity nan": ([("gravity = [0.0", "gravity = [nan")], "gravity", "gravity of the file is nan", "finite", ""),
    "gravity true": ([("gravity = [0.0", "gravity = [true")], "gravity", "gravity of the file is", "numbers", ""),
    "huge whole number": ([("gravity = [0.0", "gravity = [" + "9" * 400)], "gravity", "beyond 1e308", "double", ""),
    "huger whole number": ([("gravity = [0.0", "gravity = [" + "9" * 5000)], None, "does not parse", "", ""),
    "arrays in arrays": ([("gravity = [0.0", "gravity = " + "[" * 5000 + "0.0")], None, "does not parse", "", ""),
    "home of an unknown joint": (
        [("coupler_turn = -0.5", "cupler_turn = -0.5")],
        "[home",
        "'cupler_turn'",
        "",
        "'coupler_turn'",
    ),
    "home without an actuator": (
        [("{ crank_turn = 1.0 }", "{}")],
        "[home",
        "without crank_turn",
        "all actuators",
        "add",
    ),
    "home with a passive joint": (
        [("crank_turn = 1.0", "crank_turn = 1.0, rocker_turn = 1.0")],
        "[home.default]",
        "joint 'rocker_turn' under actuated",
        "one of crank_turn",
        "passive",
    ),
    "home with too many numbers": (
        [("turn = -0.5", "turn = [1, 2]")],
        "[home",
        "2 numbers for the continuous",
        "1",
        "",
    ),
    "home with text": (
        [("coupler_turn = -0.5", 'coupler_turn = "bent"')],
        "passive",
        "coupler_turn of .*'bent'",
        "number",
        "",
    ),
    "variant of an unknown link": (
        [("inertial.crank]", "inertial.krank]")],
        "[variant.lumped]",
        "'krank'",
        "",
        "'crank'",
    ),
    "variant with a negative mass": (
        [("mass = 0.4", "mass = -0.4")],
        "[variant.lumped]",
        "variant 'lumped' is -0.4 kg",
        "",
        "",
    ),
    "variant without mass": ([("mass = 0.4\n", "")], "inertial.crank", "without 'mass'", "a number", "add mass"),
    "variant, impossible inertia": (
        [("[0.0, 0.004, 0.004,", "[0.0, 0.004, 0.009,")],
        "[variant.lumped]",
        "link 'crank' in variant 'lumped' breaks the triangle inequality",
        "sum",
        "",
    ),
    "urdf missing": ([("robot.urdf", "robto.urdf")], None, "file not found", "URDF", "'robot.urdf'"),
    "urdf not named": ([('urdf = "robot.urdf"', "")], None, "the file without 'urdf'", "a string", "add urdf"),
    "coupling of an unknown joint": (
        [("[tool]", COUPLING.replace("rocker", "roker"))],
        "coupling",
        "'roker_turn'",
        "",
        "rocker",
    ),
    "coupling to itself": (
        [("[tool]", COUPLING.replace("rocker", "crank"))],
        "[[coupling]]",
        "to itself",
        "two joints",
        "",
    ),
    "coupling of an actuator": (
        [("[tool]", COUPLING), ('["crank_turn"]', '["crank_turn", "rocker_turn"]')],
        "actuators",
        "joint 'rocker_turn', which coupling 'gear' drives already",
        "independent",
        "driver only",
    ),
    "couplings in a ring": (
        [
            (
                "[tool]",
                COUPLING[:-6] + '[[coupling]]\nname = "back"\njoint = "crank_turn"\ndriver = "rocker_turn"\n[tool]',
            )
        ],
        "[[coupling]]",
        "in a ring: rocker_turn, crank_turn, rocker_turn",
        "a driver that no coupling drives",
        "remove one",
    ),
    "two drivers": (
        [
            (
                "[tool]",
                COUPLING[:-6] + '[[coupling]]\nname = "more"\njoint = "rocker_turn"\ndriver = "coupler_turn"\n[tool]',
            )
        ],
        "[[coupling]]",
        "'rocker_turn' is driven by 2 couplings",
        "at most one",
        "remove one",
    ),
    "ratio text": ([("[tool]", COUPLING.replace("2.0", '"2:1"'))], 'ratio = "2:1"', "ratio of .*'2:1'", "number", ""),
}


@pytest.mark.parametrize("case", ERRORS)
def test_error(case: str, fourbar) -> None:
    edits, mark, found, expected, mend = ERRORS[case]
    path: Path = fourbar(loops=edits)
    with pytest.raises(DescriptionError) as caught:
        load_description(path)
    hits = [
        one
        for one in caught.value.problems
        if re.search(found, one.found) and re.search(expected, one.expected) and re.search(mend, one.mend)
    ]
    assert hits, str(caught.value)
    assert hits[0].severity == "error"
    if mark is not None:
        text = path.read_text(encoding="utf-8")
        assert (hits[0].file, hits[0].line) == (str(path), text.count("\n", 0, text.index(mark)) + 1)


def test_the_cut_that_fixed_joints_satisfy_already(fourbar) -> None:
    welded = [('name="rocker_turn" type="continuous"', 'name="rocker_turn" type="fixed"')]
    loops = [(", rocker_turn = 1.2", ""), ('{ link = "coupler", xyz = [0.4, 0.0, 0.0] }', '"ground"')]
    problems = read_checked(fourbar(urdf=welded, loops=loops)).problems
    assert any("'ground' and 'rocker', which fixed joints hold together" in one.found for one in problems), problems


def test_a_wrong_task_is_one_problem_a_fault(fourbar) -> None:
    loops = [('frame = { link = "coupler", xyz = [0.2, 0.1, 0.0] }', 'task = ["x", "u", "v"]\naxes = "base"')]
    assert [one.found for one in read_checked(fourbar(loops=loops)).problems] == [
        "[tool] without 'frame'",
        "the task has the axes 'base'",
    ]
    loops = [("[tool]", '[tool]\ntask = ["u", "x", "v"]\naxes = "base"')]
    assert [one.found for one in read_checked(fourbar(loops=loops)).problems] == [
        "the task has the axes 'base'",
        "the task has 'u'",
        "the task has 'v'",
    ]


@pytest.mark.parametrize("seed", range(10))
def test_a_task_is_read_in_its_order(seed: int, fourbar) -> None:
    rng = np.random.default_rng(seed)
    given = list(rng.permutation(TASK_NAMES)[: rng.integers(1, 7)])
    axes = ("world", "tool")[seed % 2]
    quoted = ", ".join(f'"{name}"' for name in given)
    robot = load_description(fourbar(loops=[("[tool]", f'[tool]\ntask = [{quoted}]\naxes = "{axes}"')]))
    assert robot.task == tuple(name for name in TASK_NAMES if name in given)
    assert robot.task_axes == axes
    plain = load_description(fourbar())
    assert (plain.task, plain.task_axes) == ((), "world")


def test_a_task_made_in_python_is_checked_alike(fourbar) -> None:
    robot = load_description(fourbar())
    found = {one.found: one for one in check(replace(robot, tool=None, task=("rz", "q", "rz"), task_axes="home"))}
    assert set(found) == {
        "a task without a tool",
        "the task has 'rz' 2 times",
        "the task has 'q'",
        "the task has the axes 'home'",
    }
    assert check(replace(robot, task=("rz", "y"))) == check(robot)


def test_each_cut_has_its_own_line(fourbar) -> None:
    path: Path = fourbar(loops=[("\n[home.default]", SECOND_CUT.replace('"tip"', '"top"').replace("ground", "gruond"))])
    (problem,) = read_checked(path).problems
    lines = path.read_text(encoding="utf-8").splitlines()
    assert "'gruond'" in problem.found
    assert problem.line == len(lines) - lines[::-1].index("[[cut]]")


def test_a_coupling_is_read(fourbar) -> None:
    (coupling,) = load_description(fourbar(loops=[("[tool]", COUPLING)])).couplings
    assert (coupling.joint, *coupling.gear) == ("rocker_turn", "crank_turn", 2.0)


def test_a_folder_without_loops(tmp_path: Path) -> None:
    (problem,) = read_checked(tmp_path).problems
    assert "a directory without a robot" in problem.found


def test_not_utf8(fourbar) -> None:
    path: Path = fourbar()
    path.write_bytes(path.read_bytes().replace(b"Planar", b"Pl\xe4nar"))
    assert any("not UTF-8" in one.found for one in read_checked(path).problems)


def test_unknown_names_suggest_the_nearest(fourbar) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'lumped'"):
        load_description(fourbar(), variant="lumpd")
    with pytest.raises(UnknownNameError, match="unknown robot 'no_such_robot'"):
        load_description("no_such_robot")
    (problem,) = read_checked("no_such_robot").problems
    assert "no_such_robot" in problem.found
