"""Control laws, by what they promise of the closed loop."""

from inspect import signature
from typing import Annotated

import numpy as np
import pytest

from cutjoint.control import (
    LAWS,
    PD,
    PID,
    ComputedTorque,
    Feedforward,
    Law,
    NoControl,
    PDGravity,
    efforts_of,
    fitted_law,
    law,
)
from cutjoint.control.catalogue import LawRow
from cutjoint.control.law import Gain, GainHelp
from cutjoint.control.pd import Kd, Kp
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.motion import Circle, Hold, Reference
from cutjoint.papers.cpm import CpmModel
from cutjoint.papers.omega3 import Omega3Model

NONE = np.zeros(0)


@pytest.fixture(params=["cpm", "omega3"])
def case(request):
    """A model, a desired motion and a state beside it."""
    if request.param == "cpm":
        model = CpmModel()
        now = Reference(Circle([0.425, 0.425, 0.3], 0.175, 1.5), model).at(0.7)
        return model, now, now.q + np.array([0.01, -0.02, 0.015]), now.v + np.array([0.1, 0.2, -0.1])
    model = Omega3Model()
    now = Reference(Circle([0.1, 0.0, 0.0], 0.04, 4.0, [0, 1, 0], [0, 0, 1]), model).at(0.3)
    return model, now, now.q + np.array([0.02, -0.01, 0.03]), now.v + np.array([0.5, -0.2, 0.1])


def test_gains_as_number_list_or_matrix_mean_the_same(case):
    _, now, q, v = case
    laws = [PD(7.0, 3.0), PD([7.0] * 3, [3.0] * 3), PD(7.0 * np.eye(3), 3.0 * np.eye(3))]
    efforts = [one.effort(now, q, v, NONE) for one in laws]
    assert np.allclose(efforts[0], efforts[1], rtol=1e-15)
    assert np.allclose(efforts[0], efforts[2], rtol=1e-15)
    assert np.allclose(efforts[0], 7.0 * (now.q - q) + 3.0 * (now.v - v))


