"""What MuJoCo's parser brings: files in files, replicas, meshes, couplings, tendons, typos, hostile files."""

from __future__ import annotations

import os
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import mujoco
import numpy as np
import pytest
from kit.mjcf import tetrahedron
from lxml import etree

from cutjoint.description import CutType, JointType, RobotDescription, load_description, read_checked
from cutjoint.errors import DescriptionWarning

Make = Callable[..., Path]
BODY = '<body name="{0}"><joint name="{0}_j" axis="0 1 0" {1}/><geom size="0.1" pos="0.3 0 0"/>{2}</body>'


def body(name: str, joint: str = "", more: str = "") -> str:
    return BODY.format(name, joint, more)


@pytest.fixture
def model(tmp_path: Path) -> Make:
    """model(worldbody, more, name=...) writes an MJCF file."""

    def make(inside: str, more: str = "", name: str = "model.xml") -> Path:
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        text = f'<mujoco model="m"><compiler angle="radian"/>\n<worldbody>{inside}</worldbody>\n{more}</mujoco>'
        path.write_text(text, encoding="utf-8")
        return path

    return make


def errors(path: Path) -> list[str]:
    return [f"{one} {one.file}" for one in read_checked(path).problems if one.severity == "error"]


def links(robot: RobotDescription) -> list[str]:
    return [link.name for link in robot.links]


def test_included_files_are_read_and_blamed(model: Make, tmp_path: Path) -> None:
    model(body("arm"), "<equality/>", name="parts/arm.xml")
    path = model('<geom type="plane" size="1 1 1"/>', '<include file="parts/arm.xml"/>')
    assert links(load_description(path)) == ["world", "arm"]
    part = tmp_path / "parts" / "arm.xml"
    part.write_text(part.read_text().replace("axis=", "aixs="), encoding="utf-8")
    (problem,) = errors(path)
    assert f"{part}:2: unknown attribute 'aixs' of <joint>" in problem
    assert "did you mean 'axis'?" in problem


