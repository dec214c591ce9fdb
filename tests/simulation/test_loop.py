"""The loop: sampled and continuous control, saturation, samples, and runs that cannot go on."""

import numpy as np
import pytest
from kit.quickly import few

from cutjoint.control import PD, PID, ComputedTorque, NoControl, PDGravity
from cutjoint.errors import InputError, SimulationError
from cutjoint.motion import Hold, PointToPoint, Reference
from cutjoint.papers.cpm import CpmModel
from cutjoint.simulation import Adaptive, ConstrainedPlant, DormandPrince, ReducedPlant, Result, RungeKutta4, run
from cutjoint.simulation.integrators import Step

MODEL = CpmModel()
PLANT = ReducedPlant(MODEL)
START, GOAL = [0.6, 0.425, 0.3], [0.5, 0.45, 0.35]
WAY = Reference(PointToPoint(START, GOAL, 0.4), MODEL)
METHODS = [RungeKutta4(2e-3), Adaptive(), DormandPrince()]


@pytest.mark.parametrize("method", METHODS)
def test_all_methods_agree(method):
    law = PDGravity(MODEL, 8507, 436)
    truth = run(PLANT, law, WAY, integrator=Adaptive(1e-12, 1e-14), every=0.01)
    found = run(PLANT, law, WAY, integrator=method, every=0.01)
    assert np.array_equal(found.time, truth.time)
    assert np.abs(found.tool - truth.tool).max() < 1e-7
    assert np.abs(found.effort - truth.effort).max() < 1e-3
    assert np.abs(found.work - truth.work).max() < 1e-5


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("every", "duration"), [(0.03, 0.2), (0.05, 0.2), (0.5, 0.2)])
def test_samples_lie_where_they_were_asked_for_and_at_the_end(method, every, duration):
    found = run(PLANT, PD(1000, 100), WAY, integrator=method, every=every, duration=duration)
    expected = np.append(np.arange(0.0, duration - 1e-9, every), duration)
    assert np.allclose(found.time, expected, rtol=0, atol=1e-12)


def test_a_step_cut_short_by_a_sample_does_not_shorten_the_next():
    asked = []

    class Doubling:
        """Takes what it is given, asks for twice what it took."""

        name, interpolates = "doubling", False

        def first(self, field, t, y, slope, span):
            return 0.04

        def step(self, field, t, y, slope, h, end, span):
            asked.append(h)
            taken = min(h, end - t)
            return Step(t + taken if taken < end - t else end, y + taken * slope, None, 2.0 * taken)

    run(PLANT, PD(10.0, 10.0), Reference(Hold(START, 0.2), MODEL), integrator=Doubling(), every=0.05)
    assert np.allclose(asked[:3], [0.04, 0.08, 0.08])


def test_without_spacing_every_step_is_a_sample():
    found = run(PLANT, PD(1000, 100), WAY, integrator=RungeKutta4(1e-3), duration=0.1)
    assert np.allclose(found.time, np.linspace(0.0, 0.1, 101), atol=1e-12)
    assert found.about["steps"] == 100
    adaptive = run(PLANT, PD(1000, 100), WAY, duration=0.1)
    assert len(adaptive) == adaptive.about["steps"] + 1


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("rate", [200.0, 330.0])
def test_sampled_control_holds_its_effort(method, rate):
    law = PDGravity(MODEL, 8507, 200)
    found = run(PLANT, law, WAY, integrator=method, rate=rate, every=1e-3, duration=0.2)
    period = np.floor(found.time * rate + 1e-9)
    for k in np.unique(period):
        block = found.effort[period == k]
        assert np.array_equal(block, np.broadcast_to(block[0], block.shape))
    # The effort of each period is that of the law at its start.
    start = run(PLANT, law, WAY, integrator=method, rate=rate, every=1 / rate, duration=0.1)
    for i in range(5):
        desired = WAY.at(start.time[i])
        assert np.allclose(start.effort[i], law.effort(desired, start.q[i], start.v[i], np.zeros(0)), rtol=1e-9)


def test_fast_sampling_tends_to_continuous_control():
    law = PDGravity(MODEL, 8507, 436)
    truth = run(PLANT, law, WAY, every=0.01)
    distance = [
        np.abs(run(PLANT, law, WAY, rate=r, integrator=RungeKutta4(), every=0.01).tool - truth.tool).max()
        for r in (250, 500, 1000)
    ]
    ratios = np.array(distance[:-1]) / distance[1:]
    # A hold is a delay of half a period: the difference halves with the period.
    assert np.allclose(ratios, 2.0, atol=0.25), distance


def test_saturation_is_kept_and_is_the_loops():
    limits = [5.0, 20.0, 45.0]
    free = run(PLANT, PD(8507, 436), WAY, every=1e-3)
    bound = run(PLANT, PD(8507, 436), WAY, every=1e-3, limits=limits)
    assert (free.peak_effort() > limits).any()
    assert (bound.peak_effort() <= limits).all()
    assert np.isclose(run(PLANT, PD(8507, 436), WAY, every=1e-3, limits=20.0).peak_effort().max(), 20.0)


