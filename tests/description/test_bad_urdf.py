"""Bad input in a URDF: each gives a message that says where, what was found, what was expected, how to mend it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cutjoint.description import load_description, read_checked
from cutjoint.errors import DescriptionError, Problem

CRANK_TURN = '<joint name="crank_turn" type="revolute">'
INERTIA = '<inertia ixx="0" ixy="0" ixz="0" iyy="0.0013" iyz="0" izz="0.0013"/>'
END = "</robot>"


def joint(name: str, parent: str, child: str, kind: str = "fixed") -> str:
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/></joint>'


# name: (edits, mark of the line it stands on, found, expected, mend), the last three as regular expressions
ERRORS = {
    "mismatched tag": ([('<link name="ground"/>', '<link name="ground">')], None, "does not parse", "URDF", "close"),
    "cycle": (
        [('<parent link="ground"/>', '<parent link="coupler"/>')],
        CRANK_TURN,
        "a cycle apart from the tree: coupler, crank, coupler|crank, coupler, crank",
        "a tree",
        "cut joint",
    ),
    "detached cycle": (
        [(END, '<link name="a"/><link name="b"/>' + joint("ab", "a", "b") + joint("ba", "b", "a") + END)],
        'name="a"',
        "cycle apart from the tree: (a, b, a|b, a, b)",
        "a tree",
        "cut joint",
    ),
    "two roots": ([(END, '<link name="island"/>' + END)], "island", "2 root links: ground, island", "one root", "join"),
    "duplicate link": ([(END, '<link name="crank"/>' + END)], '"crank"/></robot', "2 links are called 'crank'", "", ""),
    "duplicate joint": (
        [(END, '<link name="x"/>' + joint("crank_turn", "ground", "x") + END)],
        '"fixed"',
        "2 joints are called 'crank_turn'",
        "a name of its own",
        "rename",
    ),
    "unknown parent": (
        [('<parent link="crank"/>', '<parent link="krank"/>')],
        "coupler_turn",
        "parent 'krank' of joint 'coupler_turn' is not a link",
        "the name of a link",
        "did you mean 'crank'",
    ),
    "unknown child": (
        [('<child link="rocker"/>', '<child link="roker"/>')],
        "rocker_turn",
        "child 'roker' of joint 'rocker_turn' is not a link",
        "the name of a link",
        "did you mean 'rocker'",
    ),
    "unknown mimic": (
        [('<dynamics damping="0.01" friction="0.02"/>', '<mimic joint="crank_trun" multiplier="2"/>')],
        "<mimic",
        "names the unknown joint 'crank_trun'",
        "a joint of the tree",
        "did you mean 'crank_turn'",
    ),
    "mimic of itself": (
        [('<dynamics damping="0.01" friction="0.02"/>', '<mimic joint="coupler_turn"/>')],
        "<mimic",
        "couples joint 'coupler_turn' to itself",
        "two joints",
        "",
    ),
    "link named universe": (
        [('<link name="ground"/>', '<link name="universe"/>'), *[('link="ground"', 'link="universe"')] * 2],
        '<link name="universe"/>',
        "a link called 'universe'",
        "another name",
        "rename",
    ),
    "mass nan": ([('<mass value="0.4"/>', '<mass value="nan"/>')], "nan", "mass of link 'crank' is nan", "finite", ""),
    "mass negative": ([('"0.4"/>', '"-0.4"/>')], 'name="crank"', "mass of link 'crank' is -0.4 kg", ">= 0", ""),
    "mass text": (
        [('<mass value="0.4"/>', '<mass value="heavy"/>')],
        "heavy",
        "mass of link 'crank': 'heavy' is not a number",
        "a number",
        "",
    ),
    "mass missing": ([('<mass value="0.4"/>', "")], "<inertial>", "<inertial> of link 'crank' without <mass>", "", ""),
    "mass of a microgram of a microgram": ([('"0.4"/>', '"4e-15"/>')], 'name="crank"', "4e-15 kg", "1e-09", "units"),
    "mass beyond reason": ([('"0.4"/>', '"4e15"/>')], "4e15", r"4e\+15", r"1e\+09", "units"),
    "triangle inequality": (
        [('iyy="0.0013" iyz="0" izz="0.0013"', 'iyy="0.0013" iyz="0" izz="0.0023"')],
        'name="crank"',
        "breaks the triangle inequality: principal moments 0, 0.0013, 0.0023",
        "at most the sum of the other two",
        "centre of mass",
    ),
    "inertia not positive": (
        [('ixx="0" ixy="0" ixz="0" iyy="0.0013"', 'ixx="0" ixy="0.001" ixz="0" iyy="0.0013"')],
        'name="crank"',
        "inertia of link 'crank' is not positive: principal moments -0.0",
        "none below 0",
        "signs",
    ),
    "inertia entry missing": (
        [('ixx="0" ixy="0"', 'ixx="0"')],
        'ixx="0" ixz',
        "ixy of link 'crank' is missing",
        "",
        "",
    ),
    "inertia entry unknown": (
        [('ixx="0" ixy="0"', 'ixx="0" iyx="0"')],
        "iyx",
        "unknown attribute 'iyx' of <inertia>",
        "ixx, ixy, ixz, iyy, iyz, izz",
        "did you mean",
    ),
    "zero axis": (
        [('xyz="0 0 1"', 'xyz="0 0 0"')],
        '"0 0 0"',
        "axis of joint 'crank_turn' is 0 0 0",
        "a direction",
        "0 0 1",
    ),
    "axis with two numbers": (
        [('xyz="0 0 1"', 'xyz="0 1"')],
        '"0 1"',
        "axis of joint 'crank_turn': 2 numbers",
        "3",
        "",
    ),
    "limits upside down": (
        [('lower="-3" upper="3"', 'lower="3" upper="-3"')],
        CRANK_TURN,
        "limits of joint 'crank_turn' are upside down: 3 to -3",
        "lower <= upper",
        "swap",
    ),
    "limit text": ([('lower="-3"', 'lower="low"')], "low", "lower limit of joint 'crank_turn': 'low'", "a number", ""),
    "negative effort": (
        [('effort="10"', 'effort="-10"')],
        CRANK_TURN,
        "effort limit of joint 'crank_turn' is -10",
        ">= 0",
        "",
    ),
    "negative damping": (
        [('damping="0.01"', 'damping="-1"')],
        "coupler_turn",
        "damping of joint 'coupler_turn' is -1",
        "",
        "",
    ),
    "box with two numbers": (
        [('size="0.2 0.02 0.02"', 'size="0.2 0.02"')],
        "<box",
        "box in <visual> of link 'crank': size: 2 numbers",
        "3 numbers",
        "",
    ),
    "negative size": (
        [('radius="0.01"', 'radius="-0.01"')],
        "<cylinder",
        "cylinder in <collision> of link",
        "negative",
        "",
    ),
    "two shapes": (
        [('<box size="0.2 0.02 0.02"/>', '<box size="1 1 1"/><sphere radius="1"/>')],
        "<geometry>",
        "<visual> of link 'crank' with 2 shapes",
        "exactly one",
        "",
    ),
    "missing mesh": (
        [('<box size="0.2 0.02 0.02"/>', '<mesh filename="meshes/arm.stl"/>')],
        "<mesh",
        "mesh 'meshes/arm.stl' in <visual> of link 'crank' not found",
        "such as .*meshes/arm.stl",
        "put the file there",
    ),
    "package not found": (
        [('<box size="0.2 0.02 0.02"/>', '<mesh filename="package://no_such_thing/arm.stl"/>')],
        "<mesh",
        "mesh 'package://no_such_thing/arm.stl' in <visual> of link 'crank' not found",
        "such as ",
        "'no_such_thing' to ROS_PACKAGE_PATH",
    ),
    "decimal comma": (
        [('<origin xyz="0.5 0 0"/>', '<origin xyz="0,5 0 0"/>')],
        '"0,5 0 0"',
        "decimal comma in '0,5 0 0'",
        "3 numbers",
        "0.5 0 0",
    ),
    "commas between numbers": (
        [('<origin xyz="0.5 0 0"/>', '<origin xyz="0.5, 0, 0"/>')],
        '"0.5, 0, 0"',
        "separator in",
        "3 numbers",
        "by spaces",
    ),
    "xacro expression": (
        [('<origin xyz="0.5 0 0"/>', '<origin xyz="${l1} 0 0"/>')],
        "l1",
        r"xacro left in: xyz=.\$\{l1\}",
        "without xacro",
        "xacro robot.urdf.xacro > robot.urdf",
    ),
    "xacro tag": (
        [
            ('<robot name="fourbar">', '<robot name="fourbar" xmlns:xacro="http://wiki.ros.org/xacro">'),
            (END, '<xacro:leg side="left"/>' + END),
        ],
        "xacro:leg",
        "xacro left in: <xacro:leg>",
        "without xacro",
        "expand",
    ),
    "xacro tag, prefix not declared": (
        [(END, "<xacro:leg/>" + END)],
        "xacro:leg",
        "xacro left in: <xacro:leg>",
        "",
        "expand",
    ),
    "wrong joint type": (
        [('"crank_turn" type="revolute"', '"crank_turn" type="revolut"')],
        "revolut",
        "type 'revolut' of joint 'crank_turn'",
        "one of fixed, revolute",
        "did you mean 'revolute'",
    ),
    "no joint type": (
        [('"crank_turn" type="revolute"', '"crank_turn"')],
        "crank_turn",
        "without a type",
        "one of fixed",
        "",
    ),
    "unknown element": (
        [("<inertial>", "<inertail>"), ("</inertial>", "</inertail>")],
        "inertail",
        "unknown element <inertail> in <link>",
        "collision, inertial, visual",
        "did you mean 'inertial'",
    ),
    "unknown attribute": (
        [('<origin xyz="0.5 0 0"/>', '<origin xzy="0.5 0 0"/>')],
        "xzy",
        "unknown attribute 'xzy' of <origin>",
        "rpy, xyz",
        "did you mean 'xyz'",
    ),
    "no link name": ([('<link name="ground"/>', "<link/>")], "<link/>", "<link> without a name", "<link name=", ""),
    "no child": (
        [('<child link="rocker"/>', "")],
        "rocker_turn",
        "joint 'rocker_turn' without child link",
        "<child",
        "",
    ),
    "two children": (
        [('<child link="rocker"/>', '<child link="rocker"/><child link="coupler"/>')],
        '<child link="rocker"/><child',
        "joint 'rocker_turn' with 2 <child> elements",
        "one",
        "cut joints",
    ),
    "two masses": (
        [('<mass value="0.4"/>', '<mass value="0.4"/><mass value="1"/>')],
        "<mass",
        "2 <mass> in one",
        "",
        "keep one",
    ),
    "colour out of range": ([('"0.5 0.5 0.6 1"', '"128 128 150 255"')], "128", "<color>: rgba", "0 to 1", ""),
    "another root element": (
        [("<robot ", "<robots "), ("</robot>", "</robots>")],
        "<robots",
        "<robots>",
        "<robot>",
        "",
    ),
    "infinite position": ([('<origin xyz="0.5 0 0"/>', '<origin xyz="inf 0 0"/>')], "inf", "xyz is inf", "finite", ""),
    "position in another unit": ([('xyz="0.5 0 0"', 'xyz="5e7 0 0"')], "5e7", r"xyz is 5e\+07", "SI units", "units"),
    "nested too deep": ([(END, "<gazebo>" * 120 + "</gazebo>" * 120 + END)], None, "nested 121 levels", "100", ""),
}


def line_of(path: Path, mark: str) -> int:
    text = path.read_text(encoding="utf-8")
    return text.count("\n", 0, text.index(mark)) + 1


def matching(problems: tuple[Problem, ...], found: str, expected: str, mend: str) -> list[Problem]:
    wanted = ((found, "found"), (expected, "expected"), (mend, "mend"))
    return [one for one in problems if all(re.search(text, getattr(one, field)) for text, field in wanted)]


@pytest.mark.parametrize("case", ERRORS)
def test_error(case: str, fourbar) -> None:
    edits, mark, found, expected, mend = ERRORS[case]
    path = fourbar(urdf=edits)
    with pytest.raises(DescriptionError) as caught:
        load_description(path)
    hits = matching(caught.value.problems, found, expected, mend)
    assert hits, str(caught.value)
    assert hits[0].severity == "error"
    assert hits[0].file == str(path.parent / "robot.urdf")
    if mark is not None:
        assert hits[0].line == line_of(path.parent / "robot.urdf", mark)
    assert str(hits[0]) in str(caught.value)


WARNINGS = {
    "654 tonnes": (
        [('<mass value="0.4"/>', '<mass value="654000"/>')],
        "mass of link 'crank' is 654 t",
        "20 t",
        "grams",
    ),
    "non-unit axis": ([('xyz="0 0 1"', 'xyz="0 0 2"')], "has length 2", "1", "normalised"),
    "no limit": (
        [('<limit lower="-3" upper="3" effort="10" velocity="20"/>', "")],
        "joint 'crank_turn' without <limit>",
        "<limit> on a revolute joint",
        "no limit",
    ),
    "limit without range": ([('lower="-3" upper="3"', "")], "without lower and upper", "both", "no limit"),
    "limit with one end": ([('lower="-3"', "")], "without lower", "both", "0, the default"),
    "range of nothing": ([('lower="-3" upper="3"', 'lower="0" upper="0"')], "cannot move: limits 0 to 0", "range", ""),
    "somebody's extension": ([(END, "<assembly/>" + END)], "unknown element <assembly>", "joint, link", ""),
    "unknown material": ([('<material name="steel"/>', '<material name="stell"/>')], "'stell'", "steel", "'steel'"),
    "nothing to move": (
        [('<mass value="0.6"/>', '<mass value="0"/>')],
        "moves nothing that has mass",
        "mass",
        "inertial",
    ),
}


@pytest.mark.parametrize("case", WARNINGS)
def test_warning(case: str, fourbar) -> None:
    edits, found, expected, mend = WARNINGS[case]
    reading = read_checked(fourbar(urdf=edits))
    assert reading.description is not None, reading.problems
    hits = matching(reading.problems, found, expected, mend)
    assert hits, reading.problems
    assert hits[0].severity == "warning"
    assert hits[0].line


def test_the_robot_that_is_spoiled_here_is_sound(fourbar) -> None:
    reading = read_checked(fourbar())
    assert reading.description is not None
    assert reading.problems == ()


def test_what_urdf_leaves_out_is_none_not_zero(fourbar) -> None:
    bare = [('<limit lower="-3" upper="3" effort="10" velocity="20"/>', "")]
    limits = load_description(fourbar(urdf=bare)).joint("crank_turn").limits
    assert (limits.lower, limits.upper, limits.velocity, limits.effort) == (None, None, None, None)


def test_all_problems_are_reported_at_once(fourbar) -> None:
    edits = [
        ('<mass value="0.4"/>', '<mass value="-1"/>'),
        ('size="0.2 0.02 0.02"', 'size="0.2"'),
        ('<parent link="crank"/>', '<parent link="krank"/>'),
        ('radius="0.01"', 'radius="thin"'),
    ]
    path = fourbar(urdf=edits, loops=[('type = "revolute"', 'type = "revolut"'), ('"crank_turn"]', '"krank_turn"]')])
    problems = read_checked(path).problems
    for found in ("is -1 kg", "1 numbers", "'krank'", "'thin'", "'revolut'", "'krank_turn'"):
        assert any(found in one.found for one in problems), found


def test_chain_of_5000_links(tmp_path: Path) -> None:
    links = "".join(f'<link name="l{i}"/>\n' for i in range(5000))
    joints = "".join(joint(f"j{i}", f"l{i}", f"l{i + 1}", "continuous") + "\n" for i in range(4999))
    path = tmp_path / "long.urdf"
    path.write_text(f'<robot name="long">{links}{joints}</robot>', encoding="utf-8")
    hits = matching(read_checked(path).problems, "link 'l4999' is 4999 joints from the root", "500", "merge")
    assert len(hits) == 1
    assert hits[0].severity == "error"
    assert hits[0].line == 5000


def test_100_000_levels_of_xml(tmp_path: Path) -> None:
    path = tmp_path / "deep.urdf"
    path.write_text('<robot name="deep">' + "<a>" * 100_000 + "</a>" * 100_000 + "</robot>", encoding="utf-8")
    assert matching(read_checked(path).problems, "does not parse|nested", "URDF|levels", "levels|flat")


def test_truncated_at_any_byte(fourbar) -> None:
    path = fourbar()
    urdf = path.parent / "robot.urdf"
    whole = urdf.read_bytes()
    for size in range(1, len(whole.rstrip()) - 1, 97):
        urdf.write_bytes(whole[:size])
        hits = matching(read_checked(path).problems, "does not parse", "well-formed URDF", "")
        assert hits, size
        assert hits[0].file == str(urdf)
    assert "truncated" in hits[0].mend


@pytest.mark.parametrize(
    "doctype",
    [
        '<!DOCTYPE robot [<!ENTITY x "boo">]>',
        '<!DOCTYPE robot SYSTEM "file:///etc/passwd">',
        '<!DOCTYPE robot [<!ENTITY x SYSTEM "file:///etc/passwd">]>',
        '<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;"><!ENTITY x "&b;&b;&b;&b;&b;">]>',
    ],
)
@pytest.mark.parametrize("used", ["", "&x;"])
def test_doctype_and_entities_are_refused(doctype: str, used: str, fourbar) -> None:
    edits = [('<?xml version="1.0"?>', '<?xml version="1.0"?>\n' + doctype), ("</robot>", used + "</robot>")]
    hits = matching(read_checked(fourbar(urdf=edits)).problems, "DOCTYPE or entity", "refused", "remove")
    assert hits
    assert hits[0].line == 2


@pytest.mark.parametrize(
    ("content", "found"),
    [(b"", "an empty file"), (b" \n ", "an empty file"), (b"\x7fELF\0\0\0\1", "a binary file"), (b"solid", "parse")],
)
def test_no_robot_in_the_file(content: bytes, found: str, tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    path.write_bytes(content)
    (problem,) = read_checked(path).problems
    assert found in problem.found
    assert problem.file == str(path)
    assert problem.expected


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_text("<robot/>")
    (problem,) = read_checked(tmp_path / "robto.urdf").problems
    assert problem.found == "file not found"
    assert "'robot.urdf'" in problem.mend


def test_a_directory(tmp_path: Path) -> None:
    for name in ("arm.urdf", "leg.urdf"):
        (tmp_path / name).write_text("<robot/>")
    (problem,) = read_checked(tmp_path).problems
    assert problem.found == "a directory with 2 robots"
    assert problem.mend == "name one of its files: arm.urdf, leg.urdf"


def test_meshes_are_found_in_ros_package_path(fourbar, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = tmp_path / "elsewhere" / "arms" / "meshes" / "arm.stl"
    mesh.parent.mkdir(parents=True)
    mesh.write_bytes(b"solid")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "elsewhere"))
    edits = [('<box size="0.2 0.02 0.02"/>', '<mesh filename="package://arms/meshes/arm.stl"/>')]
    assert load_description(fourbar(urdf=edits)).link("crank").visuals[0].mesh == mesh