@pytest.mark.parametrize("name", ["model.xml", "none.xml", "pipe.xml", "doctype.xml"])
def test_what_cannot_be_included_is_refused(name: str, model: Make, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.xml")
    (tmp_path / "doctype.xml").write_text('<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>')
    path = model(body("arm"), f'<include file="{name}"/>')
    assert any(name in one and f"{path}:3" in one for one in errors(path))


def test_attached_models_and_replicas(model: Make) -> None:
    model(body("finger"), name="finger.xml")
    twice = f'<replicate count="2" offset="0 0 1">{body("leg")}</replicate>'
    path = model(twice + '<frame pos="1 0 0"><attach model="finger" prefix="left_"/></frame>')
    text = path.read_text().replace("<worldbody>", '<asset><model name="finger" file="finger.xml"/></asset><worldbody>')
    path.write_text(text, encoding="utf-8")
    robot = load_description(path)
    assert {"leg0", "leg1", "left_finger"} <= set(links(robot))
    np.testing.assert_allclose(robot.joint("left_finger_j").placement[:3, 3], [1.0, 0.0, 0.0])
    np.testing.assert_allclose(robot.joint("leg_j1").placement[:3, 3], [0.0, 0.0, 1.0])


def meshes(tmp_path: Path, path: Path) -> Path:
    """The model with a mesh `part.stl` in its assets."""
    asset = '<asset><mesh name="part" file="part.stl" scale="1 2 1"/></asset>'
    path.write_text(path.read_text().replace("<worldbody>", f"{asset}<worldbody>"), encoding="utf-8")
    (tmp_path / "part.stl").write_bytes(tetrahedron())
    return path


def test_inertia_of_a_mesh_is_mujocos_and_its_shape_stays_where_it_is(model: Make, tmp_path: Path) -> None:
    part = '<geom type="mesh" mesh="part" pos="0.1 0.2 0.3" euler="0.4 0.5 0.6"/>'
    path = meshes(tmp_path, model(body("arm", more=part)))
    link = load_description(path).link("arm")
    compiled = mujoco.MjModel.from_xml_path(str(path))
    assert link.inertial is not None
    assert link.inertial.mass == pytest.approx(compiled.body_mass[1], rel=1e-14)
    np.testing.assert_allclose(link.inertial.com, compiled.body_ipos[1], atol=1e-14)
    (shape,) = [one for one in link.collisions if one.kind == "mesh"]
    np.testing.assert_allclose(shape.placement[:3, 3], [0.1, 0.2, 0.3], atol=1e-14)
    assert shape.size == (1.0, 2.0, 1.0)


@pytest.mark.parametrize("joint", ["", "<joint/>"])
def test_a_mesh_that_is_not_there(joint: str, model: Make, tmp_path: Path) -> None:
    """Of looks, or on a base: passed by a lenient reader; the inertia of what moves is missing for good."""
    base = f'<body name="base">{joint}<geom type="mesh" mesh="part"/>{body("arm")}</body>'
    path = meshes(tmp_path, model(base))
    (tmp_path / "part.stl").unlink()
    (problem,) = [one for one in read_checked(path).problems if one.severity == "error"]
    assert problem.tolerable == (not joint)
    assert "part.stl" in problem.found
    if not joint:
        assert not load_description(path, lenient=True).link("base").collisions
    looks = meshes(tmp_path, model(body("arm", more='<geom type="mesh" mesh="part" mass="0"/>')))
    (tmp_path / "part.stl").unlink()
    assert load_description(looks, lenient=True).link("arm").inertial is not None


COUPLED = {
    '<joint joint1="a_j" joint2="b_j" polycoef="0.1 -2 0 0 0"/>': lambda b, c: 0.3 + 0.1 - 2.0 * (b + 0.2),
    '<joint joint1="a_j" joint2="b_j" polycoef="0.1 -2 0.5 0.25 -0.125"/>': lambda b, c: (
        0.4 - 2 * (b + 0.2) + 0.5 * (b + 0.2) ** 2 + 0.25 * (b + 0.2) ** 3 - 0.125 * (b + 0.2) ** 4
    ),
    '<joint joint1="a_j" polycoef="0.4 9 9 9 9"/>': lambda b, c: 0.7,
    '<joint joint1="a_j"/>': lambda b, c: 0.3,
    '<tendon tendon1="sum" polycoef="0.1 9 9 9 9"/>': lambda b, c: 0.3 + (0.1 - 0.25 * (b + 0.2) + 0.75 * c) / -0.5,
    '<tendon tendon1="one" tendon2="two" polycoef="0.1 2 0 0 0"/>': lambda b, c: 0.3 + 0.1 + 2.0 * (b + 0.2 - 3.0 * c),
    '<tendon tendon1="one" tendon2="last" polycoef="0.1 2 1 0 0"/>': lambda b, c: 0.3 + 0.1 + 8.0 * c + 16.0 * c * c,
}
TENDONS = """<tendon>
  <fixed name="sum"><joint joint="a_j" coef="-0.5"/><joint joint="b_j" coef="0.25"/>
  <joint joint="c_j" coef="-0.75"/></fixed>
  <fixed name="one"><joint joint="a_j" coef="1"/></fixed><fixed name="last"><joint joint="c_j" coef="4"/></fixed>
  <fixed name="two"><joint joint="b_j" coef="1"/><joint joint="c_j" coef="-3"/></fixed>
</tendon>"""


@pytest.mark.parametrize("equality", COUPLED)
def test_couplings_are_those_of_mujoco(equality: str, model: Make) -> None:
    """By hand, and by the residual that MuJoCo has where ours is 0."""
    three = body("a", 'ref="0.3"') + body("b", 'ref="-0.2"') + body("c")
    path = model(three, f"{TENDONS}<equality>{equality}</equality>")
    (coupling,) = load_description(path).couplings
    compiled = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(compiled)
    for b, c in np.random.default_rng(0).uniform(-1, 1, (5, 2)):
        values = {"a_j": COUPLED[equality](b, c), "b_j": b, "c_j": c}
        driven = sum(one.curve.at(values[one.driver]).value for one in coupling.drives) + coupling.offset
        assert values[coupling.joint] == pytest.approx(driven, abs=1e-14)
        data.qpos[:] = [values["a_j"], b, c]
        mujoco.mj_forward(compiled, data)
        assert np.abs(data.efc_pos[data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)]).max() < 1e-14


