"""Syntheses with known answers: a balanced arm, and its front of mass and torque."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.description import Frame, Inertial, Joint, JointType, Limits, Link, RobotDescription, load_description
from cutjoint.description.transforms import placement
from cutjoint.errors import InputError, Interrupted, UnknownNameError
from cutjoint.robots import load
from cutjoint.synthesis import (
    QUANTITIES,
    Design,
    DesignProblem,
    Synthesis,
    Variable,
    Want,
    closed,
    judged,
    problem_of,
    read_order,
    synthesise,
)
from cutjoint.synthesis import search as searching
from cutjoint.synthesis.keeping import check_folder, designs_csv, keep

WEIGHT = "links.counter.mass"
BALANCED = 5.0
"""kg at 0.2 m that balance 2 kg at 0.5 m."""


def arm() -> RobotDescription:
    """A level arm on a hinge, with a counterweight behind it."""
    ball = np.diag([0.01] * 3)
    return RobotDescription(
        "arm",
        (
            Link("base"),
            Link("rod", Inertial(2.0, np.array([0.5, 0.0, 0.0]), ball)),
            Link("counter", Inertial(1.0, np.zeros(3), ball)),
        ),
        (
            Joint("hinge", JointType.CONTINUOUS, "base", "rod", axis=np.array([0.0, 1.0, 0.0])),
            Joint("weld", JointType.FIXED, "rod", "counter", placement((-0.2, 0.0, 0.0))),
        ),
        actuators=("hinge",),
        tool=Frame("rod", placement((1.0, 0.0, 0.0))),
    )


def problem(*wants: Want, low: float = 1.0, high: float = 9.0) -> DesignProblem:
    return problem_of(ClosedChain(arm()), [Variable("weight", "path", (WEIGHT,), low, high)], wants)


@pytest.fixture(autouse=True)
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """In this process: what is searched is quick."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0}, raising=False)


@pytest.mark.slow
def test_one_goal_finds_the_balance() -> None:
    found = synthesise(problem(Want("effort", {"trajectory": "hold"}, "least")), designs=24)
    assert np.isclose(found.designs[found.best].values[0], BALANCED, atol=0.02)
    assert found.designs[found.best].found["effort (hold)"] < 0.04
    assert np.isclose(found.old.found["effort (hold)"], 9.81 * (1.0 - 0.2), rtol=1e-9)
    again = synthesise(found.problem, designs=24)
    assert [one.values[0] for one in again.designs] == [one.values[0] for one in found.designs]


@pytest.mark.slow
def test_two_goals_give_the_front() -> None:
    wants = Want("effort", {"trajectory": "hold"}, "least"), Want("mass", {}, "least")
    found = synthesise(problem(*wants), designs=30, seed=3)
    for k in found.front:
        weight = found.designs[k].values[0]
        assert np.isclose(found.designs[k].found["effort (hold)"], 9.81 * abs(1.0 - 0.2 * weight), atol=1e-9)
    goals = np.array([[one.found[want.name] for want in wants] for one in found.designs])
    for k in range(len(goals)):
        beaten = ((goals <= goals[k]).all(axis=1) & (goals < goals[k]).any(axis=1)).any()
        assert beaten != (k in found.front)


@pytest.mark.slow
def test_bounds_hold_and_what_cannot_be_is_said() -> None:
    bounded = synthesise(problem(Want("effort", {"trajectory": "hold"}, "least"), Want("mass", {}, at_most=5.0)), 24)
    assert np.isclose(bounded.designs[bounded.best].values[0], 3.0, atol=0.05)
    impossible = synthesise(problem(Want("mass", {}, at_most=0.1)), designs=8)
    assert impossible.front == ()
    with pytest.raises(InputError, match=r"none of \d designs does"):
        _ = impossible.best
    assert impossible.reasons() == [("mass out of bounds", len(impossible.designs))]


def test_an_interrupt_keeps_what_is_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = 0

    def interrupted(asked: DesignProblem, values: np.ndarray) -> Design:
        nonlocal calls
        calls += 1
        if calls == 6:
            raise KeyboardInterrupt
        return judged(asked, values)

    monkeypatch.setattr(searching, "judged", interrupted)
    with pytest.raises(Interrupted) as caught:
        synthesise(problem(Want("mass", {}, "least")), designs=20)
    kept = caught.value.result
    assert isinstance(kept, Synthesis)
    assert len(kept.designs) == 5
    assert "stopped" in kept.told[0]


def test_designs_stay_on_the_branch() -> None:
    robot = load("fivebar")
    asked = problem_of(
        robot,
        [Variable("cranks", "stretch", ("left_proximal", "right_proximal"), 0.5, 2.0, "x")],
        [Want("mass", {}, "least")],
    )
    near, far = closed(asked, np.array([1.05])), closed(asked, np.array([0.8]))
    for chain in (near, far):  # the tip on the side where it was
        assert chain.tool(chain.home).position @ robot.tool(robot.home).position > 0.0
    assert judged(asked, [6.0]).why  # too far apart to meet


