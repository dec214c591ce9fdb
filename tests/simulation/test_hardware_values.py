"""Hardware as values: bad input, files, chance that repeats, and what a result says of it."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from kit.blocks import Rails, blocks
from kit.quickly import few

from cutjoint.control import PID
from cutjoint.description.model import JointPhysics
from cutjoint.errors import DescriptionError, InputError, SimulationError
from cutjoint.motion import Hold, Reference
from cutjoint.papers.cpm import CpmModel
from cutjoint.robots import published
from cutjoint.simulation import ReducedPlant, RungeKutta4, State, load, run, save
from cutjoint.simulation.hardware import (
    Backlash,
    Clock,
    Differences,
    Drive,
    Encoder,
    Hardware,
    Tachometer,
    TorqueSpeed,
    hardware_of,
    parts_of,
    read_hardware,
)
from cutjoint.simulation.hardware.checks import check_robot, check_span
from cutjoint.simulation.hardware.noise import Jitter, Noise

GEAR = Backlash(1e-3, 1e4, 1.0, 0.1)
WHOLE = Hardware(
    Clock(1000.0, 1e-4, 5e-5),
    Encoder((1e-4, 2e-4), 0.1, 1e-5, 3e-4, "motor"),
    Differences(80.0),
    Drive((5.0, 6.0), 0.1, 1e-3, TorqueSpeed(10.0, (1.0, 2.0)), GEAR),
    seed=7,
)
NOISY = Hardware(Clock(500.0), Encoder(noise=(1e-3, 2e-3)), Tachometer((0.1, 0.3)), seed=3)


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: Clock(0.0), "rate of the clock must be finite and > 0"),
        (lambda: Clock(1000.0, -1e-5), "jitter of the clock must be one finite number >= 0"),
        (lambda: Clock(1000.0, 5e-4), "half the period"),
        (lambda: Clock(1000.0, tick=0.0), "tick of the clock"),
        (lambda: Encoder(0.0), "resolution of the encoder must be one number > 0.*leave it out"),
        (lambda: Encoder([1e-4, -1e-4]), "resolution of the encoder"),
        (lambda: Encoder(noise=-1e-4), "noise of the encoder must be one number >= 0"),
        (lambda: Encoder(noise=np.nan), "noise of the encoder"),
        (lambda: Encoder(offset="a"), "offset of Encoder"),
        (lambda: Encoder(delay=-1.0), "delay of the encoder"),
        (lambda: Encoder(delay=[1e-3, 2e-3]), "delay of Encoder must be a number"),
        (lambda: Encoder(at="tool"), "at of Encoder must be .joint. or .motor."),
        (lambda: Differences(0.0), "cutoff of the filter"),
        (lambda: Tachometer(-1.0), "noise of the tachometer"),
        (lambda: Drive(limits=-5.0), "limits must be one number > 0"),
        (lambda: Drive(limits=[5.0, 0.0]), "limits must be one number > 0"),
        (lambda: Drive(resolution=0), "resolution of the drive"),
        (lambda: Drive(delay=np.inf), "delay of the drive"),
        (lambda: TorqueSpeed(1.0, 0.0), "no-load speed"),
        (lambda: TorqueSpeed(-1.0, 1.0), "stall effort"),
        (lambda: Backlash(-1e-3, 1.0, 1.0, 1.0), "width of the backlash"),
        (lambda: Backlash(1e-3, 0.0, 1.0, 1.0), "stiffness of the backlash"),
        (lambda: Backlash(1e-3, 1.0, -1.0, 1.0), "damping of the backlash"),
        (lambda: Backlash(1e-3, 1.0, 1.0, 0.0), "rotor of the backlash"),
        (lambda: Hardware(Clock(1000.0), seed=-1), "a seed is a whole number"),
        (lambda: Hardware(Clock(1000.0), seed=1.5), "a seed is a whole number"),
        (lambda: Hardware(Clock(1000.0, 1e-4)), "the jitter.*as no tick is given.*such as 0.0001 s"),
        (lambda: Hardware(Clock(1000.0), Encoder(delay=1.5e-3)), "delay of the encoder.*such as 0.0005 s"),
        (lambda: Hardware(Clock(1000.0, tick=3e-4)), "the period of 0.001 s is not a whole number of ticks"),
        (lambda: Hardware(Clock(1000.0, 2e-4, 1e-4), Encoder(delay=6e-4)), "less than 10 - 2 x 2 ticks"),
        (lambda: Hardware(Clock(1000.0, 2e-4, 1e-4), drive=Drive(delay=2.7e-3)), "delay of the drive is 7 of 10"),
    ],
)
def test_bad_values_are_one_clear_error(make, told):
    with pytest.raises(InputError, match=told):
        make()


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"hardware": Hardware(Clock(10.0), Encoder(delay=1.0))}, "delay of the encoder of 1 s is not shorter"),
        ({"hardware": Hardware(Clock(10.0), drive=Drive(delay=2.0))}, "delay of the drive of 2 s is not shorter"),
        ({"hardware": Hardware(Clock(10.0)), "rate": 10.0}, "leave them out beside it"),
        ({"hardware": Hardware(Clock(10.0)), "limits": 10.0}, "leave them out beside it"),
        ({"run_number": 3}, "give hardware too"),
        ({"hardware": NOISY, "run_number": -1}, "number of a run"),
        ({"hardware": Hardware(Clock(10.0), Encoder([1.0, 2.0, 3.0]))}, "must be one number or 2 of them.*found 3"),
        ({"hardware": Hardware(Clock(10.0), drive=Drive(backlash=GEAR)), "lock": ["rail0"]}, "brakes on rail0"),
    ],
)
def test_a_run_that_hardware_does_not_go_with_says_so(settings, told):
    with pytest.raises(InputError, match=told):
        run(Rails([1.0, 2.0]), duration=1.0, **settings)


def test_a_rotor_is_not_there_twice():
    robot = blocks([1.0, 2.0], JointPhysics(rotor=0.1, gear=2.0))
    with pytest.raises(InputError, match="'rail0' has a rotor already"):
        run(ReducedPlant(robot), duration=1.0, hardware=Hardware(Clock(10.0), drive=Drive(backlash=GEAR)))


def test_values_survive_pickling_and_tables():
    for one in (WHOLE, NOISY, Hardware(Clock(3.0))):
        assert pickle.loads(pickle.dumps(one)) == one
        assert hardware_of(parts_of(one)) == one


def test_a_result_says_what_hardware_it_was_made_with(tmp_path):
    found = run(Rails([1.0, 2.0]), hardware=WHOLE, run_number=4, duration=0.02, integrator=RungeKutta4(1e-4))
    again = load(save(found, tmp_path / "run.npz"))
    assert hardware_of(again.about["hardware"]) == WHOLE
    assert (again.about["run_number"], again.about["rate"], again.about["limits"]) == (4, 1000.0, [5.0, 6.0])
    assert {"measured_q", "measured_v", "asked", "command", "rotor_q", "rotor_v"} <= set(again.columns)
    for name, column in found.columns.items():
        assert np.array_equal(column, again.columns[name])
    head = save(found, tmp_path / "run.csv").read_text(encoding="utf-8").splitlines()[0]
    assert "rail0 measured [m]" in head
    assert "rail1 rotor [m]" in head


TEXT = """
seed = 7
[clock]
rate = 1000
jitter = 1e-4
tick = 5e-5
[encoder]
resolution = [1e-4, 2e-4]
offset = 0.1
noise = 1e-5
delay = 3e-4
at = "motor"
[differences]
cutoff = 80
[drive]
limits = [5, 6]
resolution = 0.1
delay = 1e-3
torque_speed = { stall = 10, no_load_speed = [1, 2] }
backlash = { width = 1e-3, stiffness = 1e4, damping = 1, rotor = 0.1 }
"""


def test_a_file_holds_all_of_it(tmp_path: Path) -> None:
    (tmp_path / "hardware.toml").write_text(TEXT, encoding="utf-8")
    assert read_hardware(tmp_path / "hardware.toml") == WHOLE


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("rate = 1000", "", "without 'rate'"),
        ("rate = 1000", "rate = true", ":4: rate of .clock. is True"),
        ("rate = 1000", "rate = -3", ":4: rate of the clock must be finite and > 0"),
        ("jitter", "jiter", ":5: unknown key 'jiter'.*did you mean 'jitter'"),
        ("[differences]", "[difference]", "unknown key 'difference'"),
        ("resolution = [1e-4, 2e-4]", "resolution = 0", ":8: resolution of the encoder"),
        ("delay = 3e-4", "delay = 3.3e-4", "delay of the encoder of 0.00033 s is not a whole number of ticks"),
        ('"motor"', '"tool"', ":12: at of Encoder must be .joint. or .motor."),
        ("cutoff = 80", 'cutoff = "80"', "cutoff of .differences. is '80'"),
        ("stall = 10,", "", ":19: .drive.torque_speed. without 'stall'"),
        ("seed = 7", "seed = 1.5", ":2: a seed is a whole number"),
        ("seed = 7", "seed = ", "TOML"),
        ("[clock]", "[tachometer]\nnoise = 0.1\n[clock]", "speeds are told twice"),
        (TEXT, "seed = 1", "no .clock."),
    ],
)
def test_what_is_wrong_in_a_file_is_told_with_its_line(tmp_path: Path, old: str, new: str, told: str) -> None:
    (tmp_path / "hardware.toml").write_text(TEXT.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(DescriptionError, match=told):
        read_hardware(tmp_path / "hardware.toml")
    with pytest.raises(DescriptionError, match="file not found"):
        read_hardware(tmp_path / "absent.toml")


@pytest.mark.parametrize("most", few(range(1, 12), 1, 5))
def test_jitter_is_even_within_its_bounds(most: int) -> None:
    late = Jitter(5, 0, most).ticks(40000)
    assert late[0] == 0
    counts = np.bincount(late[1:] + most, minlength=2 * most + 1)
    assert counts.size == 2 * most + 1
    expected = 39999.0 / (2 * most + 1)
    squares = float(((counts - expected) ** 2).sum() / expected)
    assert squares < 2 * most + 8.0 * np.sqrt(2 * most)  # chi squared: mean 2 most, deviation sqrt(4 most)
    assert abs(np.corrcoef(late[1:-1], late[2:])[0, 1]) < 0.03


@pytest.mark.parametrize("blocks_of", [1, 7, 256])
def test_how_many_numbers_are_drawn_at_a_time_changes_nothing(blocks_of: int) -> None:
    whole, wholes = Noise(3, 2, 5).rows(700), Jitter(3, 2, 4).ticks(700)
    noise, jitter = Noise(3, 2, 5), Jitter(3, 2, 4)
    assert np.array_equal(whole[:700], np.concatenate([noise.rows(blocks_of) for _ in range(700)])[:700])
    assert np.array_equal(wholes, np.concatenate([jitter.ticks(blocks_of) for _ in range(700)])[:700])


def test_noise_is_of_its_own_for_run_channel_and_size_and_the_same_again():
    settings = {"duration": 3.0, "integrator": RungeKutta4(2e-3)}
    first, again, other = (run(Rails([1.0, 2.0]), hardware=NOISY, run_number=k, **settings) for k in (5, 5, 6))
    assert np.array_equal(first.measured_q, again.measured_q)
    noise = np.hstack([first.measured_q - first.q, first.measured_v - first.v])
    assert np.allclose(noise.std(axis=0), [1e-3, 2e-3, 0.1, 0.3], rtol=0.06)
    assert (np.abs(noise.mean(axis=0)) < 4.0 * noise.std(axis=0) / np.sqrt(len(noise))).all()
    mixed = np.corrcoef(np.hstack([noise, other.measured_q - other.q, other.measured_v - other.v]).T)
    assert np.abs(mixed - np.eye(8)).max() < 0.1
    drawn = Noise(3, 5, 4).rows(len(first)) * [1e-3, 2e-3, 0.1, 0.3]
    assert np.allclose(noise, drawn, atol=1e-13)


@pytest.mark.parametrize("step", [None, 0.5, 5.0])
def test_steps_of_the_command_do_not_stop_an_integral(step):
    """A law is told of limits; that a command was rounded is no saturation."""
    model = CpmModel()
    hold = Reference(Hold([0.6, 0.425, 0.3], 0.3), model)
    ki = 6000.0
    hardware = Hardware(Clock(500.0), Encoder(delay=2e-3), drive=Drive(resolution=step))
    found = run(ReducedPlant(model), PID(2000, ki, 200), hold, hardware=hardware, integrator=RungeKutta4(2e-3))
    error = found.desired_q - found.measured_q
    fed = 2000 * error + 200 * (found.desired_v - found.measured_v)
    assert np.allclose(found.asked - fed, ki * 2e-3 * (np.cumsum(error, axis=0) - error), atol=1e-6)


@pytest.mark.parametrize("stiffness", [0.0, 1e4])
def test_a_joint_with_stops_goes_on_at_its_limit(stiffness: float) -> None:
    robot = ReducedPlant(blocks([2.0], JointPhysics(stop_stiffness=stiffness, stop_damping=10.0), way=0.1))
    settings = {
        "start": robot.mechanism.close([0.05]),
        "start_velocity": [1.0],
        "duration": 0.2,
        "integrator": RungeKutta4(1e-3),
    }
    if not stiffness:
        with pytest.raises(SimulationError, match="'rail0' passes its upper limit"):
            run(robot, **settings)
        return
    found = run(robot, **settings)
    deep = np.sqrt(2.0 / stiffness)
    assert 0.1 + 0.5 * deep < found.q.max() < 0.1 + deep
    assert found.v[-1, 0] < -0.5


def test_a_state_that_starts_in_motion_is_seen_from_the_first_sample_on():
    moving = State(np.zeros(2), np.array([1.0, -2.0]))
    found = run(Rails([1.0, 2.0]), hardware=Hardware(Clock(100.0), Encoder(delay=0.03)), duration=0.1, start=moving)
    at = np.rint(found.time * 100.0).astype(int)
    assert np.allclose(found.measured_q, 0.01 * np.maximum(at - 3, 0)[:, None] * moving.v)
    assert np.allclose(found.measured_v, moving.v)


def test_parts_of_other_kinds_are_refused() -> None:
    """Every part of hardware says what it must be; so do steps and samples without number."""
    clock = Clock(1000.0)
    for given in ({"clock": 1000.0}, {"encoder": 3}, {"speed": None}, {"drive": "x"}):
        with pytest.raises(InputError, match=f"{next(iter(given))} of hardware must be of"):
            Hardware(**{"clock": clock, **given})  # type: ignore[arg-type]
    for given in ({"torque_speed": 3}, {"backlash": 3}):
        with pytest.raises(InputError, match=f"{next(iter(given))} of Drive must be a"):
            Drive(**given)  # type: ignore[arg-type]
    for made in (Encoder, Drive):
        with pytest.raises(InputError, match="must be one number > 0"):
            made(resolution=1e-310)
    with pytest.raises(InputError, match="up to 1e\\+09 can be run"):
        check_span(Hardware(Clock(1e90)), 1.0)


def test_the_rotor_of_a_published_model_is_not_there_twice() -> None:
    play = Hardware(Clock(1000.0), drive=Drive(backlash=Backlash(1e-4, 1e4, 10.0, 1.0)))
    model = published("cpm")
    check_robot(play, model, ())
    with pytest.raises(InputError, match="has a rotor already"):
        check_robot(play, model.with_motors(JointPhysics(rotor=2.0)), ())  # type: ignore[attr-defined]
