"""`cutjoint simulate ROBOT` without options: every robot moves about home, and the run tells what was chosen."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from kit.built import built
from kit.mechanisms import MECHANISMS
from kit.shipped import OTHERS, SHIPPED
from typer.testing import CliRunner

from cutjoint.chain import ClosedChain
from cutjoint.chain.massless import undetermined_motions
from cutjoint.commands.simulate import command
from cutjoint.description import catalogue
from cutjoint.errors import ActuationError, DescriptionError, InputError
from cutjoint.mechanism import is_mechanism
from cutjoint.motion import JointSwing, Reference, ToolSwing, about_home
from cutjoint.motion.catalogue import trajectory
from cutjoint.robots import PUBLISHED, load
from cutjoint.simulation.leading import led
from cutjoint.simulation.watched import watched

app = typer.Typer()
app.command()(command)


def simulate(*words: object) -> Any:
    return CliRunner().invoke(app, [str(one) for one in words])


def ran(done: Any) -> dict[str, Any]:
    """The figures of a run that can be believed, and that followed what there was to follow."""
    assert done.exit_code == 0, (done.exception, done.output[-500:])
    figures: dict[str, Any] = json.loads(done.stdout)
    assert max(figures["loop_gap_m"], figures["loop_gap_rad"]) < 1e-9
    assert figures["energy_drift"] < 1e-6
    return figures


def followed(figures: dict[str, Any], most: float) -> None:
    """It kept to its way by `most` [m] and [rad]."""
    assert figures["trajectory"] == "about home"
    assert figures["duration_s"] == pytest.approx(1.0)
    assert figures["error_worst_m"] < most
    assert figures.get("error_worst_rad", 0.0) < most


def loaded(name: str | Path) -> ClosedChain | DescriptionError:
    try:
        return load(name)
    except DescriptionError as error:
        return error


def checked(name: str | Path) -> None:
    """`simulate` with defaults does for one robot what can be done, or says what is in the way."""
    chain = loaded(name)
    if isinstance(chain, DescriptionError):
        assert str(simulate(name).exception) == str(chain)
        return
    if chain.n == 0:
        done = simulate(name)
        assert isinstance(done.exception, InputError)
        assert "--free" in str(done.exception) if chain.nv else "no joint that moves" in str(done.exception)
        return
    report = chain.mobility()
    determined = report.determined
    if not determined and report.type2 < 1e-6:
        assert "is singular" in str(simulate(name).exception)
        return
    if joints := undetermined_motions(chain, chain.home.q_full):  # iCub's head is a point, about which its neck spins
        assert f"a motion of {', '.join(joints)} moves no mass" in str(simulate(name).exception)
        return
    figures = ran(simulate(name, "--json"))
    if chain.description.name in PUBLISHED:
        assert figures["error_worst_m"] < 0.05
    elif determined:
        # Idle motions that gain momentum, as of rods that are not round, disturb what the actuators follow; so does
        # rounding where a motion moves next to no mass.
        mass = chain.terms(chain.home).mass
        is_exact = chain.idle_is_cyclic and np.linalg.cond(mass) < 1e12
        followed(figures, 1e-7 if is_exact else 0.01 * chain.length)
    else:
        assert "trajectory" not in figures
    if not determined or chain.description.name not in PUBLISHED:
        assert figures["chosen"]


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_every_robot_that_ships(name: str) -> None:
    checked(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(catalogue.example_names(), key=lambda one: one[::-1]))
def test_every_robot_of_example_robot_data(name: str) -> None:
    checked(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", MECHANISMS)
def test_drawn_mechanisms(name: str, tmp_path: Path) -> None:
    """Robots that nobody chose by hand; some have no tool, some fly."""
    plan = MECHANISMS[name](np.random.default_rng([14, *name.encode()])).plan
    chain, _ = built(plan, tmp_path)
    assert chain.description.path is not None
    checked(chain.description.path)


# ---- the motion ----------------------------------------------------------------------------------------------------


def test_a_sound_task_is_led_by_its_tool() -> None:
    robot = load("fivebar")
    swing = about_home(robot)
    assert isinstance(swing, ToolSwing)
    start, middle, end = (swing.at(t) for t in (0.0, 0.5, 1.0))
    assert np.array_equal(start.position, robot.tool(robot.home).position)
    assert np.array_equal(start.position, end.position)
    for one in (start, end):
        assert not one.velocity.any()
        assert not one.acceleration.any()
    assert 1e-3 < np.linalg.norm(middle.position - start.position) < 0.05 * robot.length


@pytest.mark.parametrize(("kind", "spec"), [(ToolSwing, "fivebar"), (JointSwing, "fourbar")])
def test_rates_are_derivatives(kind: type, spec: str) -> None:
    swing = about_home(load(spec), 0.05, 0.8)
    assert isinstance(swing, kind)
    h = 1e-5
    for t in (0.1, 0.37, 0.4, 0.71):
        before, now, after = (swing.at(t + step) for step in (-h, 0.0, h))
        place, v, a = ("position", "velocity", "acceleration") if kind is ToolSwing else ("q", "v", "a")
        assert np.allclose((getattr(after, place) - getattr(before, place)) / (2 * h), getattr(now, v), atol=1e-8)
        assert np.allclose((getattr(after, v) - getattr(before, v)) / (2 * h), getattr(now, a), atol=1e-7)


def _limited(low: float, high: float) -> ClosedChain:
    """The five-bar with limits of a shoulder about home, [rad]."""
    robot = load("fivebar")
    at = robot.home.actuated["left_shoulder"]
    joints = [
        replace(one, limits=replace(one.limits, lower=at + low, upper=at + high))
        if one.name == "left_shoulder"
        else one
        for one in robot.description.joints
    ]
    return robot.rebuilt(replace(robot.description, joints=tuple(joints)))


@pytest.mark.parametrize(("low", "high"), [(-1.0, 0.0), (0.0, 1.0), (-0.01, 0.01), (-1e-3, 0.0)])
def test_it_stays_within_limits(low: float, high: float) -> None:
    """Turned round or made smaller; it says so, and the robot moves all the same."""
    robot = _limited(low, high)
    reference = Reference(about_home(robot), robot)
    places = np.array([reference.at(t).q for t in np.linspace(0.0, 1.0, 41)]) - robot.home.q
    assert low - 1e-9 <= places[:, 0].min() <= places[:, 0].max() <= high + 1e-9
    assert np.abs(places).max() > 1e-5


def test_a_robot_beyond_its_limits_tells_so_and_rests_there() -> None:
    swing = about_home(_limited(0.1, 1.0))
    assert isinstance(swing, JointSwing)
    assert swing.way[0] == 0.0
    assert "left_shoulder" in " ".join(swing.chosen)


def test_a_fixed_actuator_rests() -> None:
    swing = about_home(_limited(0.0, 0.0))
    assert isinstance(swing, JointSwing)
    assert swing.way[0] == 0.0 != swing.way[1]


def test_its_numbers() -> None:
    robot = load("fourbar")
    swing = trajectory("about-home:0.1,2", robot)
    assert isinstance(swing, JointSwing)
    assert np.abs(swing.way).max() == pytest.approx(0.1)
    assert swing.duration == 2.0
    for wrong in ("about-home:0", "about-home:-1", "about-home:0.1,0", "about-home:1,2,3", "about-home:x"):
        with pytest.raises(InputError):
            trajectory(wrong, robot)
    for other in OTHERS:
        with pytest.raises(ActuationError):
            trajectory("about-home", load(other))


# ---- robots whose actuators do not determine the motion ------------------------------------------------------------


@pytest.mark.slow
def test_what_nothing_drives_is_told() -> None:
    figures = ran(simulate("underactuated", "--json"))
    assert figures["law"] == "actuators led about home"
    assert "1 of 2 freedoms are driven" in " ".join(figures["chosen"])


def test_led_actuators_accelerate_as_wanted_at_home() -> None:
    """The law's inertia is that of the robot: an effort for an acceleration gives it, whatever else moves."""
    for name in OTHERS:
        robot = load(name)
        law = led(robot, 1.0, 400.0, 40.0).law
        wanted = np.linspace(0.3, 0.5, robot.n)
        if name == "redundant":  # the actuators depend on each other
            minimal = robot.minimal()
            wanted = minimal.effort_map(robot.home).T @ wanted[: minimal.n]
        full = robot.full_effort(law.holding[0] + law.inertia @ wanted)
        found = robot.full_forward_dynamics(robot.home, np.zeros(robot.nv), full).acceleration
        assert np.allclose(robot.actuated_velocity(found), wanted, rtol=1e-9)


