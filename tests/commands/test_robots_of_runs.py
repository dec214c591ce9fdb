"""A saved run finds the robot that it was made with, or says that it does not: no other robot stands in silently."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cutjoint.chain import ClosedChain
from cutjoint.chain.massless import undetermined_motions
from cutjoint.commands.simulate import _done
from cutjoint.control import NoControl
from cutjoint.control.usual_gains import usual_gains
from cutjoint.description import Frame, Inertial, Joint, JointType, Link, RobotDescription, catalogue
from cutjoint.description.fingerprint import fingerprint
from cutjoint.errors import DynamicsError, InputError, SimulationError
from cutjoint.report import plot, run_report
from cutjoint.report.named_runs import robot_of
from cutjoint.robots import load
from cutjoint.simulation import load as load_result
from cutjoint.simulation import run, save
from cutjoint.simulation.belief import verdict_of


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """A five-bar of one's own: a folder with another name."""
    shutil.copytree(catalogue.path("fivebar").parent, tmp_path / "some" / "arm")
    told = tmp_path / "some" / "arm" / "loops.toml"
    told.write_text(told.read_text().replace('name = "fivebar"', 'name = "arm"'))
    return tmp_path / "some" / "arm"


def short(chain: ClosedChain, **settings: Any) -> Any:
    return run(chain, NoControl(), **{"duration": 0.01, "every": 0.005, **settings})


def heavier(arm: Path) -> None:
    """Its first link is another one from now on."""
    file = arm / "robot.urdf"
    first = '<mass value="'
    before, _, after = file.read_text().partition(first)
    file.write_text(f"{before}{first}9{after}")


