"""How a state is said: a posture, and where the loops may be open, or nothing is checked, a configuration."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from kit.shipped import DETERMINED

from cutjoint.chain import ClosedChain
from cutjoint.errors import ClosureError, InputError
from cutjoint.mechanism import Posture


def of_the_tree(chain: Any) -> dict[str, Any]:
    """What may be asked of an open tree: a posture says as much as its configuration."""
    return {
        "gap": chain.gap,
        "constraint_jacobian": chain.constraint_jacobian,
        "link_placements": lambda at: list(chain.link_placements(at).values()),
        "cut_placements": lambda at: [placement for _, *both in chain.cut_placements(at) for placement in both],
        "centre_of_mass": chain.centre_of_mass,
        "assemble": lambda at: chain.assemble(at).q_full,
    }


def of_a_posture(chain: Any) -> dict[str, Any]:
    """What only a closed robot has an answer to."""
    v, n = np.zeros(chain.nv), np.zeros(chain.n)
    return {
        "full_forward_dynamics": lambda at: chain.full_forward_dynamics(at, v, v),
        "full_inverse_dynamics": lambda at: chain.full_inverse_dynamics(at, v, v),
        "terms": chain.terms,
        "full_velocity": lambda at: chain.full_velocity(at, n),
        "mobility": chain.mobility,
    }


@pytest.mark.parametrize("name", DETERMINED)
def test_a_state_is_a_posture_and_where_loops_may_be_open_a_configuration_too(name: str, kit: Any) -> None:
    chain, rng = kit.robot(name), np.random.default_rng(3)
    for state in kit.random_states(chain, 3):
        opened = chain.integrate(state.at.q_full, 0.1 * rng.normal(size=chain.nv))
        assert max(chain.gap(opened)) > 1e-3
        for call in of_the_tree(chain).values():
            np.testing.assert_array_equal(call(state.at), call(state.at.q_full))
        for what in ("gap", "link_placements", "centre_of_mass"):
            given, closed = of_the_tree(chain)[what](opened), of_the_tree(chain)[what](state.at)
            assert np.abs(np.subtract(given, closed)).max() > 1e-4
        np.testing.assert_array_equal(chain.posture(state.at).q_full, state.at.q_full)
        for call in of_a_posture(chain).values():
            call(state.at)
            with pytest.raises(
                InputError, match=r"must be a Posture( or None)?, found an array|a posture is wanted.*found array"
            ):
                call(state.at.q_full)
            with pytest.raises(InputError, match=r"leaves cut .* open by"):
                call(Posture(state.at.q, opened))


@pytest.mark.parametrize("seed", range(8))
def test_the_posture_of_another_robot_is_refused_but_as_a_start(seed: int, kit: Any) -> None:
    """Its numbers are no state of this one, though they are as many: only what closes takes them."""
    rng = np.random.default_rng(seed)
    rods, home = np.array([0.2, 0.4, 0.3]), (1.0, -0.5, 1.2)
    chain, other = (
        ClosedChain(kit.planar_fourbar(tuple(rods * rng.uniform(0.95, 1.05, 3)), 0.5, home)) for _ in range(2)
    )
    calls = of_the_tree(chain) | of_a_posture(chain)
    closed = calls.pop("assemble")(other.home)
    assert max(chain.gap(closed)) < 1e-12
    for call in calls.values():
        with pytest.raises(InputError, match=r"leaves cut .* open by"):
            call(other.home)
    with pytest.raises(ClosureError):
        chain.posture(other.home)
