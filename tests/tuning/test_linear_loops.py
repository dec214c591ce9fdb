"""Linear loops against closed forms and against the loop as it is simulated."""

import math
from dataclasses import replace

import numpy as np
import pytest

import cutjoint
from cutjoint.compile import ClosedLoop, compiled
from cutjoint.control import law
from cutjoint.control.usual_gains import usual_gains
from cutjoint.errors import InputError
from cutjoint.motion import Reference, about_home
from cutjoint.simulation.hardware import Clock, Differences, Drive, Encoder, Hardware
from cutjoint.tuning import LinearLaw, LinearLoop, LinearPlant, Timing, at_rest, linear_law, linear_plant, margins_of
from cutjoint.tuning.case import TuningCase
from cutjoint.tuning.linear import JointRest
from cutjoint.tuning.steps import response_of

pytest.importorskip("control")


CONTINUOUS = Timing()


def mass_on_pd(mass: float, kp: float, kd: float, timing: Timing = CONTINUOUS) -> LinearLoop:
    none = np.zeros((1, 1))
    plant = LinearPlant(np.zeros(1), np.zeros(1), np.array([[mass]]), none, none, np.array([[1.0 / mass]]))
    empty = np.zeros((0, 1))
    pd = LinearLaw(np.array([[-kp]]), np.array([[-kd]]), empty.T, empty, empty, np.zeros((0, 0)))
    return LinearLoop(plant, pd, timing)


@pytest.mark.parametrize("seed", range(3))
def test_a_mass_on_pd_has_the_margins_of_the_closed_form(seed):
    """L = (kd s + kp) / (m s^2): |L| = 1 at w^2 = (a^2 + sqrt(a^4 + 4 b^2)) / 2, a = kd/m, b = kp/m; the phase there is
    -180 deg + atan(kd w / kp)."""
    rng = np.random.default_rng(seed)
    mass, w, z = np.exp(rng.uniform(-12, 12)), np.exp(rng.uniform(-3, 5)), rng.uniform(0.2, 1.5)
    kp, kd = mass * w * w, 2.0 * z * w * mass
    found = margins_of(mass_on_pd(mass, kp, kd), ("a",))
    a, b = kd / mass, kp / mass
    crossover = math.sqrt(0.5 * (a * a + math.sqrt(a**4 + 4.0 * b * b)))
    phase = math.atan2(kd * crossover, kp)
    (one,) = found.actuators
    assert one.crossover == pytest.approx(crossover, rel=1e-4)
    assert one.phase == pytest.approx(math.degrees(phase), rel=1e-4)
    assert one.gain == math.inf
    for delay in (one.delay, found.delay):
        assert delay == pytest.approx(phase / crossover, rel=1e-3)
    assert found.damping == pytest.approx(min(z, 1.0), rel=1e-6)
    slow = z * w if z <= 1.0 else w * (z - math.sqrt(z * z - 1.0))
    assert found.decay == pytest.approx(slow, rel=1e-6)


def test_a_sampled_mass_on_pd_bears_the_gain_of_the_closed_form():
    """With kp = 0 the held effort moves the speed by -kd T / m a sample, so kd T / m < 2."""
    mass, kd, period = 3.0, 40.0, 1e-3
    loop = mass_on_pd(mass, 1e-6, kd, Timing(period))
    assert margins_of(loop, ("a",)).actuators[0].gain == pytest.approx(2.0 * mass / (kd * period), rel=1e-3)
    assert mass_on_pd(mass, 1e-6, 1.99 * mass / period, Timing(period)).stable
    assert not mass_on_pd(mass, 1e-6, 2.01 * mass / period, Timing(period)).stable


@pytest.mark.slow
def test_many_periods_of_delay_are_as_continuous_delay():
    """A loop sampled very often loses what the delay takes of its delay margin."""
    free = margins_of(mass_on_pd(2.0, 800.0, 40.0), ("a",)).delay
    for delay in (0.0, 0.0123):
        late = margins_of(mass_on_pd(2.0, 800.0, 40.0, Timing(1e-3, delay)), ("a",)).delay
        assert late == pytest.approx(free - delay - 0.5e-3, abs=2e-5)  # a held effort is half a period late
    with pytest.raises(InputError, match="needs a loop that is sampled"):
        mass_on_pd(2.0, 800.0, 40.0, Timing(0.0, 1e-3))


@pytest.mark.parametrize("zeta", [0.2, 0.5, 0.8])
def test_the_figures_of_a_step_are_those_of_the_closed_form(zeta):
    w, time = 7.0, np.linspace(0.0, 12.0, 60001)
    beat = w * math.sqrt(1.0 - zeta * zeta)
    response = 1.0 - np.exp(-zeta * w * time) * (np.cos(beat * time) + zeta * w / beat * np.sin(beat * time))
    found = response_of("a", 1.0, time, response, 0.0)
    assert found.overshoot == pytest.approx(math.exp(-math.pi * zeta * w / beat), rel=1e-5)
    inside = np.abs(response - 1.0) <= 0.02
    assert inside[time >= found.settling].all()
    assert not inside[time >= found.settling - 1e-3].all()
    rises = [time[int(np.argmax(response >= level))] for level in (0.1, 0.9)]
    assert found.rise == pytest.approx(rises[1] - rises[0], abs=3e-4)


