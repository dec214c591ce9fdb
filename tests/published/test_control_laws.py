"""What the CPM's paper says of its four control laws: every figure by a second derivation, every verdict both ways."""

from __future__ import annotations

from dataclasses import replace
from math import exp, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cutjoint.control import law
from cutjoint.experiments import cpm, cpm_law_claims, cpm_laws
from cutjoint.experiments.cpm_law_claims import operations
from cutjoint.experiments.cpm_laws import Damping, Held, Response, UpdateRate
from cutjoint.experiments.tables import Verdict
from cutjoint.papers.cpm import CpmModel, InferredCpmModel, Parameters
from cutjoint.papers.cpm.published import CIRCLE
from cutjoint.papers.omega3 import Omega3Model
from cutjoint.simulation import ReducedPlant, Result, RungeKutta4, run

pytestmark = pytest.mark.slow

SPEED = CIRCLE.radius * CIRCLE.omega
TORQUE = cpm.ROWS["computed-torque"]


def start_of_table_3(name: str, step: float = 1e-3, duration: float = 0.5) -> Result:
    made, way = cpm.controller(name, "equation"), cpm.reference("equation")
    return run(cpm.plant("equation"), made, way, integrator=RungeKutta4(step), duration=duration)


@pytest.fixture
def other_robot(monkeypatch):
    """The plant is another robot than the controller's model, so that nothing that the paper proves can hold."""
    monkeypatch.setattr(cpm, "plant", lambda column: ReducedPlant(InferredCpmModel()))


# Section 4.3: the update rate.


def slowest_stable(k_p: float, k_d: float, scale: bool = False) -> float:
    """The rate under which held feedback of the linearised robot diverges, at the worst place of the circle [Hz].

    The masses of M(q) see the force K_P e + K_D e_dot of the last update.  Computed torque sees masses of one.
    """
    model = cpm.model("equation")
    worst = 0.0
    for t in np.linspace(0.0, 4.0, 41):
        mass = np.eye(3) if scale else model.terms(cpm.reference("equation").at(float(t)).posture).mass
        for m in np.linalg.eigvalsh(mass):
            low, high = 10.0, 1000.0
            while high - low > 0.01:
                h = 2.0 / (low + high)
                row = np.array([k_p, k_d]) / m
                held = np.array([[1.0, h], [0.0, 1.0]]) - np.outer([0.5 * h * h, h], row)
                low, high = (low, 1.0 / h) if np.abs(np.linalg.eigvals(held)).max() < 1.0 else (1.0 / h, high)
            worst = max(worst, high)
    return worst


@pytest.mark.parametrize("name", ["pd", "feedforward", "computed-torque"])
def test_the_lowest_rate_is_just_above_where_held_feedback_diverges(name):
    limit = slowest_stable(cpm.ROWS[name].k_p, cpm.ROWS[name].k_d, scale=name == "computed-torque")
    yard = cpm_laws.REASONABLE * cpm_laws.late_error("pd", None)
    assert cpm_laws.late_error(name, limit - 4.0) > yard
    assert cpm_laws.late_error(name, limit + 12.0) <= yard


def test_a_rate_of_100_hz_costs_pd_nothing():
    assert cpm_laws.late_error("pd", 100.0) == pytest.approx(cpm_laws.late_error("pd", None), rel=1e-6)


@pytest.mark.slow
def test_the_lowest_rates_are_lowest():
    found = cpm_laws.update_rate()
    yard = cpm_laws.REASONABLE * found.continuous
    for name, rate in found.lowest.items():
        assert cpm_laws.late_error(name, rate) <= yard < cpm_laws.late_error(name, rate - 1)
        assert cpm_laws.SLOWEST + 1 < rate < cpm_laws.FASTEST, "found inside the search"


def test_a_run_that_diverges_has_no_error():
    assert cpm_laws.late_error("computed-torque", 40.0) == np.inf