@pytest.mark.parametrize("rate", few([None, 500.0], 500.0))
def test_the_integral_takes_the_rest_of_the_error_away(rate):
    hold = Reference(Hold(START, 4.0), MODEL)
    plain = run(PLANT, PD(2000, 200), hold, rate=rate, every=0.1, integrator=RungeKutta4(2e-3))
    integral = run(PLANT, PID(2000, 6000, 200), hold, rate=rate, every=0.1, integrator=RungeKutta4(2e-3))
    assert plain.worst_error(3.9) > 0.01
    assert integral.worst_error(3.9) < 1e-4


def test_anti_windup_comes_back_sooner():
    """A slider that is too weak to hold the weight for a second: the integral must not have grown."""

    class Unguarded(PID):
        def memory_rate(self, desired, q, v, asked, given):
            return desired.q - q

    far = PointToPoint(START, [0.3, 0.425, 0.3], 0.1)
    reference = Reference(far, MODEL, 2.0)
    settings = {"limits": [4.0, 60.0, 60.0], "every": 0.02, "integrator": RungeKutta4(2e-3), "duration": 2.0}
    guarded = run(PLANT, PID(800, 3000, 80), reference, **settings)
    unguarded = run(PLANT, Unguarded(800, 3000, 80), reference, **settings)
    overshoot = [float(0.3 - result.tool[:, 0].min()) for result in (guarded, unguarded)]
    assert overshoot[0] < 0.6 * overshoot[1], overshoot


def test_progress_is_told_and_ends_at_the_end():
    told = []
    run(PLANT, PD(1000, 100), WAY, duration=0.05, integrator=RungeKutta4(5e-3), progress=told.append)
    assert np.allclose(told, np.linspace(0.005, 0.05, 10))


def test_what_was_run_is_written_down():
    found = run(PLANT, PD(1000, [1.0, 2.0, 3.0]), WAY, duration=0.05, rate=100, limits=50.0)
    about = found.about
    assert about["gains"] == {"kp": [[1000.0]], "kd": [[1.0, 2.0, 3.0]]}
    assert (about["law"], about["rate"], about["limits"]) == ("PD", 100, 50.0)
    assert about["robot"] == MODEL.name
    assert about["actuators"] == [[f"limb{i}_slide", "translation"] for i in (1, 2, 3)]


def test_a_run_is_reproducible_to_the_bit():
    one, two = (run(PLANT, ComputedTorque(MODEL, 900, 60), WAY) for _ in range(2))
    assert np.array_equal(one.q, two.q)
    assert np.array_equal(one.effort, two.effort)


# ---- runs that cannot go on


def test_diverging_run_stops_with_its_state_and_what_there_was():
    """A step four times too long for the gain: RK4 is unstable and the limbs are soon too short."""
    with pytest.raises(SimulationError) as caught:
        run(PLANT, PD(8507, 4 * 436), WAY, integrator=RungeKutta4(1e-2))
    error = caught.value
    assert isinstance(error.result, Result)
    assert error.result.time[-1] == error.t
    assert np.array_equal(error.result.q[-1], error.q)
    assert np.isfinite(error.result.effort).all()
    assert f"t = {error.t:.6g} s" in str(error)


@pytest.mark.parametrize("method", METHODS)
def test_a_robot_that_falls_out_of_its_reach_stops(method):
    with pytest.raises(SimulationError, match="limb") as caught:
        run(PLANT, NoControl(), Reference(Hold(START, 3.0), MODEL), integrator=method)
    assert 0.3 < caught.value.t < 0.33
    assert len(caught.value.result) > 10


@pytest.mark.parametrize("rate", [None, 100.0])
def test_an_effort_that_is_not_a_number_stops_the_run(rate):
    class Broken(PD):
        def effort(self, desired, q, v, memory):
            return np.full(3, np.nan if desired.t > 0.05 else 0.0)

    with pytest.raises(SimulationError, match="not finite"):
        run(PLANT, Broken(1.0, 1.0), WAY, rate=rate, integrator=RungeKutta4(1e-2))


def test_a_constrained_plant_that_blows_up_stops(cpm):
    with pytest.raises(SimulationError) as caught:
        run(ConstrainedPlant(cpm.chain), PD(8507, 40 * 436), WAY, integrator=RungeKutta4(1e-2))
    assert np.isfinite(caught.value.q).all()


@pytest.mark.parametrize(
    ("settings", "about"),
    [
        ({"duration": 0.0}, "duration"),
        ({"duration": -1.0}, "duration"),
        ({"rate": -5.0}, "rate"),
        ({"rate": 0.0}, "rate"),
        ({"rate": np.nan}, "rate"),
        ({"every": 0.0}, "every"),
        ({"limits": [1.0, 2.0]}, "limits"),
        ({"limits": -1.0}, "limits"),
        ({"limits": "strong"}, "limits"),
        ({"start_velocity": [0.0, 0.0]}, "start_velocity"),
        ({"start_velocity": [0.0, 0.0, np.inf]}, "start_velocity"),
    ],
)
def test_bad_arguments_are_refused(settings, about):
    with pytest.raises(InputError, match=about):
        run(PLANT, PD(1.0, 1.0), WAY, **settings)


def test_gains_of_another_robot_are_refused():
    with pytest.raises(InputError, match="gain kp"):
        run(PLANT, PD([1.0, 2.0], 1.0), WAY)