def test_full_matrix_gain_couples_the_actuators(case):
    _, now, q, v = case
    coupled = np.array([[1.0, 2.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    assert np.allclose(PD(coupled, 0.0).effort(now, q, v, NONE), coupled @ (now.q - q))


def test_gravity_compensation_holds_the_desired_posture_at_rest(case):
    model, now, _, _ = case
    still = Reference(Hold(now.tool.position), model).at(0.0)
    effort = PDGravity(model, 100.0, 10.0).effort(still, still.q, np.zeros(3), NONE)
    assert np.allclose(model.forward_dynamics(still.posture, np.zeros(3), effort), 0.0, atol=1e-9)


def test_feedforward_on_the_path_gives_the_desired_acceleration(case):
    model, now, _, _ = case
    effort = Feedforward(model, 100.0, 10.0).effort(now, now.q, now.v, NONE)
    assert np.allclose(model.forward_dynamics(now.posture, now.v, effort), now.a, atol=1e-9)


def test_computed_torque_makes_the_error_linear(case):
    model, now, q, v = case
    kp, kd = np.diag([300.0, 400.0, 500.0]), [30.0, 40.0, 50.0]
    effort = ComputedTorque(model, kp, kd).effort(now, q, v, NONE)
    found = model.forward_dynamics(model.close(q), v, effort)
    assert np.allclose(found - now.a, kp @ (now.q - q) + kd * (now.v - v), rtol=1e-9)


def test_critical_damping():
    made = ComputedTorque.critically_damped(CpmModel(), 101.0)
    assert made.gains == {"kp": [[2550.25]], "kd": [[101.0]]}
    with pytest.raises(InputError, match="kd"):
        ComputedTorque.critically_damped(CpmModel(), -1.0)


def test_pid_is_pd_and_the_integral(case):
    _, now, q, v = case
    memory = np.array([0.1, -0.2, 0.3])
    one = PID(7.0, 5.0, 3.0)
    assert one.memory(3) == 3
    assert np.allclose(one.effort(now, q, v, memory), PD(7.0, 3.0).effort(now, q, v, NONE) + 5.0 * memory)


def test_integral_stands_still_only_where_saturation_would_be_pushed_further(case):
    _, now, q, v = case
    one = PID(7.0, 5.0, 3.0)
    error = now.q - q
    asked = 10.0 * np.sign(error)
    free = one.memory_rate(now, q, v, asked, asked)
    wound = one.memory_rate(now, q, v, asked, 0.5 * asked)
    released = one.memory_rate(now, q, v, -asked, -0.5 * asked)
    assert np.array_equal(free, error)
    assert np.array_equal(wound, np.zeros(3))
    assert np.array_equal(released, error)


@pytest.mark.parametrize("name", LAWS)
def test_every_row_of_the_catalogue_makes_a_law(name, case):
    model, now, q, v = case
    made = law(name, model, dict.fromkeys(LAWS[name].gains, 2.0))
    assert isinstance(made, Law)
    effort = made.effort(now, q, v, np.zeros(made.memory(3)))
    assert effort.shape == (3,)
    assert np.isfinite(effort).all()
    assert set(made.gains) == set(LAWS[name].gains)


@pytest.mark.parametrize("row", LAWS.values(), ids=LAWS)
def test_a_constructor_takes_a_model_and_gains_that_say_what_they_are(row):
    parameters = [name for name in signature(row.make).parameters if name != "model"]
    assert list(row.gains) == parameters
    assert all(about.about and about.unit for about in row.gains.values())
    assert row.about


def test_a_law_with_a_gain_of_its_own_is_a_class_and_a_row(monkeypatch, case):
    class Damped(PD):
        def __init__(self, kp: Kp, kd: Kd, drag: Annotated[float, GainHelp("against the speed", "N s/m")]) -> None:
            super().__init__(kp, kd)
            self.drag = Gain("drag", drag)

        def effort(self, desired, q, v, memory):
            return self.feedback(desired, q, v) - self.drag(v)

    monkeypatch.setitem(LAWS, "damped", LawRow(Damped, "PD and drag"))
    model, now, q, v = case
    made = law("damped", model, {"kp": 7.0, "kd": 3.0, "drag": 2.0})
    assert made.gains == {"kp": [[7.0]], "kd": [[3.0]], "drag": [[2.0]]}
    assert np.allclose(made.effort(now, q, v, NONE), PD(7.0, 3.0).effort(now, q, v, NONE) - 2.0 * v)
    with pytest.raises(InputError, match="takes the gains kp, kd, drag; found kd, kp"):
        law("damped", model, {"kp": 7.0, "kd": 3.0})
    with pytest.raises(InputError, match=r"gain drag has shape \(2,\)"):
        law("damped", model, {"kp": 7.0, "kd": 3.0, "drag": [1.0, 2.0]})


def test_no_control_is_no_effort(case):
    _, now, q, v = case
    assert np.array_equal(NoControl().effort(now, q, v, NONE), np.zeros(3))


def test_unknown_controller_names_the_nearest():
    with pytest.raises(UnknownNameError, match="'computed-torque'"):
        law("computed-torqe", CpmModel(), {"kp": 1.0, "kd": 1.0})


@pytest.mark.parametrize(
    ("name", "gains", "about"),
    [
        ("pd", {"kp": 1.0}, "kp, kd; found kp"),
        ("pd", {"kp": 1.0, "kd": 1.0, "ki": 1.0}, "found kd, ki, kp"),
        ("pd", {"kp": [1.0, 2.0], "kd": 1.0}, r"gain kp has shape \(2,\) but the robot has 3 actuators"),
        ("pd", {"kp": 1.0, "kd": np.eye(4)}, r"gain kd has shape \(4, 4\)"),
        ("pd", {"kp": np.ones((2, 3)), "kd": 1.0}, "square"),
        ("pd", {"kp": np.ones((1, 1, 1)), "kd": 1.0}, "square"),
        ("pd", {"kp": -1.0, "kd": 1.0}, ">= 0"),
        ("pd", {"kp": np.nan, "kd": 1.0}, "finite"),
        ("pd", {"kp": "stiff", "kd": 1.0}, "kp"),
        ("pid", {"kp": 1.0, "ki": [1.0, 2.0], "kd": 1.0}, "gain ki"),
    ],
)
def test_gains_that_do_not_fit_are_refused(name, gains, about):
    with pytest.raises(InputError, match=about):
        law(name, CpmModel(), gains)


@pytest.mark.parametrize("answer", [None, ["1", "2"], np.zeros(2) + 1j, "strong"])
def test_efforts_are_numbers(answer: object) -> None:
    with pytest.raises(InputError, match="controller 'odd' must return efforts, one an actuator"):
        efforts_of("odd", answer)


def test_a_law_that_says_nothing_of_its_memory_is_refused() -> None:
    class Derived(Law):
        name = "derived"
        gains: dict[str, list[list[float]]] = {}  # noqa: RUF012

    with pytest.raises(InputError, match=r"memory\(2\) must give the number of the law's own states, it gave None"):
        fitted_law(Derived(), 2)