def test_many_equalities_find_followers(model: Make) -> None:
    """A ring of gears, one of them too many, in an order in which each wishes for a follower that is taken."""
    ties = (("a", "b", 0.1), ("a", "c", 0.3), ("b", "c", 0.2))
    ring = "".join(f'<joint joint1="{y}_j" joint2="{x}_j" polycoef="{by} 1 0 0 0"/>' for y, x, by in ties)
    path = model(body("a") + body("b") + body("c"), f"<equality>{ring}</equality>")
    reading = read_checked(path)
    assert [one.found for one in reading.problems] == ["<joint> 'joint_3' in <equality> follows from the others"]
    assert reading.description is not None
    assert len(reading.description.couplings) == 2
    path.write_text(path.read_text().replace('polycoef="0.2', 'polycoef="0.25'), encoding="utf-8")
    assert any("contradicts the others" in one for one in errors(path))


def test_a_rod_of_two_sites_is_a_distance(model: Make) -> None:
    ends = '<site name="w" pos="0 0 1"/>' + body("a", more='<site name="s" pos="0.4 0 0"/>')
    rod = '<tendon><spatial name="rod"><site site="w"/><site site="s"/></spatial></tendon>'
    path = model(ends, f'{rod}<equality><tendon name="held" tendon1="rod" polycoef="0.1 0 0 0 0"/></equality>')
    (cut,) = load_description(path).cuts
    assert (cut.type, cut.name) == (CutType.DISTANCE, "held")
    assert cut.length == pytest.approx(np.hypot(0.4, 1.0) + 0.1, abs=1e-15)


@pytest.mark.parametrize("tied", [True, False])
def test_actuators_of_tendons(tied: bool, model: Make) -> None:
    """Where the joints move as one it acts on that one: the same power at the same force; else on the tendon itself."""
    fixed = '<tendon><fixed name="t"><joint joint="a_j" coef="0.5"/><joint joint="b_j" coef="2"/></fixed></tendon>'
    equality = '<equality><joint joint1="a_j" joint2="b_j" polycoef="0 3 0 0 0"/></equality>' if tied else ""
    motor = '<actuator><motor tendon="t" gear="10" forcerange="-2 2"/></actuator>'
    key = '<keyframe><key qpos="0.3 0.1"/></keyframe>'
    robot = load_description(model(body("a") + body("b"), fixed + equality + motor + key))
    if tied:
        assert robot.actuators == ("b_j",)
        assert robot.joint("b_j").limits.effort == pytest.approx(20.0 * (0.5 * 3.0 + 2.0))
        assert robot.homes[0].actuated == {"b_j": 0.1}
    else:
        assert robot.actuators == ("t",)
        assert robot.joint("t").limits.effort == 20.0
        assert robot.joint("t").type is JointType.PRISMATIC
        assert robot.homes[0].actuated["t"] == pytest.approx(0.5 * 0.3 + 2.0 * 0.1)