def test_least_efforts() -> None:
    """No part of the efforts of a redundant robot presses its links against each other."""
    robot = load("redundant")
    law = led(robot, 1.0, 400.0, 40.0).law
    still = np.zeros(robot.nv)
    preload = robot.full_inverse_dynamics(robot.home, still, still).preload
    assert preload.shape == (3, 1)
    for part in (law.inertia, *law.holding):
        assert np.abs(preload.T @ part).max() < 1e-6 * max(1.0, np.abs(part).max())


@pytest.mark.slow
def test_gains_are_taken_where_actuators_are_led() -> None:
    figures = ran(simulate("underactuated", "--kp", "100", "--kd", "20", "--json"))
    assert figures["gains"] == {"kp": [[100.0]], "kd": [[20.0]]}
    assert isinstance(simulate("underactuated", "--kp", "1,2", "--kd", "20").exception, InputError)


def test_a_trajectory_that_cannot_be_followed_tells_what_can_be_done() -> None:
    done = simulate("redundant", "--trajectory", "line:0.02,0,0")
    assert isinstance(done.exception, InputError)
    assert "led about home" in str(done.exception)


# ---- robots without a tool, without actuators ----------------------------------------------------------------------


def test_the_longest_limb_is_recorded_where_no_tool_is_named() -> None:
    robot = load("fivebar")
    bare = robot.rebuilt(replace(robot.description, tool=None, task=()))
    found, link = watched(bare)
    assert link is not None
    assert found.description.tool is not None
    assert watched(found) == (found, None)
    above = {joint.child: joint.parent for joint in robot.description.joints}
    depth = 0
    while link in above:
        link, depth = above[link], depth + 1
    assert depth == 2


def test_a_task_that_cannot_be_told_is_not_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    def untold(self: object) -> None:
        raise InputError("the task cannot be told")

    monkeypatch.setattr(ClosedChain, "task", property(untold))
    assert is_mechanism(load("fivebar"))
    assert not is_mechanism(object())
    assert not is_mechanism(load("fivebar").description)
