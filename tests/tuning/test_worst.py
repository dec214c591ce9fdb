"""What counts of a set of gains: the worst payload and noise, the same for all sets, and what it was asked to keep."""

import numpy as np
import pytest

import cutjoint
from cutjoint.errors import InputError
from cutjoint.motion import Reference, about_home
from cutjoint.simulation.hardware import Clock, Differences, Encoder, Hardware, Tachometer
from cutjoint.tuning import GainSearch, PolePlacement, tune
from cutjoint.tuning.case import TuningCase, draws_of
from cutjoint.tuning.runs import CaseRuns
from cutjoint.tuning.search import PENALTY, Searching, sensitivity_peak

pytest.importorskip("control")

PERIOD, PAYLOADS, DRAWS = 4e-3, (0.2, 0.0), 3
GAINS = {"kp": 40.0, "kd": 0.6}


def fourbar():
    robot = cutjoint.load("fourbar")
    return robot, Reference(about_home(robot, 0.05, 0.1), robot)


@pytest.fixture(scope="module")
def noisy():
    robot, reference = fourbar()
    hardware = Hardware(Clock(1.0 / PERIOD), Encoder(noise=1e-3), Differences(30.0), seed=5)
    limits = [2.0]
    return TuningCase(robot, "pd", reference, hardware=hardware, payloads=PAYLOADS, draws=DRAWS, limits=limits)


def test_the_worst_payload_and_noise_count_and_all_sets_meet_the_same(noisy):
    runs = CaseRuns(noisy, GAINS)
    sets = {name: np.array([one, 1.5 * one, one]) for name, one in GAINS.items()}
    found = runs.figures(sets, late=False)
    assert found.rms[0] == found.rms[2] != found.rms[1]
    single = [
        runs.loop.run(
            noisy.reference,
            step=runs.step,
            gains={name: np.array([[one]]) for name, one in GAINS.items()},
            parameters={"payload": [payload]},
            first_run=draw,
        )
        for payload in PAYLOADS
        for draw in range(DRAWS)
    ]
    errors = [float(one.error_rms[0, 0]) for one in single]
    assert len(set(errors)) == len(errors)
    assert found.rms[0] == pytest.approx(max(errors), rel=1e-9)
    assert found.peak[0, 0] == pytest.approx(max(float(one.effort_max[0, 0]) for one in single), rel=1e-9)


def test_efforts_beyond_the_limit_and_a_peak_of_the_sensitivity_cost(noisy):
    search = Searching(noisy, GainSearch(trials=20, sensitivity=1.2), {name: np.array(x) for name, x in GAINS.items()})
    logs = np.log([[0.1, 0.5], [1.0, 1.0], [3.0, 2.0]])
    cost = search.costs(logs)
    figures = search.runs.figures(search.gains(logs), late=False)
    for k, log in enumerate(logs):
        gains = {name: one[0] for name, one in search.gains(log[None, :]).items()}
        beyond = max(0.0, figures.peak[k, 0] / 2.0 - 1.0)
        peak = max(sensitivity_peak(one, 60) for one in noisy.linear(gains))
        wanted = figures.rms[k] * (1.0 + PENALTY * (beyond + max(0.0, peak / 1.2 - 1.0)))
        assert cost[k] == pytest.approx(wanted, rel=1e-9)
    assert figures.peak[0, 0] < 2.0 < figures.peak[2, 0]
    assert search.least == cost.min()


def test_draws_are_for_loops_with_chance():
    still = Hardware(Clock(250.0))
    assert draws_of(None, None) == draws_of(None, still) == 1
    chances = (
        Hardware(Clock(250.0), Encoder(noise=1e-5)),
        Hardware(Clock(250.0), speed=Tachometer(noise=1e-5)),
        Hardware(Clock(250.0, jitter=1e-4, tick=1e-4)),
    )
    assert [draws_of(None, one) for one in chances] == [3, 3, 3]
    assert draws_of(7, chances[0]) == 7
    for asked, hardware in ((2, None), (2, still), (0, chances[0]), (1.5, chances[0])):
        with pytest.raises(InputError, match="draws"):
            draws_of(asked, hardware)


@pytest.mark.slow
def test_what_does_not_hold_is_not_met():
    robot, reference = fourbar()
    free = tune(robot, "pd-gravity", reference, by=PolePlacement(), after=0.05)
    assert not free.unmet
    peak = float(free.found.peak[0])
    for part, met in ((1.01, True), (0.99, False)):
        held = tune(robot, "pd-gravity", reference, by=PolePlacement(), after=0.05, limit=part * peak)
        assert (not held.unmet) is met
        assert met or "its limit is" in held.unmet[0]
    quick = tune(robot, "pd", reference, by=PolePlacement(300.0), hardware=Hardware(Clock(100.0)), after=0.05)
    assert not quick.found.margins.stable
    assert "unstable" in quick.unmet[0]
