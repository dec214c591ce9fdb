"""The dialects of URDF that describe loops: the same four-bar in each, and what each of them has of its own."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cutjoint.description import CutType, JointType, RobotDescription, load_description, read_checked
from cutjoint.description.formats import FORMATS, Format, format_of

Write = Callable[..., Path]
END = "</robot>"
LOOP = """<loop name="tip" type="revolute">
    <predecessor link="coupler"><origin xyz="0.4 0 0"/></predecessor>
    <successor link="rocker"><origin xyz="0.3 0 0"/></successor>
    <axis xyz="0 0 1"/>
  </loop>"""
CONSTRAINT = """<constraint name="tip" type="revolute">
    <parent link="coupler"/><parent_origin xyz="0.4 0 0"/><parent_axis xyz="0 0 1"/>
    <child link="rocker"/><child_origin xyz="0.3 0 0"/>
  </constraint>"""
FRAMES = """<link name="end_a"/><link name="end_b"/>
  <joint name="to_a" type="fixed"><parent link="coupler"/><child link="end_a"/><origin xyz="0.4 0 0"/></joint>
  <joint name="to_b" type="fixed"><parent link="rocker"/><child link="end_b"/><origin xyz="0.3 0 0"/></joint>"""
YAML = "closed_loop: [['end_a', 'end_b']]\ntype: ['6D']\nname_mot: ['crank_turn']\n"


def dependent(*names: str) -> list[tuple[str, str]]:
    return [(f'<joint name="{name}"', f'<joint independent="false" name="{name}"') for name in names]


@pytest.fixture
def dialect(fourbar: Write) -> Callable[..., Path]:
    """dialect(name, ...) writes the four-bar in a dialect; further edits of URDF or YAML spoil it."""

    def write(name: str, urdf: tuple = (), yaml: tuple = ()) -> Path:
        extra = {"plus": LOOP, "constraint": CONSTRAINT, "gepetto": FRAMES}[name]
        edits = [(END, extra + END), *(dependent("coupler_turn", "rocker_turn") if name == "plus" else []), *urdf]
        tree = fourbar(urdf=edits).parent / "robot.urdf"
        if name != "gepetto":
            return tree
        text = YAML
        for old, new in yaml:
            assert old in text
            text = text.replace(old, new, 1)
        tree.with_suffix(".yaml").write_text(text, encoding="utf-8")
        return tree.with_suffix(".yaml")

    return write


def gaps(robot: RobotDescription, forward, values: dict[str, float]) -> np.ndarray:
    """Frame a of the only cut seen from its frame b, (4, 4)."""
    world = forward(robot, values)
    (cut,) = robot.cuts
    a, b = (world[frame.link] @ frame.placement for frame in (cut.a, cut.b))
    return np.linalg.inv(b) @ a


@pytest.mark.parametrize(
    ("name", "form", "kind"),
    [
        ("plus", "URDF+", CutType.REVOLUTE),
        ("constraint", "URDF with <constraint>", CutType.REVOLUTE),
        ("gepetto", "Gepetto robot.yaml", CutType.FIXED),
    ],
)
def test_the_same_four_bar(name: str, form: str, kind: CutType, dialect, fourbar: Write, forward) -> None:
    native = load_description(fourbar())
    path = dialect(name)
    assert format_of(path).name == form
    robot = load_description(path)
    assert robot.cuts[0].type is kind
    assert robot.root == native.root
    generator = np.random.default_rng(0)
    for _ in range(10):
        values = {joint.name: generator.uniform(-3, 3) for joint in native.joints}
        np.testing.assert_allclose(gaps(robot, forward, values), gaps(native, forward, values), atol=1e-15)
    if name != "constraint":
        assert robot.actuators == native.actuators


@pytest.mark.parametrize(
    ("file", "text", "form"),
    [
        ("robot.xml", "<robot/>", "URDF"),
        ("robot.xml", "nothing known", "URDF"),
        ("robot.xml", "<mujoco/>", "MJCF"),
        ("robot.urdf", "<mujoco/>", "URDF"),
        ("robot.sdf", "", "SDF"),
        ("robot.txt", "<sdf/>", "SDF"),
        ("robot.txt", "nothing known", "URDF"),
        ("robot.new", "new", "a new one"),
        ("robot.new", "other", "a new one"),
    ],
)
def test_suffix_and_text_choose_the_format(
    file: str, text: str, form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Wherever the row of a new format with a suffix of its own stands."""
    new = Format("a new one", (".new",), (b"new",), FORMATS[0].read)
    (tmp_path / file).write_text(text)
    for rows in ((*FORMATS, new), (new, *FORMATS)):
        monkeypatch.setattr("cutjoint.description.formats.FORMATS", rows)
        assert format_of(tmp_path / file).name == form


# -- URDF+ -----------------------------------------------------------------------------------------------