def test_a_design_is_written_and_read(tmp_path: Path) -> None:
    found = synthesise(problem(Want("effort", {"trajectory": "hold"}, "least")), designs=6)
    folder = tmp_path / "better"
    files = keep(found, folder, "<p>page</p>")
    assert {one.name for one in files} == {"loops.toml", "robot.urdf", "synthesis.html", "designs.csv"}
    read = load_description(str(folder))
    assert read.name == "better"
    inertial = read.link("counter").inertial
    assert inertial is not None
    assert np.isclose(inertial.mass, found.designs[found.best].values[0])
    rows = designs_csv(found).splitlines()
    assert len(rows) == len(found.designs) + 1
    assert rows[0].startswith("design,weight [SI],effort (hold) [N m],front,why")
    with pytest.raises(InputError, match="not empty"):
        check_folder(folder)
    with pytest.raises(InputError, match="is a file"):
        check_folder(folder / "robot.urdf")


def write(folder: Path, text: str) -> Path:
    path = folder / "order.toml"
    path.write_text(text)
    return path


GOOD = """
robot = "fivebar"
designs = 20
[[vary]]
stretch = ["left_proximal"]
along = "x"
range = [0.9, 1.1]
[[vary]]
path = "links.left_distal.mass = links.right_distal.mass"
range = [0.1, 0.4]
[[vary]]
mount = "roll"
range = [-0.1, 0.1]
[[want]]
quantity = "mass"
[[want]]
quantity = "effort"
trajectory = "hold"
at_most = 5
"""


def test_files_are_read(tmp_path: Path) -> None:
    order = read_order(write(tmp_path, GOOD))
    assert (order.designs, order.seed) == (20, 1)
    assert [one.kind for one in order.problem.variables] == ["stretch", "path", "mount"]
    assert [(one.quantity, one.goal) for one in order.problem.wants] == [("mass", "least"), ("effort", None)]


@pytest.mark.parametrize(
    ("old", "new", "error", "message"),
    [
        ("designs", "desings", InputError, "unknown key 'desings' .*did you mean 'designs'"),
        ('"fivebar"', '"fivbar"', UnknownNameError, "fivebar"),
        ('"mass"', '"mas"', InputError, "did you mean 'mass'"),
        ('along = "x"', 'along = "w"', InputError, 'along of .* is .w.; expected "x" or "y" or "z"'),
        ("[0.9, 1.1]", "[1.1, 0.9]", InputError, "the range must grow"),
        ("[0.9, 1.1]", "[0.9]", InputError, "expected 2 numbers"),
        ("[0.9, 1.1]", "[0.0, 1.1]", InputError, "ratios > 0"),
        ("[0.1, 0.4]", "[-0.1, 0.4]", InputError, "mass"),
        ("left_proximal", "left_proximl", UnknownNameError, "left_proximal"),
        ("right_distal.mass", "right_distal.com.x", InputError, "different values"),
        ('"roll"', '"yaw"', InputError, "roll or pitch"),
        ('"hold"', '"hodl"', UnknownNameError, "hold"),
        ("at_most = 5", "at_mots = 5", InputError, "did you mean 'at_most'"),
        ("at_most = 5", 'at_most = "5"', InputError, "expected a number|numbers without quotes"),
        ("at_most = 5", f"at_most = {'9' * 400}", InputError, "number"),
        ("[0.9, 1.1]", f"[0.9, {'9' * 400}]", InputError, "number"),
        ("at_most = 5", "at_most = 5\nat_least = 6", InputError, "more than at_most"),
        ("designs = 20", "designs = 1", InputError, "a whole number from 2"),
        ("designs = 20", "designs = 1000000000000", InputError, "to 1e\\+05"),
        ('mount = "roll"', 'mount = "roll"\npath = "gravity.x"', InputError, "expected one of path"),
        ("[[want]]", "[[wnat]]", InputError, "did you mean 'want'"),
        ("[[vary]]", "[vary]", InputError, "TOML"),
    ],
)
def test_wrong_files_are_refused(tmp_path: Path, old: str, new: str, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message.replace("[", r"\[")):
        read_order(write(tmp_path, GOOD.replace(old, new)))


def test_quantities_say_what_they_need() -> None:
    for name, row in QUANTITIES.items():
        needs = [key for key, (_, default) in row.options.items() if default is None]
        if needs:
            with pytest.raises(InputError, match=f"{name} needs {needs[0]}"):
                Want(name, {}, row.goal)
    with pytest.raises(InputError, match="neither"):
        Want("mass", {})
    with pytest.raises(InputError, match="finite"):
        Want("mass", {}, at_most=float("nan"))
    with pytest.raises(UnknownNameError, match="trajectory"):
        Want("effort", {"trajectry": "hold"}, "least")


def test_what_has_no_meaning_is_told_before_the_search() -> None:
    plain = arm()
    slide = Joint("slide", JointType.PRISMATIC, "rod", "block", placement((0.8, 0.0, 0.0)), limits=Limits(-0.5, 0.5))
    block = Link("block", Inertial(0.5, np.zeros(3), 0.01 * np.eye(3)))
    mixed = replace(
        plain,
        links=(*plain.links, block),
        joints=(*plain.joints, slide),
        actuators=("hinge", "slide"),
        tool=Frame("block"),
    )
    roll = Variable("roll", "mount", ("roll",), -0.1, 0.1)
    asked = problem_of(ClosedChain(mixed), [roll], [Want("effort", {"trajectory": "hold"}, "least")])
    with pytest.raises(InputError, match="take power"):
        synthesise(asked, designs=2)
    with pytest.raises(InputError, match="at least 2"):
        synthesise(problem(Want("mass", {}, "least")), designs=1)
