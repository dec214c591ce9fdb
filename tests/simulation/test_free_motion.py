"""Runs that follow nothing: free fall, efforts over time, actuators that brakes hold; over robots of random shapes."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.led_robots import LED, somewhere
from kit.quickly import few

import cutjoint
from cutjoint.control import PD, PID, EffortTable, Feedforward, GivenEfforts, NoControl, PDGravity
from cutjoint.errors import InputError, SimulationError, UnknownNameError
from cutjoint.motion import Hold, PointToPoint, Reference
from cutjoint.papers.cpm import CpmModel
from cutjoint.simulation import Adaptive, ConstrainedPlant, ReducedPlant, RungeKutta4, load, run, save

TIGHT = Adaptive(1e-11, 1e-14)
PLANTS = {"reduced": ReducedPlant, "constrained": ConstrainedPlant}
MODEL = CpmModel()


@pytest.fixture(scope="module", params=[name for name in LED if name != "delta"])
def robot(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """In a random shape, of any size, anywhere; without the delta, whose rods spin."""
    folder: Path = tmp_path_factory.mktemp(request.param)
    return somewhere(request.param, 1, folder, np.random.default_rng(5)).chain


def moment(robot: Any) -> float:
    """A time in which it moves noticeably but not far [s]: a fraction of a swing of its size."""
    return 0.1 * float(np.sqrt(robot.length / 9.81))


def pushed(robot: Any) -> Any:
    """A velocity with which it moves noticeably in that time, weight or not."""
    slides = np.array([one.kind == "translation" for one in robot.actuators])
    signs = np.random.default_rng(3).uniform(0.3, 1.0, robot.n)
    return 0.02 * signs * np.where(slides, robot.length, 1.0) / moment(robot)


def usual(robot: Any) -> float:
    """The size of its efforts."""
    terms = robot.terms(robot.home)
    return float(np.abs(terms.gravity).max() + np.abs(terms.mass @ pushed(robot)).max() / moment(robot))


@pytest.mark.parametrize("plant", PLANTS)
def test_free_fall_keeps_energy(robot: Any, plant: str) -> None:
    found = run(PLANTS[plant](robot), duration=moment(robot), integrator=TIGHT, start_velocity=pushed(robot))
    assert not found.followed
    assert not found.effort.any()
    assert not found.work.any()
    assert np.abs(found.q - found.q[0]).max() > 0.0
    assert found.kinetic[-1] > 0.0
    assert found.energy_drift() < 1e-7
    assert (
        np.abs(found.energy - found.energy[0]).max()
        < 1e-8 * np.abs(found.kinetic).max() + 1e-13 * np.abs(found.potential).max()
    )


def test_a_robot_whose_rods_spin_falls_in_full_coordinates(tmp_path: Path) -> None:
    chain = somewhere("delta", 1, tmp_path, np.random.default_rng(5)).chain
    found = run(ConstrainedPlant(chain), duration=moment(chain), integrator=TIGHT)
    assert found.energy_drift() < 1e-7


def test_both_plants_fall_alike(robot: Any) -> None:
    settings = {"duration": moment(robot), "integrator": TIGHT, "every": moment(robot) / 4}
    settings["start_velocity"] = pushed(robot)
    one, two = (run(make(robot), **settings) for make in PLANTS.values())
    assert np.abs(one.tool - two.tool).max() < 1e-9 * robot.length
    assert np.abs(one.q - two.q).max() < 1e-9 * max(np.abs(one.q - one.q[0]).max(), 1e-3 * np.abs(one.q).max())


@pytest.mark.parametrize("plant", few(PLANTS, next(iter(PLANTS))))
def test_efforts_of_inverse_dynamics_give_the_motion_that_they_are_of(robot: Any, plant: str) -> None:
    """Efforts over time that were computed for a motion give that motion: an end to end check of the work too."""
    span = moment(robot)
    amplitude = 0.5 * span * pushed(robot)

    def efforts(t: float) -> Any:
        s = np.pi * t / span
        at = robot.close(robot.home.q + amplitude * (1.0 - np.cos(s)), limits="ignore")
        rate = np.pi / span
        return robot.inverse_dynamics(at, amplitude * rate * np.sin(s), amplitude * rate**2 * np.cos(s))

    found = run(PLANTS[plant](robot), efforts, duration=span, integrator=TIGHT, every=span / 3)
    wanted = robot.home.q + amplitude * (1.0 - np.cos(np.pi * found.time / span))[:, None]
    assert np.abs((found.q - wanted) / amplitude).max() < 1e-6
    assert found.energy_drift() < 1e-7
    assert found.about["law"] == "given efforts"


@pytest.mark.parametrize("plant", PLANTS)
def test_a_brake_holds_exactly_and_what_it_gives_is_inverse_dynamics(robot: Any, plant: str) -> None:
    """The rest moves as it would with the locked coordinates at rest: by the equation of motion's own rows."""
    locked = robot.actuators[0].name
    push = pushed(robot)
    push[0] = 0.0
    found = run(PLANTS[plant](robot), duration=moment(robot), integrator=TIGHT, lock=[locked], start_velocity=push)
    assert (found.q[:, 0] == found.q[0, 0]).all()
    assert not found.v[:, 0].any()
    assert not found.effort[:, 1:].any()
    assert found.about["locked"] == [locked]
    assert found.energy_drift() < 1e-7
    near = robot.home
    for i in (0, len(found) // 2, len(found) - 1):
        near = robot.close(found.q[i], near, limits="ignore")
        terms = robot.terms(near, found.v[i])
        rest = terms.coriolis + terms.gravity
        a = np.linalg.solve(terms.mass[1:, 1:], -rest[1:]) if robot.n > 1 else np.zeros(0)
        holds = terms.mass[0, 1:] @ a + rest[0]
        assert found.effort[i, 0] == pytest.approx(holds, rel=1e-6, abs=1e-6 * usual(robot))


@pytest.mark.parametrize("plant", PLANTS)
def test_with_all_brakes_on_nothing_moves_and_they_carry_the_weight(robot: Any, plant: str) -> None:
    found = run(PLANTS[plant](robot), duration=moment(robot), lock=[one.name for one in robot.actuators])
    assert (found.q == found.q[0]).all()
    assert found.energy_drift() == 0.0
    gravity = robot.terms(robot.home).gravity
    assert np.abs(found.effort - gravity).max() < 1e-9 * usual(robot)


def test_a_sampled_law_is_held_and_a_brake_is_not() -> None:
    """Between two samples the law's effort stands still; what a brake must give does not."""
    found = run(
        ReducedPlant(MODEL),
        PDGravity(MODEL, 100.0, 10.0),
        Reference(Hold([0.5, 0.4, 0.3], 0.3), MODEL),
        start=MODEL.reach([0.52, 0.4, 0.3]),
        integrator=RungeKutta4(1e-3),
        rate=20.0,
        duration=0.15,
        lock=["limb1_slide"],
    )
    period = np.floor(found.time * 20.0 + 1e-9)
    assert (found.q[:, 0] == found.q[0, 0]).all()
    for k in range(3):
        block = found.effort[period == k]
        assert (block[:, 1:] == block[0, 1:]).all()
        assert np.ptp(block[:, 0]) > 0.0


@pytest.mark.parametrize("name", ["redundant", "underactuated"])
def test_robots_whose_actuators_do_not_tell_their_motion_fall_too(name: str) -> None:
    chain = cutjoint.load(name)
    plant = ConstrainedPlant(chain)
    found = run(plant, lambda t: np.full(chain.n, 3.0 * np.sin(20.0 * t)), duration=0.1, integrator=TIGHT)
    assert np.abs(found.q_full - found.q_full[0]).max() > 1e-4
    assert found.energy_drift() < 1e-8
    held = run(plant, duration=0.1, lock=[chain.actuators[0].name])
    assert (held.q[:, 0] == held.q[0, 0]).all()


@pytest.mark.parametrize(
    "law", [PD(1.0, 1.0), PID(1.0, 1.0, 1.0), PDGravity(MODEL, 1.0, 1.0), Feedforward(MODEL, 1.0, 1.0)]
)
def test_a_law_that_needs_something_to_follow_says_so_before_anything_moves(law: Any) -> None:
    told: list[float] = []
    with pytest.raises(InputError, match=rf"'{law.name.replace('+', '.')}' asks for '\w+' of the desired motion"):
        run(ReducedPlant(MODEL), law, duration=0.1, progress=told.append)
    assert told == []


def test_a_law_that_needs_no_reference_is_a_function() -> None:
    """Damping alone takes energy; the function gets the time too."""
    times: list[float] = []

    def damper(t: float, desired: Any, q: Any, v: Any) -> Any:
        times.append(t)
        assert desired.t == t
        return -20.0 * v

    found = run(ReducedPlant(MODEL), damper, duration=0.1)
    assert found.about["law"] == "damper"
    assert found.work[-1] < 0.0
    assert found.energy_drift() < 1e-8
    assert max(times) == pytest.approx(0.1)


def test_a_function_follows_like_a_law() -> None:
    reference = Reference(Hold([0.5, 0.4, 0.3], 0.1), MODEL)
    settings = {"start": MODEL.reach([0.51, 0.4, 0.3]), "integrator": RungeKutta4(1e-3)}
    one = run(ReducedPlant(MODEL), PD(900.0, 60.0), reference, **settings)
    two = run(ReducedPlant(MODEL), lambda t, d, q, v: 900.0 * (d.q - q) + 60.0 * (d.v - v), reference, **settings)
    assert np.array_equal(one.q, two.q)


@pytest.mark.slow
def test_a_wall_that_is_crept_up_to_ends_the_run() -> None:
    """A limb of the five-bar comes to be stretched, where actuated coordinates end: steps shrink and never reach it."""
    plant = ReducedPlant(cutjoint.load("fivebar"))
    with pytest.raises(SimulationError, match=r"get nowhere; .* at a stretched limb full coordinates go on") as caught:
        run(plant, duration=0.3, integrator=Adaptive(1e-6, 1e-8), every=0.01)
    assert 0.1 < caught.value.t < 0.2
    through = run(ConstrainedPlant(plant.mechanism), duration=0.3, integrator=Adaptive(1e-8, 1e-10), every=0.01)
    assert through.time[-1] == 0.3


# ---- what a result without desired motion is


def test_a_result_without_a_desired_motion_has_no_such_columns(tmp_path: Path) -> None:
    found = run(ReducedPlant(MODEL), duration=0.05, every=0.01)
    assert [name for name in found.columns if "desired" in name or "error" in name] == []
    for ask in (found.rmse, found.worst_error, found.rmse_over_time, found.worst_turn, lambda: found.error):
        with pytest.raises(InputError, match="followed nothing"):
            ask()
    with pytest.raises(AttributeError, match="no column 'desired_tool'; it has time, q"):
        _ = found.desired_tool
    assert "free motion" in repr(found)
    assert "trajectory" not in found.about
    again = load(save(found, tmp_path / "run.npz"))
    assert list(again.columns) == list(found.columns)
    assert not again.followed
    assert not pickle.loads(pickle.dumps(found)).followed
    heading = save(found, tmp_path / "run.csv").read_text().splitlines()[0]
    assert "desired" not in heading


@pytest.mark.parametrize(
    ("settings", "error", "about"),
    [
        ({}, InputError, "nothing that says how long"),
        ({"duration": 0.1, "lock": ["limb9"]}, UnknownNameError, "unknown actuator 'limb9'"),
        ({"duration": 0.1, "lock": ["limb1_slide"] * 2}, InputError, "locked twice"),
        ({"duration": 0.1, "lock": ["limb1_slide"], "start_velocity": [1.0, 0, 0]}, InputError, "are at rest"),
        ({"duration": 0.1, "law": lambda t: [1.0, 2.0]}, InputError, r"efforts of shape \(2,\)"),
        ({"duration": 0.1, "law": lambda t: "strong"}, InputError, "must return efforts"),
        ({"duration": 0.1, "law": lambda t: [1.0, np.nan, 0.0]}, InputError, "not finite"),
        ({"duration": 0.1, "law": lambda t, d, q, v: 1 / 0}, InputError, r"raised ZeroDivisionError: .*test_free"),
        ({"duration": 0.1, "law": lambda a, b: a}, InputError, r"\(a, b\) is no control law"),
        ({"duration": 0.1, "law": PD}, InputError, "PD is a class"),
        ({"duration": 0.1, "law": 7}, InputError, "law of run must be a Law, a function or None, found the number 7"),
        ({"reference": Reference(Hold([0.5, 0.4, 0.3]), MODEL)}, InputError, "needs a law that follows"),
    ],
)
def test_bad_arguments_are_told_before_anything_moves(settings: Any, error: type[Exception], about: str) -> None:
    told: list[float] = []
    with pytest.raises(error, match=about):
        run(ReducedPlant(MODEL), progress=told.append, **settings)
    assert told == []


# ---- tables of efforts


def test_a_table_is_linear_between_its_samples() -> None:
    rng = np.random.default_rng(2)
    time = np.concatenate([[0.0], np.sort(rng.uniform(0.0, 1.0, 9))])
    values = rng.normal(size=(10, 3))
    table = EffortTable(time, values)
    for t in (*rng.uniform(0.0, time[-1], 50), *time):
        assert np.allclose(table(t), [np.interp(t, time, column) for column in values.T], rtol=0.0, atol=1e-12)
    with pytest.raises(InputError, match="given until"):
        table(1.5)


def test_the_table_says_how_long_the_run_is_and_no_more() -> None:
    law = GivenEfforts(EffortTable([0.0, 0.02, 0.05], np.zeros((3, 3))))
    plant = ReducedPlant(MODEL)
    found = run(plant, law)
    assert found.time[-1] == 0.05
    assert np.allclose(found.q[-1], run(plant, NoControl(), duration=0.05).q[-1], rtol=0.0, atol=1e-12)
    with pytest.raises(InputError, match="before the end of the run"):
        run(plant, law, duration=0.06)
    with pytest.raises(InputError, match="for 2 actuators, the robot has 3"):
        run(plant, GivenEfforts(EffortTable([0.0, 1.0], np.zeros((2, 2)))))


@pytest.mark.parametrize(
    ("time", "efforts", "about"),
    [
        ([0.0], [[1.0]], "at least two"),
        ([0.0, 1.0], [1.0, 2.0], "shapes"),
        ([0.0, 1.0], [[1.0], [np.inf]], "finite"),
        ([0.0, 1.0, 1.0], [[1.0]] * 3, "must increase: sample 3"),
        ([0.1, 1.0], [[1.0]] * 2, "begins at 0"),
        ([-1.0, 0.0], [[1.0]] * 2, "begins at 0"),
    ],
)
def test_tables_that_are_none_are_refused(time: Any, efforts: Any, about: str) -> None:
    with pytest.raises(InputError, match=about):
        EffortTable(time, efforts)


def test_a_law_that_jumps_is_told_to_be_sampled() -> None:
    """Bang-bang control slides along the switching surface: no step of an adaptive method gets across it."""
    robot = cutjoint.load("fivebar")
    home = robot.task.home.position
    reference = Reference(PointToPoint(home, home + [0.01, 0.0, 0.01], 1.0), robot)  # noqa: RUF005
    jumping = {"law": lambda t, desired, q, v: 5.0 * np.sign(desired.q - q), "reference": reference, "duration": 0.02}
    with pytest.raises(SimulationError, match=r"needs a sample rate \(rate="):
        run(ConstrainedPlant(robot), **jumping)
    assert run(ConstrainedPlant(robot), rate=1000.0, **jumping).time[-1] == 0.02
