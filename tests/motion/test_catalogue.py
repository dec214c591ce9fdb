"""The trajectories by name: they start at home, at rest where they say so, in directions that the robot can take; and
what is written wrongly is told."""

import re
from dataclasses import replace

import numpy as np
import pytest
from kit.led import stand
from kit.led_robots import LED, drawn, somewhere
from kit.quickly import few
from kit.shipped import DETERMINED

import cutjoint
from cutjoint.chain import ClosedChain
from cutjoint.errors import InputError, UnknownNameError, UnreachableError
from cutjoint.motion import TRAJECTORIES, JointMotion, PickAndPlace, Reference
from cutjoint.motion.catalogue import describe, trajectory

STARTS_MOVING = {"circle", "lissajous", "joint-sine"}
SMALL = {
    "hold": "",
    "about-home": "",
    "line": ":0.01,0,0.01",
    "trapezoidal": ":0.01,0,0.01,0.5",
    "waypoints": ":1,0.01,0,0,0.01,0,0.01",
    "pick-and-place": ":0.8,0.03",
    "circle": ":0.01",
    "lissajous": ":0.02,0.01",
    "spiral": ":0.01",
    "helix": ":0.01,0.01",
    "turn": ":2,0,3",
    "pose": ":0.01,0,0,0,2,0",
    "joint-sine": ":0.01",
    "joint-chirp": ":0.01",
}
TURNS, POINTS = {"turn", "pose"}, {"helix"}
"""What a robot that leads its point alone, or one that leads it in a plane alone, cannot follow."""


def small(name, mechanism):
    if name == "joint-waypoints":
        return f"{name}:1," + ",".join(["0.01"] * mechanism.n)
    return name + SMALL[name]


@pytest.mark.parametrize("robot", ["stewart", "fivebar", "omega3", "cpm", "fourbar"])
def test_each_starts_at_home_and_what_fits_is_followed(robot):
    chain = cutjoint.load(robot)
    for name in TRAJECTORIES:
        spec = small(name, chain)
        if chain.n == 1 and not (name.startswith("joint") or name == "hold"):
            continue
        made = trajectory(spec, chain)
        first = made.at(0.0)
        if isinstance(first, JointMotion):
            assert np.allclose(first.q, chain.home.q, atol=1e-12)
        else:
            assert np.allclose(first.position, chain.task.home.position, atol=1e-12)
        velocity = first.v if isinstance(first, JointMotion) else first.velocity
        assert np.any(velocity) == (name in STARTS_MOVING)
        if (name in TURNS and "rx" not in chain.task.names) or (name in POINTS and len(chain.task.names) < 3):
            with pytest.raises(UnreachableError, match=f"cannot be followed by {robot}, which leads {chain.task}"):
                Reference(made, chain)
        else:
            assert np.isfinite(Reference(made, chain).at(0.4 * made.duration).a).all()


def test_every_row_is_tried():
    assert {*SMALL, "joint-waypoints"} == set(TRAJECTORIES)


@pytest.mark.parametrize("name", ["stewart", "planar_3rrr", "fivebar", "delta", "schoenflies"])
@pytest.mark.parametrize("seed", few([0, 3], 3))
def test_figures_lie_where_the_point_can_be_led(name, seed, tmp_path):
    """In a plane of any robot, however it stands, with the orientation held where it is led."""
    robot = somewhere(name, seed, tmp_path, np.random.default_rng(seed))
    size = 0.03 * robot.length
    for spec in (f"circle:{size}", f"lissajous:{size},{size}", f"spiral:{size}", f"pick-and-place:1,{size}"):
        reference = Reference(trajectory(spec, robot.chain), robot.chain)
        at = reference.at(0.37)
        assert np.abs(robot.chain.tool(at.posture).position - at.tool.position).max() < 1e-11 * robot.length


@pytest.mark.parametrize("name", few(LED, "stewart", "planar_3rrr", "tripod"))
def test_turns_are_about_the_axes_of_the_task(name, tmp_path):
    """Those that are led are followed; any other is refused with its name and how far it would go."""
    robot = somewhere(name, 1, tmp_path, np.random.default_rng(1))
    chain, task = robot.chain, robot.chain.task
    for axis, word in enumerate(("rx", "ry", "rz")):
        spec = "turn:" + ",".join("3" if one == axis else "0" for one in range(3))
        if word in task.names:
            end = chain.tool(Reference(trajectory(spec, chain), chain).at(1.0).posture).pose
            found = dict(zip(task.names, task.coordinates(end), strict=True))
            assert np.isclose(found[word], np.radians(3.0), atol=1e-11)
        elif not set(task.names) & {"rx", "ry", "rz"}:
            with pytest.raises(UnreachableError, match=rf"would miss (.*, )?{word} by "):
                Reference(trajectory(spec, chain), chain)


