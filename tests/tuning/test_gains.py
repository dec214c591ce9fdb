"""Gains that are found keep what was asked for, on robots of many kinds."""

import math

import numpy as np
import pytest

import cutjoint
from cutjoint.errors import InputError, Interrupted, UnknownNameError
from cutjoint.motion import Reference, about_home
from cutjoint.papers.cpm import InferredCpmModel
from cutjoint.papers.cpm.published import CIRCLE, FORCE_LIMIT, SETTLING_TIME, TABLE_3
from cutjoint.robots import PUBLISHED
from cutjoint.simulation.hardware import Clock, Encoder, Hardware
from cutjoint.tuning import GainSearch, PaperRule, PolePlacement, tune
from cutjoint.tuning.case import TuningCase
from cutjoint.tuning.poles import by_poles
from cutjoint.tuning.rule import by_rule

pytest.importorskip("control")


def case_of(name, law, **more):
    robot = cutjoint.load(name)
    return TuningCase(robot, law, Reference(about_home(robot), robot), **more)


@pytest.fixture(scope="module")
def circle():
    model = InferredCpmModel()
    return Reference(PUBLISHED["cpm"].trajectory(), model)


@pytest.mark.slow
@pytest.mark.parametrize("row", TABLE_3, ids=lambda row: row.controller)
def test_the_papers_rule_gives_the_papers_gains(row, circle):
    """Of PD and PD with gravity to the last digit by the inferred model; the third hangs on the first sample."""
    name = row.controller.replace("_", "-")
    case = TuningCase(circle.mechanism, name, circle, limits=FORCE_LIMIT, after=SETTLING_TIME)
    found = by_rule(case, PaperRule(row.bound), {"kp": 1000.0})
    kp, kd = float(found.gains["kp"]), float(found.gains["kd"])
    assert kd == row.k_d
    assert kp == (7078.0 if name == "feedforward" else row.k_p)
    words = " ".join(found.free)
    if name == "pd":
        assert "every kd from 293.4 to 436" in words
        assert "kd does not move it" in words
    if name == "feedforward":
        assert "kp hangs on kd" in words


def test_the_largest_kd_is_the_limit_over_the_speed_that_is_desired(circle):
    """PD at rest on the path: kd times the speed of the circle is the limit, up to a whole number."""
    from cutjoint.tuning.rule import _effort_part, _largest

    case = TuningCase(circle.mechanism, "pd", circle, limits=FORCE_LIMIT)
    found = _largest(lambda kd: _effort_part(case, 0.0, kd), 3)
    assert found == math.floor(FORCE_LIMIT / (CIRCLE.radius * CIRCLE.omega))


@pytest.mark.slow
def test_the_smallest_gain_of_a_reference_from_rest_keeps_the_bound():
    case = case_of("fivebar", "pd-gravity", limits=20.0, after=0.3)
    found = by_rule(case, PaperRule(1e-3), {"kp": 10.0})
    from cutjoint.tuning.runs import CaseRuns

    runs = CaseRuns(case, found.gains)
    kp, kd = found.gains["kp"], found.gains["kd"]
    late = runs.figures({"kp": np.array([kp, 0.99 * kp]), "kd": np.array([kd, kd * np.sqrt(0.99)])}).late
    assert late[0] < 1e-3 < late[1]
    assert any("starts at rest" in one for one in found.told)


LAWS = ("pd", "pd-gravity", "feedforward", "pid")


