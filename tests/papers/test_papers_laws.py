"""Laws that every published model keeps, through the interface alone."""

from __future__ import annotations

import numpy as np
import pytest

from cutjoint.errors import CutjointError, InputError, UnreachableError
from cutjoint.mechanism import Mechanism, Posture, kinetic_energy

AXES = np.eye(3)


def along(model: Mechanism, at: Posture, v, a=None):
    """t -> posture of the motion that leaves `at` with velocity v and acceleration a."""
    a = np.zeros(3) if a is None else a
    return lambda t: model.close(at.q + t * v + 0.5 * t * t * a, at)


def test_is_a_mechanism(case):
    assert isinstance(case.model, Mechanism)
    assert case.model.n == len(case.model.actuators) == 3


def test_postures_are_closed_and_reach_undoes_close(case):
    for at, _, _ in case.states:
        assert at.gap[0] < 1e-15
        again = case.model.reach(case.model.tool(at).position, at)
        np.testing.assert_allclose(again.q, at.q, rtol=0, atol=1e-13)
        np.testing.assert_allclose(again.q_full, at.q_full, rtol=0, atol=1e-13)


def test_jacobian_is_the_derivative_of_the_tool_position(case, slope):
    m = case.model
    for at, _, _ in case.states:
        differences = [slope(lambda t, e=e, at=at: m.tool(along(m, at, e)(t)).position) for e in AXES]
        np.testing.assert_allclose(m.tool(at).jacobian, np.transpose(differences), rtol=0, atol=1e-9)


def test_drift_is_the_acceleration_of_the_tool_without_acceleration_of_the_actuators(case, slope):
    m = case.model
    for at, v, _ in case.states:
        moving = along(m, at, v)
        expected = slope(lambda t, moving=moving, v=v: m.tool(moving(t)).jacobian @ v)
        np.testing.assert_allclose(m.tool(at, v).drift, expected, rtol=0, atol=1e-9)
        assert not m.tool(at).drift.any()


def test_mass_is_symmetric_positive_definite(case):
    for at, _, _ in case.states:
        mass = case.model.terms(at).mass
        np.testing.assert_array_equal(mass, mass.T)
        assert np.linalg.eigvalsh(mass).min() > 0


def test_gravity_is_the_gradient_of_the_potential_energy(case, slope):
    m = case.model
    for at, _, _ in case.states:
        expected = [slope(lambda t, e=e, at=at: m.potential_energy(along(m, at, e)(t))) for e in AXES]
        np.testing.assert_allclose(m.terms(at).gravity, expected, rtol=1e-9, atol=1e-9)


def test_power_of_the_actuators_is_the_change_of_energy(case, slope):
    m = case.model
    for at, v, a in case.states:
        moving = along(m, at, v, a)
        kinetic = slope(lambda t, g=moving, v=v, a=a: kinetic_energy(m, g(t), v + t * a))
        potential = slope(lambda t, g=moving: m.potential_energy(g(t)))
        assert m.inverse_dynamics(at, v, a) @ v == pytest.approx(float(kinetic + potential), rel=1e-8, abs=1e-8)


def test_coriolis_is_what_lagrange_asks_for(case, slope):
    """Coriolis = dM/dt v - gradient of v' M v / 2, the vector that is unique."""
    m = case.model
    for at, v, _ in case.states:
        moving = [along(m, at, e) for e in (v, *AXES)]
        momentum_rate = slope(lambda t, g=moving[0], v=v: m.terms(g(t)).mass @ v)
        gradient = [slope(lambda t, g=g, v=v: kinetic_energy(m, g(t), v)) for g in moving[1:]]
        np.testing.assert_allclose(m.terms(at, v).coriolis, momentum_rate - gradient, rtol=1e-8, atol=1e-8)


def test_coriolis_is_quadratic_in_the_velocity(case):
    for at, v, _ in case.states:
        once, back, twice = (case.model.terms(at, k * v).coriolis for k in (1.0, -1.0, 2.0))
        np.testing.assert_allclose(back, once, rtol=1e-13, atol=1e-15)
        np.testing.assert_allclose(twice, 4.0 * once, rtol=1e-13, atol=1e-15)
        assert not case.model.terms(at).coriolis.any()


def test_forward_undoes_inverse_dynamics(case):
    for at, v, a in case.states:
        terms, effort = case.model.terms(at, v), case.model.inverse_dynamics(at, v, a)
        np.testing.assert_allclose(effort, terms.mass @ a + terms.coriolis + terms.gravity, rtol=1e-13, atol=1e-14)
        np.testing.assert_allclose(case.model.forward_dynamics(at, v, effort), a, rtol=1e-11, atol=1e-11)


