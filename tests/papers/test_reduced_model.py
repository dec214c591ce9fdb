"""What the base of the published models does for one whose actuators are not three: a pendulum."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import cos, sin

import numpy as np
import pytest

from cutjoint.compile import compiled
from cutjoint.errors import InputError
from cutjoint.mechanism import Actuator, Mechanism, Posture, kinetic_energy
from cutjoint.papers.reduced_model import ClosedFormModel, EquationState
from cutjoint.papers.scalars import NUMBERS
from cutjoint.robots import PUBLISHED, Published


@dataclass(frozen=True)
class PendulumParameters:
    length: float = 0.4
    mass: float = 1.5
    g: float = 9.81


class PendulumState(EquationState):
    def __init__(self, p, angle, fn=NUMBERS):
        self.p, self.c, self.s = p, fn.cos(angle), fn.sin(angle)

    def mass(self):
        return ((self.p.mass * self.p.length * self.p.length,),)

    def coriolis(self, v):
        return (0.0,)

    def gravity(self):
        return (self.p.mass * self.p.g * self.p.length * self.s,)

    def potential_energy(self):
        return -self.p.mass * self.p.g * self.p.length * self.c

    def tool(self, v=None):
        rate, r = 0.0 if v is None else v[0], self.p.length
        jacobian = ((r * self.c,), (0.0,), (r * self.s,))
        return (
            (r * self.s, 0.0, -r * self.c),
            jacobian,
            (-r * self.s * rate * rate, 0.0, r * self.c * rate * rate),
        )

    def strains(self):
        return (1.0,)


class PendulumModel(ClosedFormModel[PendulumParameters, int]):
    name = "pendulum"
    actuators = (Actuator("pivot", "rotation"),)
    payload = "mass"
    stored = ("pivot",)

    @property
    def length(self):
        return self.parameters.length

    @cached_property
    def home(self):
        return self.close([0.3])

    def close(self, q, near=None, *, limits="respect"):
        return Posture(np.array(q), np.array(q))

    def reach_point(self, p, near=None):
        return self.close([np.arctan2(p[0], -p[2])])

    def branch(self, at):
        return 1

    def on_branch(self, branch):
        return self

    def rebuilt(self, parameters):
        return type(self)(parameters)

    def state(self, at):
        return PendulumState(self.parameters, self.full(at)[0])

    def state_at(self, parameters, q, branch, fn=NUMBERS):
        return PendulumState(parameters, q[0], fn)

    def inverse_kinematics(self, parameters, p, branch, fn=NUMBERS):
        return (fn.atan2(p[0], -p[2]),)


@pytest.fixture
def pendulum() -> PendulumModel:
    return PendulumModel(PendulumParameters())


def test_it_is_a_mechanism_with_the_right_motion(pendulum: PendulumModel) -> None:
    assert isinstance(pendulum, Mechanism)
    at, inertia = pendulum.close([0.7]), 1.5 * 0.4**2
    assert pendulum.inverse_dynamics(at, [2.0], [3.0])[0] == pytest.approx(3.0 * inertia + 1.5 * 9.81 * 0.4 * sin(0.7))
    assert pendulum.forward_dynamics(at, [2.0], [0.0])[0] == pytest.approx(-9.81 / 0.4 * sin(0.7))
    assert kinetic_energy(pendulum, at, [2.0]) == pytest.approx(0.5 * inertia * 4.0)
    assert pendulum.potential_energy(at) == pytest.approx(-1.5 * 9.81 * 0.4 * cos(0.7))
    np.testing.assert_allclose(pendulum.tool(at, [2.0]).drift, 4.0 * 0.4 * np.array([-sin(0.7), 0.0, cos(0.7)]))
    assert not pendulum.tool(at).drift.any()
    assert not pendulum.terms(at).coriolis.any()


def test_a_payload_is_added_to_the_parameter_that_is_named(pendulum: PendulumModel) -> None:
    assert pendulum.with_payload(0.5).parameters == PendulumParameters(mass=2.0)
    for wrong in (-1.0, float("nan")):
        with pytest.raises(InputError, match="payload"):
            pendulum.with_payload(wrong)


def test_what_is_wrong_is_refused_with_names_and_units(pendulum: PendulumModel) -> None:
    at = pendulum.home
    with pytest.raises(InputError, match=r"v must have shape \(1,\) \[rad/s\]"):
        pendulum.terms(at, [1.0, 2.0])
    with pytest.raises(InputError, match=r"effort must have shape \(1,\) \[N m\]"):
        pendulum.forward_dynamics(at, [1.0], [1.0, 2.0])
    with pytest.raises(InputError, match=r"holds \(pivot\), shape \(1,\)"):
        pendulum.state(Posture(np.zeros(1), np.zeros(2)))


def test_it_compiles_with_its_parameters_as_arguments(pendulum: PendulumModel) -> None:
    fast = compiled(pendulum, parameters=("payload", "length"), cached=False)
    at = pendulum.close([0.7])
    for chosen, same in (
        (fast, pendulum),
        (fast.with_payload(0.5), pendulum.with_payload(0.5)),
        (fast.with_parameters(length=0.6), PendulumModel(PendulumParameters(length=0.6))),
    ):
        np.testing.assert_allclose(
            chosen.forward_dynamics(at, [2.0], [0.3]), same.forward_dynamics(at, [2.0], [0.3]), rtol=1e-13
        )
        np.testing.assert_allclose(chosen.tool(at, [2.0]).drift, same.tool(at, [2.0]).drift, rtol=1e-13, atol=1e-15)


def test_a_paper_without_a_trajectory_says_so() -> None:
    row = Published(lambda: PendulumModel(PendulumParameters()))
    assert (row.variant, row.physical) == (None, None)
    with pytest.raises(InputError, match="the paper of pendulum has no trajectory"):
        row.trajectory()
    assert PUBLISHED["cpm"].trajectory().duration == 4.0