@pytest.mark.parametrize(
    ("name", "law", "w", "z"),
    [
        *(
            pytest.param(name, law, w, z, marks=pytest.mark.slow)
            for name, law, w, z in (
                ("fivebar", "pd", 20.0, 1.0),
                ("omega3", "pid", 15.0, 0.7),
                ("stewart", "pd-gravity", 30.0, 0.5),
                ("cpm", "feedforward", 40.0, 1.0),
                ("fourbar", "pd", 5.0, 0.9),
                ("cpm_rotary", "pid", 10.0, 1.0),
            )
        ),
    ],
)
def test_poles_are_where_they_were_asked_for(name, law, w, z):
    case = case_of(name, law)
    found = by_poles(case, PolePlacement(w, z))
    loops = case.linear(found.gains)
    wanted = min(z, 0.2 if law == "pid" else 1.0) * w
    assert min(one.decay for one in loops) >= wanted * (1.0 - 1e-4)
    assert min(one.damping for one in loops) >= z * (1.0 - 1e-4)
    less = {one: 0.7 * value for one, value in found.gains.items()}
    slower = case.linear(less)
    assert min(min(one.decay / wanted, one.damping / z) for one in slower) < 1.05  # it asks for little more than needed


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fivebar", "omega3", "cpm"])
def test_computed_torque_is_placed_exactly(name):
    case = case_of(name, "computed-torque")
    gains = by_poles(case, PolePlacement(25.0, 0.6)).gains
    assert (float(gains["kp"]), float(gains["kd"])) == (625.0, 30.0)
    for loop in case.linear(gains):
        assert np.allclose(np.abs(loop.poles), 25.0, rtol=1e-4)
        assert loop.damping == pytest.approx(0.6, rel=1e-4)
    with_payload = case_of(name, "computed-torque", payloads=[0.0, 0.2])
    assert "would be exact" in by_poles(with_payload, PolePlacement(25.0, 0.6)).told[0]


@pytest.mark.slow
@pytest.mark.parametrize("method", ["evolution", "optuna"])
def test_a_search_is_never_worse_than_where_it_began_and_the_same_for_a_seed(method):
    if method == "optuna":
        pytest.importorskip("optuna")
    robot = cutjoint.load("fivebar")
    reference = Reference(about_home(robot), robot)
    hardware = Hardware(Clock(500.0), Encoder(noise=1e-5, delay=2e-3))

    def go(seed=3):
        how = GainSearch(method, trials=20, seed=seed)
        return tune(robot, "pd-gravity", reference, by=how, hardware=hardware, payloads=[0.0, 0.05], draws=2)

    first, again, other = go(), go(), go(4)
    assert all(np.array_equal(first.gains[name], again.gains[name]) for name in first.gains)
    assert not all(np.array_equal(first.gains[name], other.gains[name]) for name in first.gains)
    found, usual = first.rows
    assert usual.label == "usual"
    assert found.rms < usual.rms
    assert found.margins.stable
    assert found.margins.sensitivity < 2.1 or any("sensitivity" in one for one in first.unmet)
    assert all(np.isfinite(one.settling) for one in found.steps)


@pytest.mark.slow
def test_a_search_that_is_interrupted_keeps_the_best():
    robot = cutjoint.load("fivebar")
    reference = Reference(about_home(robot), robot)

    def stop(done):
        if done > 20:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as stopped:
        tune(robot, "pd-gravity", reference, by=GainSearch(trials=200), hardware=Hardware(Clock(500.0)), progress=stop)
    kept = stopped.value.result
    assert kept.found.rms <= kept.rows[1].rms
    assert 0.0 < stopped.value.done < 1.0


def test_what_cannot_be_tuned_is_told():
    robot = cutjoint.load("fivebar")
    reference = Reference(about_home(robot), robot)
    for error, match, law, more in (
        (UnknownNameError, "computed-torque", "computed-torqe", {}),
        (InputError, "no gains", "none", {}),
        (InputError, "payloads must be masses", "pd", {"payloads": [-1.0]}),
        (InputError, "counts from a time in the run", "pd", {"after": 9.0}),
        (InputError, "limits must be", "pd", {"limit": -1.0}),
        (InputError, "give one", "pd", {}),
        (InputError, "kp and kd", "pid", {"limit": 20.0}),
        (InputError, "takes the gains", "pd", {"begin": {"kp": 1.0}}),
    ):
        with pytest.raises(error, match=match):
            tune(robot, law, reference, by=PaperRule(1e-3), **more)
    for values in ({"error": 0.0}, {"error": -1.0}):
        with pytest.raises(InputError, match="error of the rule"):
            PaperRule(**values)
    for make in (lambda: PolePlacement(0.0), lambda: PolePlacement(20.0, -0.1), lambda: GainSearch(trials=3)):
        with pytest.raises(InputError):
            make()
    with pytest.raises(InputError, match="change them in the description"):
        TuningCase(cutjoint.load("underactuated"), "pd", reference)