def test_loop_axis_becomes_z_of_both_frames(dialect) -> None:
    robot = load_description(
        dialect("plus", urdf=[('<axis xyz="0 0 1"/>\n  </loop>', '<axis xyz="0.6 0 0.8"/></loop>')])
    )
    (cut,) = robot.cuts
    for frame in (cut.a, cut.b):
        np.testing.assert_allclose(frame.placement[:3, 2], [0.6, 0.0, 0.8], atol=1e-15)


COUPLED = """<link name="rotor"><inertial>
    <mass value="0.1"/><inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/>
  </inertial></link>
  <joint name="rotor_turn" type="continuous" independent="false">
    <parent link="ground"/><child link="rotor"/><axis xyz="0 0 1"/>
  </joint>
  <coupling name="gear"><predecessor link="crank"/><successor link="rotor"/><ratio value="6"/></coupling>"""


def test_coupling_ties_the_joints_below_the_common_ancestor(dialect) -> None:
    robot = load_description(dialect("plus", urdf=[(END, COUPLED + END)]))
    (coupling,) = robot.couplings
    assert (coupling.joint, *coupling.gear) == ("rotor_turn", "crank_turn", 6.0)
    assert robot.actuators == ("crank_turn",)


def test_coupling_drives_the_joint_that_is_not_independent(dialect) -> None:
    turned = COUPLED.replace('predecessor link="crank"', 'predecessor link="rotor"').replace(
        'successor link="rotor"', 'successor link="crank"'
    )
    (coupling,) = load_description(dialect("plus", urdf=[(END, turned + END)])).couplings
    assert (coupling.joint, *coupling.gear) == ("rotor_turn", "crank_turn", 1.0 / 6.0)


def test_the_first_spelling_of_urdf_plus(dialect) -> None:
    old = COUPLED.replace('<coupling name="gear">', '<constraint name="gear" type="rolling">')
    old = old.replace("</coupling>", "</constraint>")
    edits = [
        (END, old + END),
        ('<loop name="tip" type="revolute">', '<constraint name="tip" type="position">'),
        ("</loop>", "</constraint>"),
    ]
    robot = load_description(dialect("plus", urdf=edits))
    assert robot.cuts[0].type is CutType.SPHERICAL
    assert robot.couplings[0].gear[1] == 6.0


# -- <constraint> ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("revolute_joint", CutType.REVOLUTE),
        ("prismatic", CutType.PRISMATIC),
        ("spherical_joint", CutType.SPHERICAL),
        ("link", CutType.FIXED),
    ],
)
def test_constraint_types(text: str, kind: CutType, dialect) -> None:
    robot = load_description(dialect("constraint", urdf=[('name="tip" type="revolute"', f'name="tip" type="{text}"')]))
    assert robot.cuts[0].type is kind


def test_universal_constraint_turns_about_both_axes(dialect) -> None:
    edits = [
        ('name="tip" type="revolute"', 'name="tip" type="universal"'),
        ('<parent_axis xyz="0 0 1"/>', '<parent_axis xyz="0 0 1"/><child_axis xyz="0.6 0.8 0"/>'),
    ]
    (cut,) = load_description(dialect("constraint", urdf=edits)).cuts
    assert cut.type is CutType.UNIVERSAL
    np.testing.assert_allclose(cut.a.placement[:3, 0], [0, 0, 1], atol=1e-15)
    np.testing.assert_allclose(cut.b.placement[:3, 1], [0.6, 0.8, 0], atol=1e-15)


def test_transmissions_name_the_actuators_of_a_constraint_robot(dialect) -> None:
    transmission = '<transmission name="t"><joint name="crank_turn"/><actuator name="m"/></transmission>'
    assert load_description(dialect("constraint")).actuators == ()
    assert load_description(dialect("constraint", urdf=[(END, transmission + END)])).actuators == ("crank_turn",)


# -- Gepetto ---------------------------------------------------------------------------------------------


def test_3d_is_spherical_and_no_type_is_fixed(dialect) -> None:
    assert load_description(dialect("gepetto", yaml=[("6D", "3d")])).cuts[0].type is CutType.SPHERICAL
    assert load_description(dialect("gepetto", yaml=[("type: ['6D']\n", "")])).cuts[0].type is CutType.FIXED


def test_a_joint_stands_for_the_frame_that_it_moves(dialect) -> None:
    (cut,) = load_description(dialect("gepetto", yaml=[("['end_a'", "['coupler_turn'")])).cuts
    assert cut.a.link == "coupler"


def test_joints_are_replaced(dialect) -> None:
    extra = (
        "name_mot",
        "joint_name: [coupler_turn, rocker_turn, to_b]\njoint_type: [SPHERICAL, UJOINT_ZX, FIXED]\nname_mot",
    )
    robot = load_description(dialect("gepetto", yaml=[extra]))
    assert robot.joint("coupler_turn").type is JointType.SPHERICAL
    universal = robot.joint("rocker_turn")
    assert universal.type is JointType.UNIVERSAL
    assert (universal.axis.tolist(), universal.axis2.tolist()) == ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    assert robot.joint("to_b").type is JointType.FIXED


