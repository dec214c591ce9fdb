"""Small motions around an equilibrium: pendulums as the books have them, and what the equations of motion do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from kit.quickly import few
from scipy.linalg import expm

import cutjoint
from cutjoint import Load
from cutjoint.chain import ClosedChain
from cutjoint.description.model import Inertial, Joint, JointType, Link, RobotDescription
from cutjoint.errors import ActuationError, InputError
from cutjoint.mechanism import JointPhysics, Posture
from cutjoint.simulation import Adaptive, MinimalPlant, run


def pendulum(length: float = 0.4, mass: float = 2.0, physics: JointPhysics | None = None) -> ClosedChain:
    """A mass on a rod that hangs from a hinge, without a motor."""
    hinge = Joint("hinge", JointType.CONTINUOUS, "base", "rod", axis=(0.0, 1.0, 0.0))
    return ClosedChain(
        RobotDescription(
            name="pendulum",
            links=(Link("base"), Link("rod", Inertial(mass, np.array([0.0, 0.0, -length])))),
            joints=(hinge if physics is None else replace(hinge, physics=physics),),
            gravity=(0.0, 0.0, -9.81),
        )
    )


@pytest.mark.parametrize("length", [1e-3, 0.4, 1e3])
def test_a_pendulum(length: float) -> None:
    """It swings with sqrt(g / l), falls with the same rate upside down, and its damper takes what dampers take."""
    minimal = pendulum(length).minimal("hinge")
    rate = np.sqrt(9.81 / length)
    below = minimal.linearised(minimal.chain.home)
    assert np.abs(below.state - [[0.0, 1.0], [-(rate**2), 0.0]]).max() < 1e-10 * max(1.0, rate**2)
    assert below.eigenvalues == pytest.approx([1j * rate, -1j * rate][::-1], abs=1e-9 * rate)
    above = minimal.linearised(minimal.moved(minimal.chain.home, [np.pi]))
    assert above.eigenvalues.real == pytest.approx([rate, -rate], rel=1e-10)
    assert below.input.shape == (2, 0)


def test_springs_dampers_and_smooth_friction_of_a_pendulum() -> None:
    length, mass = 0.4, 2.0
    inertia = mass * length**2
    physics = JointPhysics(
        damping=0.3, friction=0.2, friction_speed=0.05, stiffness=4.0, rest=0.0, rotor=1e-4, gear=30.0
    )
    minimal = pendulum(length, mass, physics).minimal("hinge")
    total = inertia + 0.09
    wanted = [[0.0, 1.0], [-(mass * 9.81 * length + 4.0) / total, -(0.3 + 0.2 * 15.0 / 8.0 / 0.05) / total]]
    found = minimal.linearised(minimal.chain.home)
    assert np.abs(found.state - wanted).max() < 1e-9 * np.abs(wanted).max()
    sticking = pendulum(length, mass, replace(physics, friction_speed=0.0)).minimal("hinge")
    with pytest.raises(InputError, match="friction of 'hinge' sticks"):
        sticking.linearised(sticking.chain.home)


def resting(minimal: cutjoint.MinimalCoordinates, at: Posture) -> Posture:
    """The equilibrium without efforts next to a posture, by Newton's method on the weights."""
    for _ in range(5):
        held = minimal.terms(at).holding
        step = 1e-5
        slopes = [
            (
                minimal.terms(minimal.moved(at, step * one)).holding
                - minimal.terms(minimal.moved(at, -step * one)).holding
            )
            / (2.0 * step)
            for one in np.eye(minimal.n)
        ]
        at = minimal.moved(at, -np.linalg.lstsq(np.stack(slopes, axis=1), held, rcond=1e-6)[0])
    return at


def test_a_crane_swings_as_its_linearisation_says() -> None:
    """A small swing of the underactuated crane under a small push, against the exponential of the matrix."""
    minimal = cutjoint.load("underactuated").minimal("left")
    at = resting(minimal, minimal.chain.home)
    linear = minimal.linearised(at)
    n, small, push = minimal.n, 1e-5, 1e-4
    start = small * np.array([0.3, 1.0, -0.2, 0.5])
    plant = MinimalPlant(minimal)
    state = plant.state(minimal.moved(at, start[:n]), start[n:])
    end = 0.4
    found = run(plant, lambda t: [push], start=state, duration=end, integrator=Adaptive(1e-12, 1e-16))
    block = np.zeros((2 * n + 1, 2 * n + 1))
    block[: 2 * n, : 2 * n], block[: 2 * n, 2 * n :] = linear.state, push * linear.input
    wanted = (expm(end * block) @ np.append(start, 1.0))[:n]
    moved = minimal.change(at, minimal.chain.posture(found.q_full[-1]))
    assert np.abs(moved - wanted).max() < 1e-4 * np.abs(wanted).max()


@pytest.mark.parametrize("name", few(["fourbar", "fivebar", "stewart"], "fourbar", "fivebar"))
def test_it_is_the_derivative_of_compiled_functions(name: str) -> None:
    pytest.importorskip("llvmlite")
    chain = cutjoint.load(name)
    minimal, compiled, still = chain.minimal(), cutjoint.compiled(chain), np.zeros(chain.n)
    effort = chain.inverse_dynamics(chain.home, still, still)
    found, wanted = minimal.linearised(chain.home), compiled.forward_derivatives(chain.home, still, effort)
    n, size = chain.n, np.abs(wanted.by_q).max()
    assert found.effort == pytest.approx(effort, rel=1e-9, abs=1e-12)
    assert np.abs(found.state[n:, :n] - wanted.by_q).max() < 1e-9 * size
    assert np.abs(found.state[n:, n:] - wanted.by_v).max() < 1e-9 * np.sqrt(size)
    assert np.abs(found.input[n:] - wanted.by_input).max() < 1e-9 * np.abs(wanted.by_input).max()
    assert not found.input[:n].any()


def test_what_does_not_stay_is_refused() -> None:
    minimal = cutjoint.load("underactuated").minimal("left")
    aside = minimal.moved(minimal.chain.home, [0.0, 0.3])
    with pytest.raises(ActuationError, match="cannot produce this motion"):
        minimal.linearised(aside)
    with pytest.raises(InputError, match="does not stand still here"):
        minimal.linearised(aside, effort=[0.0])
    at = resting(minimal, minimal.chain.home)
    with pytest.raises(InputError, match="does not stand still here"):
        minimal.linearised(at, effort=[1.0])
    held = minimal.linearised(at, loads=Load([-1.5, 0.0, 0.0], link="cart_link"))
    assert held.effort == pytest.approx([1.5], abs=1e-9)