@pytest.mark.parametrize("robot", ["cpm", "stewart", "fivebar", "omega3"])
def test_pick_and_place_is_the_cycle_of_the_industry_or_what_fits(robot):
    chain = cutjoint.load(robot)
    cycle = trajectory("pick-and-place:0.5", chain)
    assert isinstance(cycle, PickAndPlace)
    width, lift = np.linalg.norm(cycle.across), np.linalg.norm(cycle.up)
    assert np.isclose(lift / width, 25.0 / 305.0)
    assert width <= 0.305 + 1e-12
    assert (width > 0.3049) == (robot == "cpm")
    assert cycle.cycles_per_minute == 120.0
    assert "120 cycles a minute" in cycle.name
    Reference(cycle, chain)


def test_a_tripod_that_holds_its_tilt_moves_along_a_line(tmp_path):
    """A point above its plate is moved by tilting too; but the tilt is led, and stays."""
    robot = stand(drawn("tripod", 0), tmp_path)
    assert robot.description.tool is not None
    above = robot.description.tool.placement.copy()
    above[:3, 3] += above[:3, :3] @ [0.03, 0.01, 0.1]
    tool = replace(robot.description.tool, placement=above)
    chain = ClosedChain(replace(robot.description, tool=tool, task=("z", "rx", "ry")))
    assert np.linalg.matrix_rank(chain.tool(chain.home).jacobian, tol=1e-3) > 1
    with pytest.raises(InputError, match="moves along a line; it cannot follow a circle"):
        trajectory("circle:0.001", chain)


@pytest.mark.parametrize("robot", DETERMINED)
def test_figures_need_two_directions(robot):
    chain = cutjoint.load(robot)
    if chain.n > 1:
        return
    for spec in ("circle:0.01", "lissajous:0.01,0.01", "spiral:0.01", "pick-and-place"):
        with pytest.raises(InputError, match="moves along a line; it cannot follow"):
            trajectory(spec, chain)


@pytest.mark.parametrize(
    ("spec", "about"),
    [
        ("line", "write line:X,Y,Z[,SECONDS]"),
        ("line:1,2", "Found 2 numbers"),
        ("line:1,2,3,4,5", "Found 5 numbers"),
        ("line:1,two,3", "'two' is no number"),
        ("line:1,,3", "'' is no number"),
        ("line:nan,0,0", "'nan' is not finite"),
        ("line:inf,0,0", "'inf' is not finite"),
        ("line:0,0,0,0", "duration"),
        ("trapezoidal:0,0,0.1,-2", "duration"),
        ("circle:-0.1", "radius"),
        ("circle:0.01,0", "seconds"),
        ("lissajous:0.01,0", "height"),
        ("spiral:0", "radius"),
        ("helix:0,1", "radius"),
        ("turn:1,2,3,0", "duration"),
        ("waypoints:1", "waypoints:SECONDS,X,Y,Z[,X,Y,Z...]"),
        ("waypoints:1,2", "3 numbers each (x, y, z); 1 numbers"),
        ("waypoints:1,0,0,0", "way-points 1 and 2 are the same"),
        ("waypoints:-1,0,0,0.1", "seconds"),
        ("joint-waypoints:1,2", "3 numbers each (arm1, arm2, arm3)"),
        ("pick-and-place:0", "duration"),
        ("pick-and-place:1,-0.2", "width"),
        ("joint-sine:0.1,0", "hertz"),
        ("joint-chirp:0.1,-1", "hertz"),
    ],
)
def test_wrong_numbers_are_told(spec, about):
    chain = cutjoint.load("omega3")
    with pytest.raises(InputError, match=re.escape(about)):
        trajectory(spec, chain)


@pytest.mark.parametrize(("spec", "near"), [("lines:1,2,3", "line"), ("helis", "helix"), ("joint-sin:1", "joint-sine")])
def test_unknown_names_are_told_with_the_nearest(spec, near):
    with pytest.raises(UnknownNameError, match=f"did you mean '{near}'"):
        trajectory(spec, cutjoint.load("fivebar"))


@pytest.mark.parametrize("name", TRAJECTORIES)
def test_each_says_how_it_is_written(name):
    words = describe(name)
    assert words.startswith(name + TRAJECTORIES[name].form)
    assert all(one.name in words for one in TRAJECTORIES[name].arguments)