# -- bad input -------------------------------------------------------------------------------------------

BAD = {
    "loop type": (
        "plus",
        [('name="tip" type="revolute"', 'name="tip" type="revolut"')],
        [],
        "type 'revolut' of <loop>",
        "'revolute'",
    ),
    "loop without successor": (
        "plus",
        [('<successor link="rocker">', "<successor>")],
        [],
        "without successor link",
        "",
    ),
    "loop of an unknown link": (
        "plus",
        [('<successor link="rocker">', '<successor link="roker">')],
        [],
        "'roker'",
        "'rocker'",
    ),
    "loop with a zero axis": (
        "plus",
        [('<axis xyz="0 0 1"/>\n  </loop>', '<axis xyz="0 0 0"/></loop>')],
        [],
        "is 0 0 0",
        "0 0 1",
    ),
    "independent": ("plus", [('independent="false"', 'independent="fasle"')], [], "independent is 'fasle'", ""),
    "coupling of one side": (
        "plus",
        [(END, COUPLED.replace('predecessor link="crank"', 'predecessor link="ground"') + END)],
        [],
        "ties none to rotor_turn",
        "",
    ),
    "constraint type": (
        "constraint",
        [('"tip" type="revolute"', '"tip" type="ball"')],
        [],
        "type 'ball' of <constraint>",
        "",
    ),
    "constraint without child": (
        "constraint",
        [('<child link="rocker"/><child_origin', "<child_origin")],
        [],
        "without child link",
        "",
    ),
    "universal without axis": (
        "constraint",
        [('"tip" type="revolute"', '"tip" type="universal"')],
        [],
        "universal <constraint> 'tip' without child_axis",
        "add <child_axis",
    ),
    "universal with parallel axes": (
        "constraint",
        [
            ('"tip" type="revolute"', '"tip" type="universal"'),
            ('<parent_axis xyz="0 0 1"/>', '<parent_axis xyz="0 0 1"/><child_axis xyz="0 0 1"/>'),
        ],
        [],
        "not perpendicular",
        "",
    ),
    "keys that do not parse": (
        "constraint",
        [(END, "<cutjoint>actuators = </cutjoint>" + END)],
        [],
        "TOML does not parse",
        "",
    ),
    "unknown key inside": (
        "constraint",
        [(END, "<cutjoint>actuator = []</cutjoint>" + END)],
        [],
        "'actuator'",
        "'actuators'",
    ),
    "yaml does not parse": ("gepetto", [], [("closed_loop: [[", "closed_loop: [")], "YAML does not parse", ""),
    "yaml alias": ("gepetto", [], [("type: ['6D']", "type: &a ['6D']\nx: *a")], "a YAML alias", "write it out"),
    "yaml is a list": (
        "gepetto",
        [],
        [("closed_loop:", "- closed_loop:"), ("type:", "  type:"), ("name_mot:", "  name_mot:")],
        "not a mapping",
        "",
    ),
    "loop type in yaml": ("gepetto", [], [("6D", "5d")], "type '5d' of closed loop 1", ""),
    "types and loops": ("gepetto", [], [("['6D']", "['6D', '3d']")], "2 types for 1 closed loops", ""),
    "not a pair": ("gepetto", [], [("[['end_a', 'end_b']]", "[['end_a']]")], "closed loop 1 is not a pair", ""),
    "unknown frame in yaml": ("gepetto", [], [("'end_b'", "'ned_b'")], "unknown frame 'ned_b'", "'end_b'"),
    "unknown key in yaml": ("gepetto", [], [("name_mot", "name_motor")], "unknown key 'name_motor'", "'name_mot'"),
    "no motors in yaml": ("gepetto", [], [("name_mot: ['crank_turn']", "")], "no key 'name_mot'", "add name_mot"),
    "joint types": (
        "gepetto",
        [],
        [("name_mot", "joint_name: [to_b]\njoint_type: [BALL]\nname_mot")],
        "type 'BALL'",
        "",
    ),
    "unknown joint": (
        "gepetto",
        [],
        [("name_mot", "joint_name: [ot_b]\njoint_type: [FIXED]\nname_mot")],
        "'ot_b'",
        "'to_b'",
    ),
    "names and types": (
        "gepetto",
        [],
        [("name_mot", "joint_name: [to_b]\nname_mot")],
        "1 names in joint_name for 0",
        "",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input(case: str, dialect) -> None:
    name, urdf, yaml, found, mend = BAD[case]
    path = dialect(name, urdf=urdf, yaml=yaml)
    reading = read_checked(path)
    assert reading.description is None
    hits = [one for one in reading.problems if found in one.found and mend in one.mend and one.severity == "error"]
    assert hits, [str(one) for one in reading.problems]
    assert hits[0].line or "no key" in found
    assert hits[0].file


def test_no_urdf_beside_the_yaml(tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(YAML)
    (problem,) = read_checked(tmp_path / "robot.yaml").problems
    assert "0 URDF files beside robot.yaml" in problem.found