def test_the_file_is_found_from_where_the_result_is(arm: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever folder one works in; robot and result may be moved together, not apart."""
    top = arm.parents[1]
    monkeypatch.chdir(top)
    saved = save(short(load("some/arm")), "run.npz")
    with np.load(saved) as kept:
        assert json.loads(str(kept["about"]))["file"] == "some/arm/loops.toml"
    monkeypatch.chdir(arm)
    assert robot_of(load_result(top / "run.npz")).description.path == arm / "loops.toml"
    monkeypatch.chdir("/")
    moved = shutil.move(top / "some", top / "else" / "some")
    with pytest.raises(InputError, match="which is not there; name it with --robot"):
        robot_of(load_result(top / "run.npz"))
    shutil.move(saved.absolute() if saved.is_absolute() else top / saved, top / "else" / "run.npz")
    assert robot_of(load_result(top / "else" / "run.npz")).description.path == Path(moved) / "arm" / "loops.toml"


def test_a_file_that_changed_is_another_robot(arm: Path) -> None:
    result = short(load(arm))
    assert robot_of(result).name == "arm"
    heavier(arm)
    with pytest.raises(InputError, match="masses, lengths, limits or joint physics differ"):
        robot_of(result)
    assert "masses, lengths" in run_report(result).html
    assert plot(result, "joints").charts
    assert plot(result, "joints", robot=load(arm)).charts  # as it is now: asked for


def test_a_robot_of_the_same_name_does_not_stand_in(arm: Path) -> None:
    """One's own five-bar, called fivebar too, is gone: the one that ships is another one."""
    told = arm / "loops.toml"
    told.write_text(told.read_text().replace('name = "arm"', 'name = "fivebar"'))
    same = short(load(arm))
    heavier(arm)
    other = short(load(arm))
    shutil.rmtree(arm)
    assert robot_of(same).description.path == catalogue.path("fivebar")
    with pytest.raises(InputError, match="differ"):
        robot_of(other)


@pytest.mark.parametrize("options", [{"payload": 0.5}, {"ideal": True}, {"ideal": True, "payload": 0.5}, {}])
def test_options_of_the_robot_are_kept(options: dict[str, Any], tmp_path: Path) -> None:
    chain = load("fivebar", dynamics="ideal" if options.get("ideal") else "real")
    chain = chain.with_payload(options.get("payload", 0.0))
    made = short(chain)
    result, early = _done(None, options, lambda: made, may_end=False)
    assert not early
    found = robot_of(load_result(save(result, tmp_path / "run.npz")))
    assert fingerprint(found.description) == fingerprint(chain.description)


def test_runs_of_several_robots_have_each_their_own() -> None:
    """With a payload the tip carries more: reactions are of the own robot."""
    plain, loaded = load("fivebar"), load("fivebar").with_payload(0.5)
    first, second = short(plain), short(loaded)
    second = _done(None, {"payload": 0.5}, lambda: second, may_end=False)[0]
    both = plot({"plain": first, "loaded": second}, "reactions")
    alone = plot({"loaded": second}, "reactions", robot=loaded)

    def curves(made: Any) -> list[float]:
        every = [one for chart in made.charts for one in chart.curves]
        return sorted(float(np.abs(one.values).max()) for one in every)

    assert set(np.round(curves(alone), 9)) <= set(np.round(curves(both), 9))


def test_what_counts_as_another_robot() -> None:
    robot = load("stewart").description
    assert len({fingerprint(load(name).description) for name in ("fivebar", "stewart", "omega3")}) == 3
    assert fingerprint(robot) == fingerprint(load("stewart", home=robot.homes[0].name).description)
    assert fingerprint(robot) != fingerprint(robot.with_payload(1e-3))


def test_a_run_that_stopped_early_says_so(tmp_path: Path) -> None:
    robot = load("fivebar")

    def fails(t: float) -> list[float]:
        return [float("nan") if t > 0.005 else 0.0] * 2

    with pytest.raises(SimulationError) as caught:
        run(robot, fails, duration=0.02, every=0.001, rate=1000.0)
    result = load_result(save(caught.value.result, tmp_path / "run.npz"))  # type: ignore[arg-type]
    assert "of 0.02 s" in result.about["stopped"]
    verdict = verdict_of(result, robot)
    assert verdict.grade == "half"
    assert "whole run: stopped" in verdict.sentence
    assert "(stopped at 0.00" in plot(result, "joints").title
    assert "stopped" not in short(robot).about


def pendulum(lever: float = 0.0, inertia: float = 0.0) -> ClosedChain:
    """A point of 1 kg under a swing of two axes, 1 m below and `lever` [m] beside the upright one; [kg m2]."""
    bob = Inertial(1.0, com=[lever, 0.0, -1.0], inertia=inertia * np.eye(3))
    joints = (
        Joint("yaw", JointType.REVOLUTE, "base", "ring", axis=[0.0, 0.0, 1.0]),
        Joint("swing", JointType.REVOLUTE, "ring", "bob", axis=[0.0, 1.0, 0.0]),
    )
    links = (Link("base"), Link("ring"), Link("bob", bob))
    return ClosedChain(RobotDescription("swing", links, joints, actuators=("yaw", "swing"), tool=Frame("bob")))


def test_a_motion_that_has_mass_only_elsewhere_is_refused_before_a_run() -> None:
    """Turned about the line that it hangs on, a point does not move; swung out a little it does."""
    hanging = pendulum()
    assert undetermined_motions(hanging, hanging.home.q_full) == ("yaw",)
    with pytest.raises(DynamicsError, match="a motion of yaw moves no mass"):
        short(hanging)
    for sound in (pendulum(lever=0.1), pendulum(inertia=1e-3), load("stewart"), load("underactuated")):
        assert undetermined_motions(sound, sound.home.q_full) == ()


def test_negative_masses_are_refused_where_they_are_told() -> None:
    """Lenient readers pass moments that no body has; a motion that would gain energy by braking is no motion."""
    robot = pendulum(lever=0.1, inertia=-0.5)
    with pytest.raises(DynamicsError, match="kinetic energy of a motion is negative"):
        short(robot)
    with pytest.raises(DynamicsError, match="negative"):
        robot.forward_dynamics(robot.home, [0.0, 0.0], [1.0, 0.0])


def test_usual_gains_are_critically_damped_at_home() -> None:
    robot = load("fivebar")
    gains = usual_gains(robot)
    assert np.allclose(gains["kd"] ** 2, 4.0 * gains["kp"] * np.diag(robot.terms(robot.home).mass))
    assert (gains["ki"] < gains["kp"] * gains["kd"] / np.diag(robot.terms(robot.home).mass)).all()