def test_energy_is_kept_with_no_effort(case):
    m, at, v, dt = case.model, case.states[0][0], 0.2 * case.states[0][1], 5e-4
    q, none = at.q.copy(), np.zeros(3)
    start = kinetic_energy(m, at, v) + m.potential_energy(at)
    for _ in range(120):
        a1 = m.forward_dynamics(m.close(q, at), v, none)
        v2 = v + 0.5 * dt * a1
        a2 = m.forward_dynamics(m.close(q + 0.5 * dt * v, at), v2, none)
        v3 = v + 0.5 * dt * a2
        a3 = m.forward_dynamics(m.close(q + 0.5 * dt * v2, at), v3, none)
        v4 = v + dt * a3
        a4 = m.forward_dynamics(m.close(q + dt * v3, at), v4, none)
        q, v = q + dt / 6.0 * (v + 2 * v2 + 2 * v3 + v4), v + dt / 6.0 * (a1 + 2 * a2 + 2 * a3 + a4)
        at = m.close(q, at)
    kinetic = kinetic_energy(m, at, v)
    assert kinetic > 1e-3
    assert kinetic + m.potential_energy(at) == pytest.approx(start, rel=0, abs=1e-9 * kinetic)


def test_a_payload_is_a_point_mass_at_the_tool(case):
    m, extra = case.model, 0.25
    loaded = m.with_payload(extra)
    for at, v, _ in case.states:
        tool, bare, full = m.tool(at, v), m.terms(at, v), loaded.terms(at, v)
        np.testing.assert_allclose(full.mass - bare.mass, extra * tool.jacobian.T @ tool.jacobian, rtol=0, atol=1e-13)
        np.testing.assert_allclose(full.coriolis - bare.coriolis, extra * tool.jacobian.T @ tool.drift, atol=1e-12)
        down = (loaded.potential_energy(at) - m.potential_energy(at)) / (extra * 9.81)
        assert abs(down) == pytest.approx(abs(tool.position[2]), abs=1e-12)


@pytest.mark.parametrize("mass", [-0.1, np.nan, np.inf])
def test_an_impossible_payload_is_refused(case, mass):
    with pytest.raises(InputError, match="payload"):
        case.model.with_payload(mass)


@pytest.mark.parametrize(
    "bad", [[0.1, 0.2], [[0.1, 0.2, 0.3]], [0.1, np.nan, 0.2], ["a", 0, 0], np.array([0, np.inf, 0])]
)
def test_bad_numbers_are_refused_by_name(case, bad):
    m, at = case.model, case.model.home
    still = np.zeros(3)
    calls = {
        "q": lambda: m.close(bad),
        "target": lambda: m.reach_point(bad),
        "v": lambda: m.terms(at, bad),
        "a": lambda: m.inverse_dynamics(at, still, bad),
        "effort": lambda: m.forward_dynamics(at, still, bad),
    }
    for name, call in calls.items():
        with pytest.raises(InputError, match=rf"^{name} must"):
            call()
    with pytest.raises(InputError, match=r"^v must"):
        m.tool(at, bad)
    with pytest.raises(InputError, match=r"^(a )?target (must|is)"):
        m.reach(bad)


def test_every_way_to_say_a_target_is_one_posture(case):
    """A point, a pose in each form, and coordinates by name; a pose that is turned is not reached at all."""
    m, tool = case.model, case.model.tool(case.states[0][0])
    assert m.task.names == ("x", "y", "z")
    wanted = m.reach_point(tool.position, case.states[0][0]).q_full
    by_name = dict(zip("xyz", tool.position.tolist(), strict=True))
    for target in (
        tool.position,
        tool.position.tolist(),
        tool.pose,
        tool.pose.matrix,
        [*tool.position, 0, 0, 0, 1],
        by_name,
    ):
        np.testing.assert_array_equal(m.reach(target, case.states[0][0]).q_full, wanted)
        np.testing.assert_array_equal(m.reach(target, case.states[0][0], free=True, limits="ignore").q_full, wanted)
    turned = tool.pose.moved(turn=[1e-3, 0.0, 0.0])
    with pytest.raises(UnreachableError, match=r"0\.0573 deg"):
        m.reach(turned, case.states[0][0])
    np.testing.assert_array_equal(m.reach(turned, case.states[0][0], free=True).q_full, wanted)
    with pytest.raises(InputError, match="give also z"):
        m.reach({"x": by_name["x"], "y": by_name["y"]})
    with pytest.raises(InputError, match="led by rz"):
        m.reach({**by_name, "rz": 0.0})
    beside = m.reach({"x": by_name["x"] + 1e-3}, case.states[0][0], free=True)
    np.testing.assert_allclose(m.tool(beside).position, tool.position + np.array([1e-3, 0, 0]), rtol=0, atol=1e-12)


def test_a_posture_of_another_mechanism_is_refused(case):
    stranger = Posture(np.zeros(3), np.zeros(12))
    for call in (case.model.terms, case.model.tool, case.model.potential_energy, case.model.branch):
        with pytest.raises(InputError, match="belongs to the mechanism that made it"):
            call(stranger)


def test_what_is_handed_out_is_read_only(case):
    m, (at, v, a) = case.model, case.states[0]
    tool, terms = m.tool(at, v), m.terms(at, v)
    effort = m.inverse_dynamics(at, v, a)
    handed = [at.q, at.q_full, tool.position, tool.jacobian, tool.drift, terms.mass, terms.coriolis, terms.gravity]
    handed += [effort, m.forward_dynamics(at, v, effort)]
    for array in handed:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0


def test_no_posture_outside_the_workspace(case):
    for far in ([2.0, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, 2.0]):
        with pytest.raises(CutjointError):
            case.model.reach(far)