# Section 4.4: a constant reference, and one that moves.


def test_pd_with_gravity_comes_to_rest_and_its_energy_falls():
    found = cpm_laws.held("pd-gravity")
    assert found.left < cpm_law_claims.ZERO
    assert found.rise < cpm_law_claims.ROUNDING
    assert cpm_law_claims.constant_reference(found, found).verdict is Verdict.HOLDS


def test_pd_alone_stays_where_its_springs_carry_the_weight():
    """K_P e = K(q) at the end."""
    model, k_p = cpm.model("equation"), cpm.ROWS["pd"].k_p
    there = q = np.array(CIRCLE.centre)
    for _ in range(50):
        q = there - model.terms(model.close(q)).gravity / k_p
    assert cpm_laws.held("pd").left == pytest.approx(np.linalg.norm(there - q), rel=1e-9)


def test_a_wrong_weight_keeps_pd_with_gravity_off_its_reference(other_robot):
    found = cpm_laws.held("pd-gravity", duration=0.6)
    assert found.left > 1e-5
    assert cpm_law_claims.constant_reference(found, found).verdict is Verdict.FAILS


def test_an_energy_without_the_springs_rises(monkeypatch):
    """With hardly any of their energy it is no Lyapunov function, though the robot comes to rest all the same."""
    made = cpm.controller("pd-gravity", "equation")
    monkeypatch.setattr(cpm, "controller", lambda *names: made)
    monkeypatch.setitem(cpm.ROWS, "pd-gravity", replace(cpm.ROWS["pd-gravity"], k_p=100.0))
    assert cpm_laws.held("pd-gravity", duration=0.3).rise > cpm_law_claims.ROUNDING


def test_pd_with_gravity_leaves_an_error_where_the_reference_moves():
    """About (M a_d + c) / K_P, which the law knows nothing of."""
    way, model = cpm.reference("equation"), cpm.model("equation")
    missing = []
    for t in np.linspace(0.5, 3.5, 31):
        d = way.at(float(t))
        force = model.inverse_dynamics(d.posture, d.v, d.a) - model.terms(d.posture).gravity
        missing.append(np.linalg.norm(force))
    error = cpm_laws.tracking_error("pd-gravity")
    assert error == pytest.approx(max(missing) / cpm.ROWS["pd-gravity"].k_p, rel=0.1)
    assert cpm_law_claims.imperfect(error).verdict is Verdict.HOLDS
    assert cpm_law_claims.imperfect(0.0).verdict is Verdict.FAILS


# Section 4.5: exact feedforward, and a load.


def test_exact_feedforward_keeps_the_error_zero_with_and_without_feedback():
    closed, alone = (cpm_laws.tracking_error("feedforward", feedback) for feedback in (True, False))
    assert closed < cpm_law_claims.ZERO
    assert alone < cpm_law_claims.ZERO
    assert cpm_law_claims.exact_feedforward(closed, alone).verdict is Verdict.HOLDS


def test_feedforward_of_another_model_does_not(other_robot):
    closed = cpm_laws.tracking_error("feedforward", duration=0.2)
    assert closed > 1e-6
    assert cpm_law_claims.exact_feedforward(closed, 0.0).verdict is Verdict.FAILS


@pytest.fixture(scope="module")
def load():
    return {name: cpm_laws.load_response(name) for name in cpm.ROWS}


def stiffness(name: str) -> np.ndarray:
    """Force a metre of error, shape (3, 3) [N/m], where the load is picked up."""
    k_p = cpm.ROWS[name].k_p
    if name != "computed-torque":
        return k_p * np.eye(3)
    at = cpm.reference("equation").at(cpm_laws.PICKED_UP).posture
    return k_p * cpm.model("equation").terms(at).mass