def test_a_response_that_never_comes_there_has_no_rise():
    time = np.linspace(0.0, 1.0, 101)
    assert math.isnan(response_of("a", 1.0, time, 0.5 * time, 0.0).rise)
    assert math.isnan(response_of("a", 1.0, time, time, 0.0).settling)


@pytest.fixture(scope="module")
def fivebar():
    return compiled(cutjoint.load("fivebar"), quick=True)


def test_the_plant_and_the_law_are_the_slopes_of_the_robot_and_the_law(fivebar):
    at = fivebar.close(fivebar.home.q + np.array([0.1, -0.2]))
    plant, still, h = linear_plant(fivebar, at), np.zeros(2), 1e-5
    rests = plant.by_effort @ plant.effort  # the same effort everywhere
    assert np.allclose(plant.by_effort @ plant.mass, np.eye(2))
    for k, step in enumerate(h * np.eye(2)):
        there = [fivebar.forward_dynamics(fivebar.close(at.q + s * step), still, plant.effort) for s in (1, -1)]
        assert np.allclose((there[0] - there[1]) / (2 * h), plant.by_q[:, k], atol=1e-4 * np.abs(rests).max())
    made = law("computed-torque", fivebar, {"kp": 300.0, "kd": 20.0})
    about = linear_law(made, at_rest(fivebar, at.q))
    assert np.allclose(about.by_v, -20.0 * plant.mass, rtol=1e-6, atol=1e-9)
    # the law cancels the slope of the plant, so the loop is that of its gains
    poles = LinearLoop(plant, about).poles
    assert np.allclose(sorted(poles.real), -10.0, atol=1e-4)
    assert np.allclose(np.abs(poles) ** 2, 300.0, rtol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "speed", "delay"),
    [("pd-gravity", None, 0.0), ("pid", None, 1.4e-3), ("pd-gravity", 150.0, 1e-3), ("computed-torque", None, 0.0)],
)
def test_the_delay_margin_is_where_the_simulated_loop_begins_to_grow(name, speed, delay):
    """Just below it what is off dies out, just above it grows: rate, delay, differences and memory are in the loop."""
    model = cutjoint.published("omega3")
    robot, period, tick = compiled(model), 2e-3, 2e-4
    gains = {"kp": 900.0, "kd": 60.0}
    if name != "computed-torque":
        usual = usual_gains(model)
        gains = {one: 3.0 * usual[one] for one in ("kp", "kd")}
        if name == "pid":
            gains["ki"] = usual["ki"]
    hardware = Hardware(Clock(1.0 / period, tick=tick), Encoder(delay=delay), drive=Drive())
    if speed is not None:
        hardware = replace(hardware, speed=Differences(speed))
    reference = Reference(JointRest(model.home.q, 1.8), model)
    case = TuningCase(model, name, reference, hardware=hardware)
    loop = case.linear(gains)[0]
    margin = margins_of(loop, tuple("abc")).delay
    assert tick < margin < 1.0
    growth = []
    for more in (0.9 * margin, 1.1 * margin):
        late = replace(hardware, drive=Drive(delay=round(more / tick) * tick))
        many = ClosedLoop(robot, law(name, model, gains), model, hardware=late).run(
            reference,
            step=tick,
            every=period,
            start=np.vstack([model.home.q, model.home.q + np.array([1e-6, 0.0, -1e-6])]),
        )
        off = np.abs(many.q[1] - many.q[0]).max(axis=1)
        third = len(off) // 3
        growth.append(off[-third:].max() / off[third : 2 * third].max())
    assert growth[0] < 1.0 < growth[1], (margin, growth)


@pytest.mark.slow
def test_poles_of_the_sampled_loop_are_how_the_simulated_one_decays(fivebar):
    """One period of the simulated loop is the matrix of the linear one, to first order."""
    reference = Reference(about_home(fivebar), fivebar)
    hardware = Hardware(Clock(500.0, tick=5e-4), Encoder(delay=1.5e-3), Differences(100.0), Drive(delay=1e-3))
    case = TuningCase(fivebar, "pd", reference, hardware=hardware)
    gains = {"kp": 12.0, "kd": 1.2}
    loop = case.linear(gains)[0]
    rest = Reference(JointRest(reference.at(0.0).q, 1.0), fivebar)
    start = np.vstack([rest.at(0.0).q, rest.at(0.0).q + np.array([1e-6, 0.0])])
    many = ClosedLoop(fivebar, law("pd", fivebar, gains), fivebar, hardware=hardware).run(
        rest, step=5e-4, every=2e-3, start=start
    )
    off = np.log(np.abs(many.q[1] - many.q[0]).max(axis=1))
    # envelope: the slowest pole alone is left in the second half
    k = len(off) // 2
    slope = np.polyfit(many.time[k:], off[k:], 1)[0]
    assert -slope == pytest.approx(loop.decay, rel=0.25)
