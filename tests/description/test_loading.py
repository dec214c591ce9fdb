"""What is loaded is what the files say; defaults of plain URDFs; the catalogue."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cutjoint.description import CutType, JointType, check, load_description
from cutjoint.description.catalogue import names, path, resolve
from cutjoint.errors import UnknownNameError


def test_every_value_arrives(fourbar) -> None:
    robot = load_description(fourbar())
    assert (robot.name, robot.title, robot.source) == ("fourbar", "Planar four-bar", "for the tests")
    assert robot.root == "ground"
    assert robot.actuators == ("crank_turn",)
    assert robot.gravity.tolist() == [0.0, -9.81, 0.0]
    assert robot.tool is not None
    assert robot.tool.link == "coupler"
    assert robot.tool.placement[:3, 3].tolist() == [0.2, 0.1, 0.0]
    (cut,) = robot.cuts
    assert (cut.name, cut.type, cut.type.rows, cut.a.link, cut.b.link) == (
        "tip",
        CutType.REVOLUTE,
        5,
        "coupler",
        "rocker",
    )
    assert (cut.a.placement[0, 3], cut.b.placement[0, 3]) == (0.4, 0.3)
    (home,) = robot.homes
    assert dict(home.actuated) == {"crank_turn": 1.0}
    assert dict(home.passive) == {"coupler_turn": -0.5, "rocker_turn": 1.2}
    crank = robot.link("crank")
    assert crank.visuals[0].kind == "box"
    assert crank.visuals[0].colour == (0.5, 0.5, 0.6, 1.0)
    turn = robot.joint("crank_turn")
    assert turn.type is JointType.REVOLUTE
    assert turn.axis.tolist() == [0.0, 0.0, 1.0]
    assert (turn.limits.lower, turn.limits.upper, turn.limits.velocity, turn.limits.effort) == (-3.0, 3.0, 20.0, 10.0)
    coupler_turn = robot.joint("coupler_turn")
    assert (coupler_turn.physics.damping, coupler_turn.physics.friction) == (0.01, 0.02)
    assert robot.link("coupler").collisions[0].size == (0.01, 0.4)


def test_a_variant_replaces_inertias_only(fourbar) -> None:
    plain, lumped = load_description(fourbar()), load_description(fourbar(), variant="lumped")
    assert lumped.variant_name == "lumped"
    assert lumped.link("crank").inertial.inertia[1, 1] == 0.004
    assert plain.link("crank").inertial.inertia[1, 1] == 0.0013
    assert lumped.link("rocker") is not None
    assert [link.name for link in lumped.links] == [link.name for link in plain.links]


def test_a_turned_inertia_keeps_its_moments(fourbar) -> None:
    tensor = load_description(fourbar()).link("coupler").inertial.inertia
    given = np.array([[0.001, 0.0001, 0.0], [0.0001, 0.0107, 0.0], [0.0, 0.0, 0.0107]])
    cosine, sine = np.cos(0.1), np.sin(0.1)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(tensor, turn @ given @ turn.T, atol=1e-17)
    assert np.array_equal(tensor, tensor.T)
    np.testing.assert_allclose(np.linalg.eigvalsh(tensor), np.linalg.eigvalsh(given), rtol=1e-13)
    assert abs(tensor[0, 1] - given[0, 1]) > 1e-4


def test_a_folder_a_file_and_a_plain_urdf_load(fourbar) -> None:
    loops: Path = fourbar()
    assert load_description(loops.parent).name == load_description(str(loops)).name == "fourbar"
    chain = load_description(loops.parent / "robot.urdf")
    assert chain.cuts == ()
    assert chain.actuators == ("crank_turn", "coupler_turn", "rocker_turn")
    assert chain.tool is None  # two links end the tree


def test_mimic_is_a_coupling_and_no_actuator(fourbar) -> None:
    edits = [('<dynamics damping="0.01" friction="0.02"/>', '<mimic joint="crank_turn" multiplier="-2" offset="0.1"/>')]
    robot = load_description(fourbar(urdf=edits).parent / "robot.urdf")
    (coupling,) = robot.couplings
    assert (coupling.joint, *coupling.gear, coupling.offset) == (
        "coupler_turn",
        "crank_turn",
        -2.0,
        0.1,
    )
    assert robot.actuators == ("crank_turn", "rocker_turn")


@pytest.mark.parametrize("name", names())
def test_shipped_robots_have_no_problems(name: str) -> None:
    assert check(name) == ()
    assert check(load_description(name)) == ()
    assert path(name).is_file()
    robot = load_description(name)
    for variant in robot.variants:
        assert check(robot.variant(variant.name)) == ()


def test_the_two_robots_ship() -> None:
    assert {"cpm", "omega3"} <= set(names())
    with pytest.raises(UnknownNameError, match="did you mean 'omega3'"):
        path("omega")


@pytest.mark.parametrize(("name", "moving", "tool"), [("ur5", 6, "tool0"), ("panda", 9, None), ("talos", 32, None)])
def test_example_robots_load_by_name_as_chains(name: str, moving: int, tool: str | None) -> None:
    robot = load_description(name)
    assert robot.cuts == ()
    assert sum(joint.type is not JointType.FIXED for joint in robot.joints) == moving
    assert (robot.tool.link if robot.tool else None) == tool
    assert resolve(name).is_file()


def test_the_room_needs_no_pinocchio() -> None:
    code = "import sys; from cutjoint.description import check; check('cpm'); "
    code += "print(sorted({'pinocchio', 'scipy'} & set(sys.modules)))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
