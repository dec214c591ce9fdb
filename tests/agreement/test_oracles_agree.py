"""Closed chains against the dynamics of tests/oracles, which know neither Pinocchio nor cutjoint."""

from __future__ import annotations

import importlib
from types import ModuleType

import numpy as np
import pinocchio as pin
import pytest

from cutjoint.robots import load


@pytest.fixture
def oracle(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> ModuleType:
    """The module of tests/oracles that the test's name ends with."""
    monkeypatch.syspath_prepend(str(request.config.rootpath / "tests"))
    return importlib.import_module(f"oracles.{request.node.name.rsplit('_', 1)[-1]}")


def close_to(found: np.ndarray, wanted: np.ndarray, tolerance: float = 1e-10, least: float = 1.0) -> None:
    size = max(float(np.abs(wanted).max()), least)
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=tolerance * size)


def test_every_quantity_of_the_fourbar(oracle: ModuleType) -> None:
    chain, other, rng = load("fourbar"), oracle.FourBar(), np.random.default_rng(1)
    for angle in np.linspace(2.0, 8.2, 60):
        v, a, torque = rng.normal(size=3) * (5.0, 50.0, 2.0)
        at = chain.close([angle], limits="ignore")
        terms = chain.terms(at, [v])
        mass, coriolis, gravity = other.terms(angle, v)
        close_to(terms.mass[0], np.array([mass]), least=1e-3)
        close_to(terms.coriolis, np.array([coriolis]), least=1e-3)
        close_to(terms.gravity, np.array([gravity]), least=1e-2)
        close_to(chain.inverse_dynamics(at, [v], [a]), np.array([other.inverse_dynamics(angle, v, a)]), least=1e-2)
        close_to(chain.forward_dynamics(at, [v], [torque]), np.array([other.forward_dynamics(angle, v, torque)]))
        close_to(chain.tool(at).position, other.tool(angle), 1e-12)
        assert chain.potential_energy(at) == pytest.approx(other.potential_energy(angle), abs=1e-11)
        speeds, changes = chain.full_velocity(at, [v]), chain.tangent(at) @ [a] + chain.drift(at, [v])
        for name, (_, rate, change) in other.joints(angle, v, a).items():
            index = chain.model.idx_vs[chain.model.getJointId(name)]
            close_to(speeds[index], np.array(rate))
            close_to(changes[index], np.array(change))


def test_every_quantity_of_the_fivebar(oracle: ModuleType) -> None:
    chain, other, rng = load("fivebar"), oracle.FiveBar(), np.random.default_rng(2)
    for _ in range(60):
        q = chain.home.q + rng.uniform(-0.25, 0.25, 2)
        v, a, torque = 5.0 * rng.normal(size=2), 50.0 * rng.normal(size=2), 3.0 * rng.normal(size=2)
        at = chain.close(q)
        terms, wanted = chain.terms(at, v), other.terms(q, v)
        for found, right in zip((terms.mass, terms.coriolis, terms.gravity), wanted, strict=True):
            close_to(found, right, least=1e-2)
        close_to(chain.inverse_dynamics(at, v, a), other.inverse_dynamics(q, v, a))
        close_to(chain.forward_dynamics(at, v, torque), other.forward_dynamics(q, v, torque))
        close_to(chain.tool(at).position, other.tool(q), 1e-12)
        assert chain.potential_energy(at) == pytest.approx(other.potential_energy(q), abs=1e-11)


def test_every_quantity_of_the_stewart(oracle: ModuleType) -> None:
    chain, other, rng = load("stewart"), oracle.Stewart(), np.random.default_rng(3)
    index = chain.model.idx_vs[chain.model.getJointId("platform")]
    for _ in range(25):
        rotation = pin.exp3(rng.uniform(-0.2, 0.2, 3))
        position = np.array([0.0, 0.0, 0.48]) + rng.uniform(-0.05, 0.05, 3)
        motion = oracle.Motion(position, rotation, *(scale * rng.normal(size=3) for scale in (0.5, 1.5, 4.0, 10.0)))
        legs = [other.leg(i, motion) for i in range(6)]
        q, v, a = (np.array([leg.slide[k] for leg in legs]) for k in range(3))
        at = chain.close(q)
        pose = chain.link_placements(at)["platform_link"]
        np.testing.assert_allclose(pose[:3, 3], position, atol=1e-10)
        np.testing.assert_allclose(pose[:3, :3], rotation, atol=1e-10)
        twist = chain.full_velocity(at, v)[index : index + 6]
        close_to(rotation @ twist[:3], motion.velocity, 1e-9)
        close_to(rotation @ twist[3:], motion.spin, 1e-9)
        effort = chain.inverse_dynamics(at, v, a)
        close_to(effort, other.inverse_dynamics(motion), 1e-9)
        close_to(chain.forward_dynamics(at, v, other.inverse_dynamics(motion)), a, 1e-9)
