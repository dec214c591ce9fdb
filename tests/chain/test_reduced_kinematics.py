"""Tangent map, tool Jacobian, drifts and projection of every robot whose actuators determine its motion, against finite
differences along closed postures."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from kit.shipped import DETERMINED

from cutjoint.chain import ClosedChain
from cutjoint.description import catalogue
from cutjoint.errors import ClosureError, InputError

H = 1e-5


def moved(chain: ClosedChain, state: Any, t: float) -> Any:
    """The posture after the time t of a motion with constant actuator acceleration."""
    return chain.close(state.at.q + t * state.v + 0.5 * t * t * state.a, state.at)


@pytest.mark.parametrize("name", DETERMINED)
def test_tangent_map_is_the_derivative_of_closing(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    for state in kit.random_states(chain, 3):
        tangent = chain.tangent(state.at)
        assert np.abs(chain.constraint_jacobian(state.at) @ tangent).max() < 1e-11
        for k, unit in enumerate(np.eye(chain.n)):
            ahead, behind = (chain.close(state.at.q + s * H * unit, state.at) for s in (1, -1))
            slope = pin.difference(chain.model, behind.q_full.copy(), ahead.q_full.copy()) / (2 * H)
            np.testing.assert_allclose(tangent[:, k], slope, atol=1e-7)
        np.testing.assert_allclose(chain.full_velocity(state.at, state.v), tangent @ state.v, atol=1e-14)
        np.testing.assert_array_equal(chain.actuated_velocity(tangent @ state.v), state.v)


@pytest.mark.parametrize("name", DETERMINED)
def test_drift_is_the_acceleration_that_actuators_do_not_tell(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    for state in kit.random_states(chain, 3):
        ahead, behind = (moved(chain, state, s * H) for s in (1, -1))
        speeds = [
            np.array(chain.full_velocity(at, state.v + s * H * state.a)) for at, s in ((ahead, 1.0), (behind, -1.0))
        ]
        found = chain.tangent(state.at) @ state.a + chain.drift(state.at, state.v)
        size = max(1.0, float(np.abs(found).max()))
        np.testing.assert_allclose(found, (speeds[0] - speeds[1]) / (2 * H), atol=1e-6 * size)


@pytest.mark.parametrize("name", DETERMINED)
def test_tool_jacobian_and_its_drift(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    for state in kit.random_states(chain, 4):
        tool = chain.tool(state.at, state.v)
        assert np.array_equal(chain.tool(state.at).jacobian, tool.jacobian)
        assert np.array_equal(chain.tool(state.at).drift, np.zeros(3))
        for k, unit in enumerate(np.eye(chain.n)):
            ahead, behind = (chain.tool(chain.close(state.at.q + s * H * unit, state.at)).position for s in (1, -1))
            np.testing.assert_allclose(tool.jacobian[:, k], (ahead - behind) / (2 * H), atol=1e-8)
        h = 1e-4
        ahead, behind = (chain.tool(moved(chain, state, s * h)).position for s in (1, -1))
        acceleration = (ahead - 2.0 * tool.position + behind) / h**2
        wanted = tool.jacobian @ state.a + tool.drift
        np.testing.assert_allclose(wanted, acceleration, atol=2e-5 * max(1.0, float(np.abs(wanted).max())))


@pytest.mark.parametrize("name", DETERMINED)
def test_tool_is_where_its_link_is(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    frame = chain.description.tool
    for state in kit.random_states(chain, 2):
        wanted = chain.link_placements(state.at)[frame.link] @ frame.placement
        np.testing.assert_allclose(chain.tool(state.at).position, wanted[:3, 3], atol=1e-13)


@pytest.mark.parametrize("name", catalogue.names())
def test_projection_closes_and_keeps_what_it_should(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    rng = np.random.default_rng(6)
    for state in kit.random_states(chain, 3):
        q = chain.integrate(state.at.q_full, 1e-4 * rng.normal(size=chain.nv))
        v = state.v_full + 1e-3 * rng.normal(size=chain.nv)
        closed, speed = chain.project(q, v)
        assert max(chain.gap(closed)) < 1e-12
        assert np.abs(chain.constraint_jacobian(closed) @ speed).max() < 1e-10
        assert np.abs(pin.difference(chain.model, q, np.array(closed))).max() < 1e-2
        assert np.abs(speed - v).max() < 0.1
        if chain.mobility().determined:
            np.testing.assert_allclose(chain.actuated(closed), chain.actuated(q), atol=1e-13)
            np.testing.assert_allclose(chain.actuated_velocity(speed), chain.actuated_velocity(v), atol=1e-13)
        again, same = chain.project(closed, speed)
        np.testing.assert_allclose(again, closed, atol=1e-12)
        np.testing.assert_allclose(same, speed, atol=1e-9)


def test_projection_from_far_away_is_refused(kit: Any) -> None:
    chain = kit.robot("omega3")
    q = np.array(chain.home.q_full)
    q[1] += 2.0
    with pytest.raises(ClosureError) as caught:
        chain.project(q, np.zeros(chain.nv))
    assert caught.value.gap[0] > 0.01
    assert caught.value.cut.startswith("ball")


def test_wrong_arguments_name_themselves(kit: Any) -> None:
    chain = kit.robot("cpm")
    at = chain.home
    nan = [0.0, float("nan"), 0.0]
    for call, word in (
        (lambda: chain.tool(at, [1.0, 2.0]), "v"),
        (lambda: chain.terms(at, nan), "v"),
        (lambda: chain.full_velocity(at, "fast"), "v"),
        (lambda: chain.inverse_dynamics(at, [0, 0, 0], [0, 0]), "a"),
        (lambda: chain.inverse_dynamics(at, nan, [0, 0, 0]), "v"),
        (lambda: chain.forward_dynamics(at, [0, 0, 0], nan), "effort"),
        (lambda: chain.forward_dynamics(at, [0, 0, 0], np.zeros((3, 1))), "effort"),
        (lambda: chain.close(nan), "q"),
        (lambda: chain.close([1.0]), "q"),
        (lambda: chain.reach(nan), "target"),
        (lambda: chain.reach([0.1, 0.2]), "a target"),
        (lambda: chain.reach("there"), "a pose"),
        (lambda: chain.posture(at.q), "q_full"),
        (lambda: chain.assemble(at.q_full * np.nan), "q_full"),
        (lambda: chain.with_payload(-1.0), "payload"),
        (lambda: chain.with_payload(float("inf")), "payload"),
    ):
        with pytest.raises(InputError, match=rf"^{word}\b"):
            call()


@pytest.mark.parametrize("name", ["cpm", "fourbar"])
def test_wrong_full_coordinates_name_themselves(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    at, v, short = chain.home, np.zeros(chain.nv), np.zeros(2)
    for call, word in (
        (lambda: chain.full_forward_dynamics(at, short, v), "v_full"),
        (lambda: chain.full_forward_dynamics(at, v, short), "effort_full"),
        (lambda: chain.full_inverse_dynamics(at, v, short), "a_full"),
        (lambda: chain.gap(at.q_full * np.nan), "q_full"),
        (lambda: chain.gap(short), "q_full"),
        (lambda: chain.constraint_jacobian(short), "q_full"),
        (lambda: chain.link_placements(short), "q_full"),
        (lambda: chain.cut_placements(short), "q_full"),
        (lambda: chain.centre_of_mass(short), "q_full"),
    ):
        with pytest.raises(InputError, match=rf"^{word}\b"):
            call()
