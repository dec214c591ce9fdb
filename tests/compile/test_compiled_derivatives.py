"""Derivatives of the compiled dynamics: the limits of differences of the model, and consistent among themselves."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cutjoint.compile import Derivatives
from cutjoint.mechanism import Posture

ROBOTS = ("cpm", "fourbar", "fivebar", "paper cpm", "paper omega3")
SLOW = ("omega3", "stewart")


def slope(function: Callable[[float], np.ndarray], h: float) -> np.ndarray:
    """Derivative at 0 by central differences with two step sizes (Richardson), error of order h^4."""
    one = (function(h) - function(-h)) / (2 * h)
    two = (function(2 * h) - function(-2 * h)) / (4 * h)
    return (4.0 * one - two) / 3.0


def columns(function: Callable[[np.ndarray], np.ndarray], at: np.ndarray, h: float) -> np.ndarray:
    """Jacobian of a function, (m, n)."""
    unit = np.eye(len(at))
    return np.stack([slope(lambda s, e=e: function(at + s * e), h) for e in unit], axis=1)


def check(kit: Any, name: str, count: int) -> None:
    model, machine = kit.model(name), kit.machine(name)
    rng = np.random.default_rng(0)
    for _ in range(count):
        at = kit.nearby(model, rng, 0.05)
        v, x = rng.normal(size=model.n), 3.0 * rng.normal(size=model.n)
        compare(machine.forward_derivatives(at, v, x), model.forward_dynamics, model, at, v, x)
        compare(machine.inverse_derivatives(at, v, x), model.inverse_dynamics, model, at, v, x)


def compare(found: Derivatives, function: Any, model: Any, at: Posture, v: np.ndarray, x: np.ndarray) -> None:
    wanted = (
        (found.value, function(at, v, x)),
        (found.by_q, columns(lambda q: function(model.close(q, at), v, x), at.q, 1e-3)),
        (found.by_v, columns(lambda w: function(at, w, x), v, 1e-3)),
        (found.by_input, columns(lambda y: function(at, v, y), x, 1e-2)),
    )
    for exact, difference in wanted:
        np.testing.assert_allclose(exact, difference, rtol=0, atol=1e-7 * max(1.0, np.abs(difference).max()))


@pytest.mark.parametrize("name", ROBOTS)
def test_derivatives_are_the_limits_of_differences(kit: Any, name: str) -> None:
    check(kit, name, 3)


@pytest.mark.slow
@pytest.mark.parametrize("name", SLOW)
def test_derivatives_of_larger_robots(kit: Any, name: str) -> None:
    check(kit, name, 3)


@pytest.mark.parametrize("name", ROBOTS)
def test_forward_and_inverse_derivatives_belong_together(kit: Any, name: str) -> None:
    # a(q, v, effort(q, v, a)) = a for all q, v: the chain rule ties the two together without any difference
    machine = kit.machine(name)
    rng = np.random.default_rng(1)
    at = kit.nearby(machine, rng, 0.05)
    v, a = rng.normal(size=machine.n), rng.normal(size=machine.n)
    inverse = machine.inverse_derivatives(at, v, a)
    forward = machine.forward_derivatives(at, v, inverse.value)
    np.testing.assert_allclose(forward.value, a, atol=1e-11)
    unit = np.eye(machine.n)
    np.testing.assert_allclose(forward.by_input @ inverse.by_input, unit, atol=1e-11)
    for one, other in ((forward.by_q, inverse.by_q), (forward.by_v, inverse.by_v)):
        scale = np.abs(one).max() + 1.0
        np.testing.assert_allclose(one + forward.by_input @ other, 0.0 * unit, atol=1e-11 * scale)


@pytest.mark.parametrize("name", ROBOTS)
def test_the_mass_matrix_is_symmetric_and_feeds_the_inverse(kit: Any, name: str) -> None:
    machine = kit.machine(name)
    at = machine.home
    found = machine.inverse_derivatives(at, np.zeros(machine.n), np.zeros(machine.n))
    np.testing.assert_array_equal(found.by_input, found.by_input.T)
    np.testing.assert_allclose(found.by_input, machine.terms(at).mass, rtol=1e-13)
    # gravity is the gradient of the potential: its derivative is symmetric
    np.testing.assert_allclose(found.by_q, found.by_q.T, atol=1e-10 * np.abs(found.by_q).max())