@pytest.mark.parametrize("name", cpm.ROWS)
def test_a_load_moves_the_tool_by_its_weight_over_the_stiffness(load, name):
    """Within the little that the mass still swings and the posture changes meanwhile."""
    desired = cpm.reference("equation").at(cpm_laws.PICKED_UP)
    force = cpm_laws.LOAD * (desired.a - np.array([0.0, 0.0, Parameters().g]))
    wanted = np.linalg.norm(np.linalg.solve(stiffness(name), force))
    assert load[name].deviation == pytest.approx(wanted, rel=0.03)


@pytest.mark.parametrize("name", cpm.ROWS)
def test_the_rise_time_is_that_of_mass_damper_and_spring(load, name):
    """Along z, with the mass there and the load."""
    at = cpm.reference("equation").at(cpm_laws.PICKED_UP).posture
    mass = float(cpm.model("equation").terms(at).mass[2, 2])
    k_p, k_d = (
        gain * (mass if name == "computed-torque" else 1.0) for gain in (cpm.ROWS[name].k_p, cpm.ROWS[name].k_d)
    )
    t = np.linspace(0.0, 0.4, 4001)
    left = cpm_laws.linear_error(t, 1.0, 0.0, k_p / (mass + cpm_laws.LOAD), k_d / (mass + cpm_laws.LOAD))
    wanted = t[np.argmax(1.0 - left >= 0.9 * (1.0 - left).max())]
    assert load[name].rise_time == pytest.approx(wanted, rel=0.1)


def test_what_the_load_says_of_the_claims(load):
    slower, sensitive = cpm_law_claims.changed_mass(load["feedforward"], load["computed-torque"])
    assert (slower.verdict, sensitive.verdict) == (Verdict.HOLDS, Verdict.FAILS)
    slower, sensitive = cpm_law_claims.changed_mass(load["computed-torque"], load["feedforward"])
    assert (slower.verdict, sensitive.verdict) == (Verdict.FAILS, Verdict.HOLDS)
    assert cpm_law_claims.disturbed(load).verdict is Verdict.FAILS
    assert cpm_law_claims.disturbed(load | {"pd": Response(1.0, 0.1)}).verdict is Verdict.HOLDS
    assert "PD 0.785, PD + gravity 1.156, PD + feedforward 1.394, computed torque 0.876" in (
        cpm_law_claims.disturbed(load).found
    )


def test_without_a_load_nothing_moves(monkeypatch):
    monkeypatch.setattr(cpm_laws, "LOAD", 0.0)
    assert cpm_laws.load_response("feedforward", duration=0.05).deviation == 0.0


# Sections 4.3 and 4.5: computations.


def test_operations_of_the_laws():
    """PD: two differences, two products and a sum an actuator; what is fed forward adds one sum each."""
    for model in (CpmModel(), Omega3Model()):
        gains = {"kp": 1.5, "kd": 2.5}
        count = {name: operations(law(name, model, gains), model) for name in cpm.ROWS}
        assert count["pd"] == 5 * model.n
        assert count["pd-gravity"] == count["feedforward"] == 6 * model.n
        assert count["computed-torque"] > 10 * count["feedforward"]
    assert operations(law("none", model, {}), model) == 0
    assert cpm_law_claims.computations().verdict is Verdict.HOLDS


def test_a_law_that_computes_online_is_not_cheap(monkeypatch):
    monkeypatch.setattr(cpm, "controller", lambda *names: law("computed-torque", CpmModel(), {"kp": 1.5, "kd": 2.5}))
    assert cpm_law_claims.computations().verdict is Verdict.FAILS