TOLD = {
    '<tendon><fixed name="t" stiffness="3" springlength="0.1 0.2"><joint joint="a_j" coef="1"/></fixed></tendon>': (
        "springlength of <fixed> 't' is 0.1 0.2", "error"),
    '<actuator><motor site="s" gear="0 0 1 0 0 0"/></actuator>': ("<motor> on a site is not read", "error"),
    '<actuator><adhesion name="glue" body="a" ctrlrange="0 1"/></actuator>': (
        "'glue' on a body is not read", "warning"),
    '<tendon><spatial name="t"><site site="s"/><site site="w"/></spatial></tendon>'
    '<actuator><muscle name="flexor" tendon="t"/></actuator>': (
        "<muscle> 'flexor' on the spatial tendon 't' (site, site)", "error"),
    '<actuator><motor joint="ball"/></actuator>': ("<motor> on the spherical joint 'ball'", "error"),
    '<extension><plugin plugin="nobody.knows"/></extension>': ('<plugin plugin="nobody.knows"> in <ext', "warning"),
    '<actuator><plugin plugin="nobody.knows" joint="a_j"/></actuator>': ("in <actuator> is not used", "error"),
}  # fmt: skip


@pytest.mark.parametrize("more", TOLD)
def test_what_acts_and_is_not_read_is_told(more: str, model: Make) -> None:
    found, severity = TOLD[more]
    site = '<site name="s"/>'
    ball = '<body pos="1 0 0"><joint name="ball" type="ball"/><geom size="0.1"/></body>'
    path = model(f'<site name="w" pos="0 0 1"/>{ball}{body("a", more=site)}', more)
    (problem,) = [one for one in read_checked(path).problems if found in one.found]
    assert (problem.severity, problem.tolerable) == (severity, severity == "error")
    assert load_description(path, lenient=True).actuators == (() if "<actuator>" in more else ("a_j",))


SPATIAL = '<tendon><spatial name="t" {}><site site="w"/><site site="{}"/></spatial></tendon>'
ENDS = '<site name="w" pos="0 0 1"/><site name="v" pos="0 1 1"/><body><joint/><geom size="1"/><site name="s"/></body>'
REFUSED = {
    "stiffness of <spatial> 't' (site, site), springlength 0.1 0.2": (
        ENDS, SPATIAL.format('stiffness="3" springlength="0.1 0.2"', "s")
    ),
    "damping of <spatial> 't'": (ENDS, SPATIAL.format('damping="3"', "s")),
    "stiffness, armature of <spatial> 't'": (ENDS, SPATIAL.format('stiffness="3" armature="1"', "s")),
    "stiffness of <spatial> 't' (site, site), springlength 1 1": (ENDS, SPATIAL.format('stiffness="3"', "v")),
    "replicas": ('<replicate count="1000"><replicate count="1000"><geom size="1"/></replicate></replicate>', ""),
    "a body that deforms": ('<flexcomp name="f" type="grid" count="99 99 99" spacing="1 1 1" dim="3"/>', ""),
    "holds the spatial tendon 't' (site, sphere, site)": (
        '<site name="w" pos="0 0 1"/><site name="v" pos="0 1 1"/><geom name="g" size="0.1"/>',
        '<tendon><spatial name="t"><site site="w"/><geom geom="g"/><site site="v"/></spatial></tendon>'
        '<equality><tendon tendon1="t"/></equality>',
    ),
    "forcerange of <motor> of joint 'a_j' is upside down: 3 -3": (
        "", '<actuator><motor joint="a_j" forcerange="3 -3"/></actuator>'
    ),
    "has a polynomial of 2 joints": (
        "", f'{TENDONS}<equality><tendon tendon1="one" tendon2="two" polycoef="0 1 1 0 0"/></equality>'
    ),
}  # fmt: skip


LOOKS = {  # what MuJoCo refuses -> whether that is so even where the geom has weight
    '<geom size="-1"/>': True,
    '<geom size="0.1" pos="1 2"/>': True,
    '<geom type="mesh" mesh="nowhere"/>': True,
    '<geom size="0.1" rgba="1 2"/>': False,
    '<geom size="0.1" rgba="7 0 0 1"/>': False,
    '<geom size="0.1" material="nowhere"/>': False,
    '<geom size="0.1" material="odd"/>': False,
    '<camera fovy="-4"/><frame><geom size="-1"/></frame>': True,
}