# Section 4.6: the linear error equation.


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(0.05, 60.0), st.floats(0.1, 3.0))
def test_the_closed_form_solves_the_error_equation(e, rate, frequency, ratio):
    """By RK4 with steps of a thousandth of the fastest time constant."""
    k_p, k_d = frequency**2, 2.0 * ratio * frequency
    field = np.array([[0.0, 1.0], [-k_p, -k_d]])
    h = 1e-2 / (frequency * (ratio + 1.0))
    step = sum(np.linalg.matrix_power(h * field, k) / float(np.prod(range(1, k + 1))) for k in range(5))
    y = np.linalg.matrix_power(step, 300) @ [e, rate]
    found = cpm_laws.linear_error(np.array([0.0, 300 * h]), e, rate, k_p, k_d)
    scale = abs(e) + abs(rate) / frequency
    np.testing.assert_allclose(found, [e, y[0]], rtol=0, atol=1e-7 * scale + 1e-300)


def test_critical_damping_is_a_case_of_its_own():
    t = np.linspace(0.0, 0.1, 7)
    near = cpm_laws.linear_error(t, 0.3, 0.2, 2550.25, 101.0 * (1.0 + 1e-9))
    np.testing.assert_allclose(cpm_laws.linear_error(t, 0.3, 0.2, 2550.25, 101.0), near, atol=1e-6)


def test_every_axis_obeys_its_own_linear_equation():
    deviation = cpm_laws.linearised()
    assert deviation < cpm_law_claims.SAME
    assert cpm_law_claims.linear(deviation).verdict is Verdict.HOLDS


def test_with_another_model_it_does_not(other_robot):
    deviation = cpm_laws.linearised()
    assert deviation > 1e-3
    assert cpm_law_claims.linear(deviation).verdict is Verdict.FAILS


def test_damping_ratios():
    """Overshoot exp(-pi ratio / sqrt(1 - ratio^2)); times from the closed form."""
    found = cpm_laws.damping()
    t = np.arange(0.0, 0.3, 1e-3)
    for ratio, one in found.items():
        swing = exp(-pi * ratio / sqrt(1.0 - ratio**2)) if ratio < 1.0 else 0.0
        assert one.overshoot == pytest.approx(swing, rel=2e-3)
        left = np.abs(cpm_laws.linear_error(t, 1.0, 0.0, TORQUE.k_p, 2.0 * ratio * sqrt(TORQUE.k_p)))
        late = t[np.flatnonzero(left > cpm_laws.SETTLED)[-1] + 1]
        assert one.settling_time == pytest.approx(late, abs=1.1e-3)
    assert cpm_law_claims.critical(found).verdict is Verdict.HOLDS
    assert cpm_law_claims.critical(found | {1.1: Damping(0.0, 0.1)}).verdict is Verdict.FAILS
    assert cpm_law_claims.critical(found | {0.9: Damping(0.0, 0.2)}).verdict is Verdict.FAILS


def test_the_error_of_table_3_decays_as_equation_50_and_not_as_47():
    result = start_of_table_3("computed-torque")
    found = cpm_laws.decay(result)
    # The largest of e_dot(0) t exp(-K_D t / 2) is at t = 2 / K_D.
    assert found.largest == pytest.approx(2.0 * SPEED / (TORQUE.k_d * exp(1.0)), rel=1e-4)
    assert found.deviation < cpm_law_claims.SAME * found.largest
    assert found.rate == pytest.approx(TORQUE.k_d / 2.0, rel=1e-6)
    results = {("run", "computed-torque", column): result for column in ("equation", "lumped")}
    assert [one.verdict for one in cpm_law_claims.decays(results)] == [Verdict.HOLDS, Verdict.FAILS]


def test_with_another_robot_it_does_not_decay_so(other_robot):
    result = start_of_table_3("computed-torque")
    found = cpm_laws.decay(result)
    assert found.deviation > 1e-3 * found.largest
    results = {("run", "computed-torque", column): result for column in ("equation", "lumped")}
    assert cpm_law_claims.decays(results)[0].verdict is Verdict.FAILS


@pytest.mark.parametrize("k_d", [50.5, 101.0, 202.0])
def test_the_error_falls_with_the_derivative_gain(k_d):
    """The integral of (50) squared is 2 e_dot(0)^2 / K_D^3; over half a second here."""
    assert cpm_laws.critical_error(k_d) == pytest.approx(SPEED * sqrt(2.0 / (k_d**3 * 0.5)), rel=1e-3)


def test_larger_gains_are_judged_in_order():
    assert cpm_law_claims.largest_k_d({50.0: 3.0, 100.0: 2.0, 200.0: 1.0}).verdict is Verdict.HOLDS
    assert cpm_law_claims.largest_k_d({50.0: 3.0, 100.0: 1.0, 200.0: 2.0}).verdict is Verdict.FAILS


def test_a_wrong_model_costs_computed_torque_its_accuracy(monkeypatch):
    """Masses that are all too large by a share s feed s of the force too much: M e K_P = s / (1 + s) F."""
    exact, wrong = cpm_laws.wrong_model()
    assert cpm_law_claims.accurate_model(exact, wrong).verdict is Verdict.HOLDS
    way, model, off = cpm.reference("equation"), cpm.model("equation"), cpm_laws.OFF
    wanted = 0.0
    for t in np.linspace(0.3, 4.0, 75):
        d = way.at(float(t))
        force = model.inverse_dynamics(d.posture, d.v, d.a)
        error = np.linalg.solve(model.terms(d.posture).mass, off / (1.0 + off) * force) / TORQUE.k_p
        wanted = max(wanted, float(np.abs(error).max()))
    assert wrong == pytest.approx(wanted, rel=0.02)
    assert exact < 1e-7
    monkeypatch.setattr(cpm_laws, "OFF", 0.0)
    assert cpm_law_claims.accurate_model(*cpm_laws.wrong_model()).verdict is Verdict.FAILS


# The verdicts.


def test_the_verdict_on_the_update_rate_goes_both_ways():
    lowest = dict.fromkeys(cpm.ROWS, 60)
    assert cpm_law_claims.high_rate(UpdateRate(3e-3, 3e-3, lowest)).verdict is Verdict.FAILS
    assert cpm_law_claims.high_rate(UpdateRate(3e-3, 3.1e-3, lowest)).verdict is Verdict.HOLDS


def test_work_and_force():
    """The first second of table 3, which has the largest forces and most of the work."""
    runs = {name: start_of_table_3(name, 2e-3, 1.0) for name in cpm.ROWS}
    more, larger = cpm_law_claims.overwork(runs)
    assert (more.verdict, larger.verdict) == (Verdict.HOLDS, Verdict.FAILS)
    for result in runs.values():
        # Without the braking it is what the run's own energy balance counts.
        signed = np.trapezoid((result.effort * result.v).sum(axis=1), result.time)
        assert signed == pytest.approx(result.work[-1], abs=0.02)
        assert cpm_laws.work(result) > abs(signed)
    swapped = runs | {"pd": runs["computed-torque"], "computed-torque": runs["pd"]}
    more, _ = cpm_law_claims.overwork(swapped)
    assert more.verdict is Verdict.FAILS
    _, larger = cpm_law_claims.overwork(swapped)
    assert larger.verdict is Verdict.HOLDS


def test_a_robot_that_is_left_off_its_reference_is_not_stable():
    fine = Held(1e-12, 0.0, 1.5)
    assert cpm_law_claims.constant_reference(fine, fine).verdict is Verdict.HOLDS
    assert cpm_law_claims.constant_reference(replace(fine, left=1e-6), fine).verdict is Verdict.FAILS
    assert cpm_law_claims.constant_reference(replace(fine, rise=1e-6), fine).verdict is Verdict.FAILS


def test_verdicts():
    assert [Verdict.of(a, b) for a in (True, False) for b in (True, False, None)] == [
        Verdict.HOLDS,
        Verdict.EQUATION,
        Verdict.HOLDS,
        Verdict.INFERRED,
        Verdict.FAILS,
        Verdict.FAILS,
    ]