@pytest.mark.parametrize("flaw", LOOKS)
def test_looks_that_mujoco_refuses_are_doubted(flaw: str, model: Make) -> None:
    asset = '<asset><material name="odd" texture="nowhere"/></asset>'
    inertial = '<inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/>'
    still = model(body("a", more=inertial + flaw), asset)
    assert [one.tolerable for one in read_checked(still).problems if one.severity == "error"]
    with pytest.warns(DescriptionWarning):
        link = load_description(still, lenient=True).link("a")
    assert link.inertial is not None
    assert link.inertial.mass == 2.0
    heavy = read_checked(model(body("a", more=flaw), asset)).problems
    assert any(not one.tolerable for one in heavy if one.severity == "error") == LOOKS[flaw]


@pytest.mark.parametrize("found", REFUSED)
def test_what_cannot_be_read_is_refused_at_once(found: str, model: Make) -> None:
    inside, more = REFUSED[found]
    path = model(inside + body("a") + body("b") + body("c"), more)
    assert any(found in one and ":" in one for one in errors(path))


def test_nothing_is_left_behind(model: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd) -> None:
    """MuJoCo writes its warnings to a file where it runs, and on stdout."""
    monkeypatch.chdir(tmp_path)
    path = model(body("a"), '<size njmax="8000000" nconmax="4000000"/><option><flag energy="enable"/></option>')
    path.write_text(path.read_text().replace("<compiler", '<compiler settotalmass="3"'))
    assert load_description(path).link("a").inertial.mass == pytest.approx(3.0)
    assert [one.name for one in tmp_path.iterdir()] == ["model.xml"]
    assert capfd.readouterr() == ("", "")


def swapped(word: str) -> str:
    """A word with the first two letters that differ swapped."""
    at = next((n for n in range(len(word) - 1) if word[n] != word[n + 1]), None)
    return word + "x" if at is None else word[:at] + word[at + 1] + word[at] + word[at + 2 :]


SEED = Path(__file__).parent / "samples" / "everything.xml"


@pytest.mark.parametrize("number", [9, 20])
def test_a_slip_of_a_name_is_found_with_what_was_meant(number: int, tmp_path: Path) -> None:
    """The tag and every attribute of an element, two letters swapped: an error that names it and what was meant."""
    attributes = list(list(etree.fromstring(SEED.read_bytes()).iter(etree.Element))[number].attrib)
    for slip in ["", *attributes]:
        root = etree.fromstring(SEED.read_bytes())
        element = list(root.iter(etree.Element))[number]
        meant = slip or element.tag
        if slip:
            element.set(swapped(slip), element.attrib.pop(slip))
        else:
            element.tag = swapped(element.tag)
        (tmp_path / "model.xml").write_bytes(etree.tostring(root))
        found = [one for one in errors(tmp_path / "model.xml") if swapped(meant) in one and meant in one]
        assert found, meant


@pytest.mark.parametrize("found", ["", "3.3.6", "2.9"])
def test_without_mujoco_it_says_what_to_install(found: str, model: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    def version(name: str) -> str:
        if not found:
            raise PackageNotFoundError(name)
        return found

    monkeypatch.setattr("cutjoint.description.formats.mjcf.reader.version", version)
    (problem,) = errors(model(body("a")))
    assert (f"MuJoCo {found} is too old" if found else "MuJoCo, which is not installed") in problem
    assert "pip install 'cutjoint[formats]'" in problem


def test_a_file_that_takes_too_long_is_an_error(model: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    path = model(f'<replicate count="3000">{body("a")}</replicate>')
    monkeypatch.setattr("cutjoint.description.formats.mjcf.reader.SECONDS", 0.05)
    (problem,) = errors(path)
    assert "MuJoCo took longer than 0.05 s on this file" in problem
    monkeypatch.undo()
    assert links(load_description(model(body("b")))) == ["world", "b"]
